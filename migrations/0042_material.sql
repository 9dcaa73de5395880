-- Material is a fact of parts, machines and builds. Until now a list's material stood in the notes of its parts; a part that is being
-- built keeps it there only.
ALTER TABLE part ADD COLUMN material TEXT NOT NULL DEFAULT '';            -- what it is to be made of, '' = any
ALTER TABLE part ADD COLUMN material_key TEXT NOT NULL DEFAULT '';        -- the same without case, spaces, hyphens and underscores: by this it is compared
ALTER TABLE part ADD COLUMN awaits_material INTEGER NOT NULL DEFAULT 0;   -- of a waiting part: whether its machine has another material loaded, or none
ALTER TABLE build ADD COLUMN material TEXT NOT NULL DEFAULT '';           -- what was loaded when it fired, '' = not known, or it has not fired

-- What is loaded in a machine. One without a row, or with '', takes parts without a material only.
CREATE TABLE loaded_material (
    machine       TEXT PRIMARY KEY,
    material      TEXT NOT NULL,
    material_key  TEXT NOT NULL,             -- as in part
    loaded_by     TEXT NOT NULL DEFAULT '',  -- user@host; '' = its file says so
    loaded_at     TEXT NOT NULL              -- UTC
) STRICT;

UPDATE part SET material = substr('; ' || note || '; ', instr('; ' || note, '; material: ') + 12)
    WHERE instr('; ' || note, '; material: ') > 0 AND NOT EXISTS (
    SELECT 1 FROM placement l JOIN build b ON b.id = l.build_id WHERE l.part_id = part.id AND b.published_at IS NULL);
UPDATE part SET material = trim(substr(material, 1, instr(material, '; ') - 1)) WHERE material <> '';
UPDATE part SET material_key = lower(replace(replace(replace(material, ' ', ''), '-', ''), '_', '')) WHERE material <> '';
UPDATE part SET awaits_material = 1 WHERE material_key <> '' AND state = 'waiting';
