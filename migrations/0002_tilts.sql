-- Directions of a part's mesh that must stand within an angle of straight up, beside its orientation rule: 'x,y,z:degrees' with
-- ';' between them, '' = none.
ALTER TABLE part ADD COLUMN tilts TEXT NOT NULL DEFAULT '';
