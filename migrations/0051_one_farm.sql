-- What the nodes of a farm know together: the secret with which they make the keys of forms, so that a page of one can be sent to another,
-- and what each asks people to see to.
CREATE TABLE farm_secret (
    name   TEXT PRIMARY KEY NOT NULL,
    secret TEXT NOT NULL               -- 64 hex digits, chosen by chance
) STRICT, WITHOUT ROWID;
ALTER TABLE node ADD COLUMN alerts TEXT NOT NULL DEFAULT '[]';  -- JSON: its alerts, as its state folder holds them
