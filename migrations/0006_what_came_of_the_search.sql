-- What the search and the proof of a build found out, which pages show when its report has left the queue folder.
-- How the height fell: JSON, [[wall seconds, height in mm], ...]; NULL until verified.
ALTER TABLE build ADD COLUMN curve TEXT;
-- As which copy it is drawn out of the cake, from 1, and on which straight line (a unit vector in the machine's frame); NULL = not
-- proved.
ALTER TABLE placement ADD COLUMN drawn INTEGER;
ALTER TABLE placement ADD COLUMN way_x REAL;
ALTER TABLE placement ADD COLUMN way_y REAL;
ALTER TABLE placement ADD COLUMN way_z REAL;
