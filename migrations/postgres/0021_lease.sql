-- Which daemon serves the ledger. A farm in a file has a lock file instead.
CREATE TABLE lease (
    name TEXT COLLATE "C" PRIMARY KEY NOT NULL,
    owner TEXT COLLATE "C" NOT NULL,
    epoch BIGINT NOT NULL CHECK (epoch >= 1),
    until TIMESTAMPTZ NOT NULL
);

COMMENT ON TABLE lease IS 'A row is a right that one process has at a time: "daemon" is to serve the ledger.';
COMMENT ON COLUMN lease.name IS 'which right';
COMMENT ON COLUMN lease.owner IS 'server and state folder of the process that has it or had it last';
COMMENT ON COLUMN lease.epoch IS 'grows with each owner: a change of an earlier one is refused';
COMMENT ON COLUMN lease.until IS 'when it ends unless it is renewed, by the clock of this database';
