-- People who use the pages, and the browsers in which they have signed in.
CREATE TABLE person (
    name           TEXT COLLATE "C" PRIMARY KEY,
    folded         TEXT COLLATE "C" NOT NULL UNIQUE,
    role           TEXT COLLATE "C" NOT NULL CHECK (role IN ('read', 'order', 'operate', 'admin')),
    password_hash  TEXT COLLATE "C" NOT NULL DEFAULT '',
    pin_hash       TEXT COLLATE "C" NOT NULL DEFAULT '',
    added_by       TEXT COLLATE "C" NOT NULL,
    added_at       TEXT COLLATE "C" NOT NULL,
    signed_in_at   TEXT COLLATE "C"
);
COMMENT ON TABLE person IS 'A person who uses the pages.';
COMMENT ON COLUMN person.name IS 'as events name him';
COMMENT ON COLUMN person.folded IS 'the name in lower case: by this it is compared';
COMMENT ON COLUMN person.role IS 'what he may do';
COMMENT ON COLUMN person.password_hash IS 'Argon2id of the password, '''' = a proxy says who it is';
COMMENT ON COLUMN person.pin_hash IS 'Argon2id of the PIN, '''' = none';
COMMENT ON COLUMN person.added_by IS 'user@host';
COMMENT ON COLUMN person.added_at IS 'UTC';
COMMENT ON COLUMN person.signed_in_at IS 'UTC, when he last gave his password, NULL = not yet';

CREATE TABLE session (
    token_hash  TEXT COLLATE "C" PRIMARY KEY,
    person      TEXT COLLATE "C" REFERENCES person (name),
    opened_by   TEXT COLLATE "C" NOT NULL REFERENCES person (name),
    is_shared   BOOLEAN NOT NULL,
    with_pin    BOOLEAN NOT NULL,
    wrong_pins  BIGINT NOT NULL DEFAULT 0,
    opened_at   TEXT COLLATE "C" NOT NULL,
    seen_at     TEXT COLLATE "C" NOT NULL
);
CREATE INDEX session_by_person ON session (person);
CREATE INDEX session_by_opener ON session (opened_by);
COMMENT ON TABLE session IS 'A browser in which a person has signed in.';
COMMENT ON COLUMN session.token_hash IS 'BLAKE3 of the token in the cookie';
COMMENT ON COLUMN session.person IS 'who uses the device, NULL = nobody just now; it is shared';
COMMENT ON COLUMN session.opened_by IS 'who last gave a password on the device';
COMMENT ON COLUMN session.is_shared IS 'whether others may go on there with their PIN';
COMMENT ON COLUMN session.with_pin IS 'whether the person gave a PIN';
COMMENT ON COLUMN session.wrong_pins IS 'wrong PINs since the last right one';
COMMENT ON COLUMN session.opened_at IS 'UTC, when the password was given';
COMMENT ON COLUMN session.seen_at IS 'UTC, when the person did something there, to a minute';
