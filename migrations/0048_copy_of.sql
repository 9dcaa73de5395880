-- A file that comes now asks whether a copy of it came before: found by name, and not by reading the names of all that wait.
-- Name of the file of which this one is a copy, as its name says, '' = of none.
ALTER TABLE part ADD COLUMN copy_of TEXT NOT NULL DEFAULT '';
CREATE INDEX part_by_original ON part (copy_of) WHERE copy_of <> '';
