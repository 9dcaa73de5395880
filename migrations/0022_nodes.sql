-- A ledger on a server may be shared by several nodes: daemons on different servers, each of which serves machines of its own. A ledger
-- in a file has one node.
CREATE TABLE node (
    name       TEXT    PRIMARY KEY NOT NULL,        -- node.name of its configuration
    pid        INTEGER NOT NULL,
    host       TEXT    NOT NULL,
    version    TEXT    NOT NULL,
    started_at TEXT    NOT NULL,                    -- UTC
    beat_at    TEXT    NOT NULL,                    -- UTC; an old beat means that it does not run
    status     TEXT    NOT NULL DEFAULT '',         -- one line
    address    TEXT    NOT NULL DEFAULT ''          -- where other nodes reach its pages, '' = they cannot
) STRICT;
INSERT INTO node (name, pid, host, version, started_at, beat_at, status)
SELECT host, pid, host, version, started_at, beat_at, status FROM daemon;
DROP TABLE daemon;

-- The node that serves the machine, '' = not known yet.
ALTER TABLE station ADD COLUMN node TEXT NOT NULL DEFAULT '';
