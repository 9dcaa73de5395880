-- When the first rename that publishes a build was about to be tried, UTC. A staged file that is gone after that was published;
-- one that is gone before was removed by somebody, and is written again.
ALTER TABLE build ADD COLUMN publishing_at TEXT;
-- Nobody knows of the builds that are proved now whether it was tried: they count as tried, so that none appears twice.
UPDATE build SET publishing_at = verified_at WHERE state = 'verified';
-- BLAKE3 of what is staged beside the build file: JSON, [[name, 64 hex digits], ...]; NULL = not known.
ALTER TABLE build ADD COLUMN sidecars TEXT;
-- When it was found that the stored file does not hold what was dropped, UTC; NULL = all is well. The part waits until the same
-- file is dropped again.
ALTER TABLE part ADD COLUMN damaged_at TEXT;
CREATE INDEX part_damaged ON part (content_hash) WHERE damaged_at IS NOT NULL;

-- A row is a dropped file that was taken in place of a damaged one: it is no order of its own.
CREATE TABLE replacement (
    claim        TEXT    PRIMARY KEY NOT NULL,      -- name of its claim: unique per dropped file
    part_id      INTEGER NOT NULL REFERENCES part (id),
    content_hash TEXT    NOT NULL,                  -- BLAKE3 of the file, 64 hex digits
    taken_at     TEXT    NOT NULL                   -- UTC
) STRICT, WITHOUT ROWID;
