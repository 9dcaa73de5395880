-- What a customer's own system calls a line: the id of a model in a CAMSPEC package.
ALTER TABLE part ADD COLUMN reference TEXT NOT NULL DEFAULT '';   -- "" = none
