-- Parts are dyed, smoothed, blasted after the print: which steps, and who said of each that it is done.
ALTER TABLE part ADD COLUMN finish TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.finish IS 'finishing steps after the print, separated by '', '', '''' = none';
CREATE TABLE finished_step (
    part_id BIGINT NOT NULL REFERENCES part (id),
    step TEXT COLLATE "C" NOT NULL,
    told_by TEXT COLLATE "C" NOT NULL,
    told_at TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (part_id, step)
);
COMMENT ON TABLE finished_step IS 'A row is a finishing step of a part that somebody said is done.';
COMMENT ON COLUMN finished_step.step IS 'as the finish of its part names it';
COMMENT ON COLUMN finished_step.told_by IS 'user@host';
COMMENT ON COLUMN finished_step.told_at IS 'UTC';
