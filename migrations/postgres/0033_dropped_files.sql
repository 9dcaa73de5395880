-- A file that a sync program puts back has the folder, the name, the bytes and the time of one that was taken; a new drop has another time.
ALTER TABLE part ADD COLUMN file_folder TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.file_folder IS 'folders between the hot folder and the file as it was dropped, joined by /; empty = right in the hot folder, or not known';
ALTER TABLE part ADD COLUMN file_mtime_ns BIGINT;
COMMENT ON COLUMN part.file_mtime_ns IS 'modification time of the file as it was dropped, nanoseconds since 1970; NULL = it did not come through a folder, or was taken before this was noted';
