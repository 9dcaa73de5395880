-- A file that comes now asks whether a copy of it came before: found by name, and not by reading the names of all that wait.
ALTER TABLE part ADD COLUMN copy_of TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.copy_of IS 'name of the file of which this one is a copy, as its name says, '''' = of none';
CREATE INDEX part_by_original ON part (copy_of) WHERE copy_of <> '';
