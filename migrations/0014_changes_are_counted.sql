-- How many changes of the ledger were committed. After each commit the same number is noted in a file beside the ledger: one that
-- counts fewer than its note has lost its write-ahead log, or the end of it.
CREATE TABLE change_count (
    id         INTEGER PRIMARY KEY CHECK (id = 1),
    changes    INTEGER NOT NULL
) STRICT;
INSERT INTO change_count (id, changes) VALUES (1, 0);
