-- What a part's file is read in again, and compared with: a size never changes because the unit of a machine's file did.
ALTER TABLE part ADD COLUMN read_unit TEXT;                           -- Unit of a file that states none: its machine's when it was dropped or first read. NULL = not read yet, or by an earlier nestd.
ALTER TABLE part ADD COLUMN size_differs INTEGER NOT NULL DEFAULT 0;  -- Whether its file was read in another size than the first time. It waits for a person.
-- The unit of its machine when a line was judged and taken. NULL = an earlier nestd took it.
ALTER TABLE ordered_line ADD COLUMN read_unit TEXT;
-- Since when a part waits that came back: copies were put back or more were wanted of what was built, or it was taken back. NULL = since it was claimed.
ALTER TABLE part ADD COLUMN waits_since TEXT;
