-- A file that a sync program puts back has the folder, the name, the bytes and the time of one that was taken; a new drop has another time.

-- Folders between the hot folder and the file as it was dropped, joined by '/'. '' = right in the hot folder, or not known.
ALTER TABLE part ADD COLUMN file_folder TEXT NOT NULL DEFAULT '';
-- Modification time of the file as it was dropped, nanoseconds since 1970. NULL = it did not come through a folder, or was taken before this was noted.
ALTER TABLE part ADD COLUMN file_mtime_ns INTEGER;
