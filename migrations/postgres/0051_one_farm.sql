-- What the nodes of a farm know together: the secret with which they make the keys of forms, so that a page of one can be sent to another,
-- and what each asks people to see to.
CREATE TABLE farm_secret (
    name TEXT COLLATE "C" PRIMARY KEY NOT NULL,
    secret TEXT COLLATE "C" NOT NULL
);
COMMENT ON TABLE farm_secret IS 'What the nodes of a farm know together and nobody else.';
COMMENT ON COLUMN farm_secret.secret IS '64 hex digits, chosen by chance';
ALTER TABLE node ADD COLUMN alerts TEXT COLLATE "C" NOT NULL DEFAULT '[]';
COMMENT ON COLUMN node.alerts IS 'JSON: its alerts, as its state folder holds them';
