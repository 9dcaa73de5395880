-- A standby that takes the place of its server may lack the last changes, and nodes are upgraded one after the other.
CREATE TABLE lease_change (
    name TEXT COLLATE "C" PRIMARY KEY NOT NULL,
    changes BIGINT NOT NULL CHECK (changes >= 0)
);
COMMENT ON TABLE lease_change IS 'How many changes the owners of a lease have committed. One who knows of more sees that the database has lost some.';
COMMENT ON COLUMN lease_change.name IS 'name of the lease';
COMMENT ON COLUMN lease_change.changes IS 'number of changes';

CREATE TABLE repair_due (
    node TEXT COLLATE "C" PRIMARY KEY NOT NULL
);
COMMENT ON TABLE repair_due IS 'Nodes whose last changes the database has lost, or may have lost. Until their folders were compared with it, no node changes it.';
COMMENT ON COLUMN repair_due.node IS 'name of the node';

ALTER TABLE lease ADD COLUMN newest_schema BIGINT NOT NULL DEFAULT 24;
COMMENT ON COLUMN lease.newest_schema IS 'the newest schema that the owner''s nestd knows';

CREATE TABLE schema_range (
    usable_from BIGINT NOT NULL
);
COMMENT ON TABLE schema_range IS 'One row: which nestd can use this ledger.';
COMMENT ON COLUMN schema_range.usable_from IS 'a nestd whose newest schema is this one or a newer one can; what was added since is of no concern to it';
INSERT INTO schema_range (usable_from) VALUES (25);
