-- Material is a fact of parts, machines and builds. Until now a list's material stood in the notes of its parts; a part that is being
-- built keeps it there only.
ALTER TABLE part ADD COLUMN material TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.material IS 'what it is to be made of, '''' = any';
ALTER TABLE part ADD COLUMN material_key TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.material_key IS 'the same without case, spaces, hyphens and underscores: by this it is compared';
ALTER TABLE part ADD COLUMN awaits_material BOOLEAN NOT NULL DEFAULT FALSE;
COMMENT ON COLUMN part.awaits_material IS 'of a waiting part: whether its machine has another material loaded, or none';
ALTER TABLE build ADD COLUMN material TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN build.material IS 'what was loaded when it fired, '''' = not known, or it has not fired';

CREATE TABLE loaded_material (
    machine       TEXT COLLATE "C" PRIMARY KEY,
    material      TEXT COLLATE "C" NOT NULL,
    material_key  TEXT COLLATE "C" NOT NULL,
    loaded_by     TEXT COLLATE "C" NOT NULL DEFAULT '',
    loaded_at     TEXT COLLATE "C" NOT NULL
);
COMMENT ON TABLE loaded_material IS 'What is loaded in a machine. One without a row, or with '''', takes parts without a material only.';
COMMENT ON COLUMN loaded_material.material_key IS 'as in part';
COMMENT ON COLUMN loaded_material.loaded_by IS 'user@host; '''' = its file says so';
COMMENT ON COLUMN loaded_material.loaded_at IS 'UTC';

UPDATE part SET material = trim(split_part(substr('; ' || note, strpos('; ' || note, '; material: ') + 12), '; ', 1))
    WHERE strpos('; ' || note, '; material: ') > 0 AND NOT EXISTS (
    SELECT 1 FROM placement l JOIN build b ON b.id = l.build_id WHERE l.part_id = part.id AND b.published_at IS NULL);
UPDATE part SET material_key = lower(replace(replace(replace(material, ' ', ''), '-', ''), '_', '')) WHERE material <> '';
UPDATE part SET awaits_material = TRUE WHERE material_key <> '' AND state = 'waiting';
