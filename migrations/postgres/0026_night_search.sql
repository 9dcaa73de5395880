-- An open build that waits is lowered further in rounds.
CREATE TABLE night_search (
    build_id BIGINT PRIMARY KEY NOT NULL REFERENCES build (id),
    problem TEXT COLLATE "C" NOT NULL,
    state TEXT COLLATE "C" NOT NULL CHECK (state IN ('goes-on', 'stands-still', 'used-up', 'given-up')),
    round BIGINT NOT NULL,
    round_cpu_secs DOUBLE PRECISION NOT NULL,
    round_height_mm DOUBLE PRECISION NOT NULL,
    cpu_secs DOUBLE PRECISION NOT NULL,
    first_height_mm DOUBLE PRECISION NOT NULL,
    starts BIGINT NOT NULL,
    pool TEXT COLLATE "C" NOT NULL
);

COMMENT ON TABLE night_search IS 'A row is how far the search of an open build that waits has come; it goes when the build fires.';
COMMENT ON COLUMN night_search.problem IS 'BLAKE3 of the copies and rules that it is for: others begin anew';
COMMENT ON COLUMN night_search.state IS 'goes-on, stands-still, used-up, given-up';
COMMENT ON COLUMN night_search.round IS 'from 0; each round has twice the CPU time of the one before';
COMMENT ON COLUMN night_search.round_cpu_secs IS 'CPU seconds that this round has taken so far';
COMMENT ON COLUMN night_search.round_height_mm IS 'height of the layout at the begin of the round, mm';
COMMENT ON COLUMN night_search.cpu_secs IS 'CPU seconds of all rounds since the last arrival';
COMMENT ON COLUMN night_search.first_height_mm IS 'height of the layout after the search for the last arrival, mm';
COMMENT ON COLUMN night_search.starts IS 'searches that were started since the last one that ended';
COMMENT ON COLUMN night_search.pool IS 'JSON: layouts to go on from, the lowest first';
