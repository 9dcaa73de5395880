-- The file of a machine, with the defaults of its farm, as its node has it: all nodes show and plan its machines by it.
ALTER TABLE station ADD COLUMN profile TEXT NOT NULL DEFAULT '';  -- TOML; '' = its node has not said it
