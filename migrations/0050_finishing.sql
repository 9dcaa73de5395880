-- Parts are dyed, smoothed, blasted after the print: which steps, and who said of each that it is done.
ALTER TABLE part ADD COLUMN finish TEXT NOT NULL DEFAULT '';      -- finishing steps after the print, separated by ', ', '' = none

-- A row is a finishing step of a part that somebody said is done.
CREATE TABLE finished_step (
    part_id INTEGER NOT NULL REFERENCES part (id),
    step    TEXT    NOT NULL,                      -- as the finish of its part names it
    told_by TEXT    NOT NULL,                      -- user@host
    told_at TEXT    NOT NULL,                      -- UTC
    PRIMARY KEY (part_id, step)
) STRICT, WITHOUT ROWID;
