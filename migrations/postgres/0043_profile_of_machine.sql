-- The file of a machine, with the defaults of its farm, as its node has it: all nodes show and plan its machines by it.
ALTER TABLE station ADD COLUMN profile TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN station.profile IS 'TOML; '''' = its node has not said it';
