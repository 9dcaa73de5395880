-- What is told to others. The events are what there is to tell; each receiver has its place in them.
-- A row is a receiver that is configured.
CREATE TABLE receiver (
    name       TEXT    PRIMARY KEY NOT NULL CHECK (name IN ('webhook', 'command')),
    told_id    INTEGER NOT NULL,                    -- the latest event that it has been told, or that is not for it
    failing_at TEXT,                                -- UTC, since when it cannot be told, NULL = it can
    failure    TEXT    NOT NULL DEFAULT '',         -- why
    dropped    INTEGER NOT NULL DEFAULT 0           -- events that became too old before it could be told
) STRICT, WITHOUT ROWID;

-- When it was told that the part's due date is at risk, UTC; NULL = it was not.
ALTER TABLE part ADD COLUMN at_risk_at TEXT;
CREATE INDEX part_by_due ON part (due_at)
    WHERE due_at IS NOT NULL AND at_risk_at IS NULL AND state IN ('claimed', 'waiting', 'batched');
