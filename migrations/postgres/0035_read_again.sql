-- What a part's file is read in again, and compared with: a size never changes because the unit of a machine's file did.
ALTER TABLE part ADD COLUMN read_unit TEXT COLLATE "C";
COMMENT ON COLUMN part.read_unit IS 'unit of a file that states none: its machine''s when it was dropped or first read; NULL = not read yet, or by an earlier nestd';
ALTER TABLE part ADD COLUMN size_differs BOOLEAN NOT NULL DEFAULT FALSE;
COMMENT ON COLUMN part.size_differs IS 'whether its file was read in another size than the first time; it waits for a person';
ALTER TABLE ordered_line ADD COLUMN read_unit TEXT COLLATE "C";
COMMENT ON COLUMN ordered_line.read_unit IS 'unit of its machine when the line was judged and taken; NULL = an earlier nestd took it';
ALTER TABLE part ADD COLUMN waits_since TEXT COLLATE "C";
COMMENT ON COLUMN part.waits_since IS 'since when a part waits that came back: copies were put back or more were wanted of what was built, or it was taken back, UTC; NULL = since it was claimed';
