-- A ledger may be shared by several nodes: daemons on different servers, each of which serves machines of its own.
CREATE TABLE node (
    name TEXT COLLATE "C" PRIMARY KEY NOT NULL,
    pid BIGINT NOT NULL,
    host TEXT COLLATE "C" NOT NULL,
    version TEXT COLLATE "C" NOT NULL,
    started_at TEXT COLLATE "C" NOT NULL,
    beat_at TEXT COLLATE "C" NOT NULL,
    status TEXT COLLATE "C" NOT NULL DEFAULT '',
    address TEXT COLLATE "C" NOT NULL DEFAULT ''
);
INSERT INTO node (name, pid, host, version, started_at, beat_at, status)
SELECT host, pid, host, version, started_at, beat_at, status FROM daemon;
DROP TABLE daemon;

ALTER TABLE station ADD COLUMN node TEXT COLLATE "C" NOT NULL DEFAULT '';

COMMENT ON TABLE node IS 'A row is a daemon of the farm; an old beat means that it does not run.';
COMMENT ON COLUMN node.name IS 'node.name of its configuration';
COMMENT ON COLUMN node.address IS 'where other nodes reach its pages, empty = they cannot';
COMMENT ON COLUMN station.node IS 'the node that serves the machine, empty = not known yet';
COMMENT ON TABLE lease IS 'A row is a right that one process has at a time: "node NAME" to be that node, "ledger" to have the whole ledger alone, "duty NAME" to do what one node does for all.';
