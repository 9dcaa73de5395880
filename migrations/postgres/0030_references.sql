-- What a customer's own system calls a line: the id of a model in a CAMSPEC package.
ALTER TABLE part ADD COLUMN reference TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.reference IS 'what the system of a customer calls the line: the id of a model in a CAMSPEC package; empty = none';
