-- What tells that a ledger was overwritten inside its file while it was open, as SQLite's own restore does: it is of another line, counts
-- fewer changes than a process has seen, or its last change is another one of the same number.
ALTER TABLE change_count ADD COLUMN line INTEGER NOT NULL DEFAULT 0; -- random number of a ledger; one that is put back begins a new line
ALTER TABLE change_count ADD COLUMN stamp INTEGER NOT NULL DEFAULT 0; -- random number of the last change
UPDATE change_count SET line = random(), stamp = random();
