-- What those who watch the farm count and look at.
-- Why something was refused, as one of few words: texts are for people, and nothing counts by them. '' = no refusal, or one from
-- before this column.
ALTER TABLE event ADD COLUMN cause TEXT NOT NULL DEFAULT '';
-- What is counted of events.
CREATE INDEX event_counted ON event (kind, profile, cause) WHERE kind IN ('rejected', 'refused', 'proof_failed');

-- A row is a machine as the daemon that serves it sees it.
CREATE TABLE station (
    profile           TEXT    PRIMARY KEY NOT NULL,
    scanned_at        TEXT,                         -- UTC, when its hot folder was last looked through; NULL = never
    is_inbox_there    INTEGER NOT NULL,             -- whether its hot folder can be used
    is_queue_writable INTEGER NOT NULL,             -- whether its queue folder can be written to
    trouble           TEXT    NOT NULL DEFAULT '',  -- why it is unavailable, '' = it is not
    trouble_at        TEXT                          -- UTC, since when, NULL = it is available
) STRICT, WITHOUT ROWID;
