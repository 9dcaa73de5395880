-- A final search may be cut into lanes, which several nodes search.
ALTER TABLE node ADD COLUMN lanes BIGINT NOT NULL DEFAULT 0;

CREATE TABLE lane_search (
    id BIGINT PRIMARY KEY NOT NULL,
    build_id BIGINT NOT NULL UNIQUE REFERENCES build (id),
    problem TEXT COLLATE "C" NOT NULL,
    plan TEXT COLLATE "C" NOT NULL
);

CREATE TABLE lane (
    search_id BIGINT NOT NULL REFERENCES lane_search (id) ON DELETE CASCADE,
    round BIGINT NOT NULL,
    lane BIGINT NOT NULL,
    task TEXT COLLATE "C" NOT NULL,
    epoch BIGINT NOT NULL DEFAULT 0,
    node TEXT COLLATE "C" NOT NULL DEFAULT '',
    result TEXT COLLATE "C",
    PRIMARY KEY (search_id, round, lane)
);

COMMENT ON COLUMN node.lanes IS 'lanes that it offers now';
COMMENT ON TABLE lane_search IS 'A row is a final search in lanes; it goes when its build leaves the state nesting.';
COMMENT ON COLUMN lane_search.id IS 'a random number: no search is taken for another one';
COMMENT ON COLUMN lane_search.problem IS 'JSON: the instance, its meshes by BLAKE3, and the settings of the search';
COMMENT ON COLUMN lane_search.plan IS 'JSON: number of lanes and rounds, evaluations, seed';
COMMENT ON TABLE lane IS 'A row is one round of one lane.';
COMMENT ON COLUMN lane.round IS 'from 0';
COMMENT ON COLUMN lane.lane IS 'from 0';
COMMENT ON COLUMN lane.task IS 'JSON: layout to start from, seed, evaluations';
COMMENT ON COLUMN lane.epoch IS 'how often it was taken: what an earlier taker found is not accepted';
COMMENT ON COLUMN lane.node IS 'the node that has it, empty = none';
COMMENT ON COLUMN lane.result IS 'JSON: the layout that was found, NULL = none yet';
