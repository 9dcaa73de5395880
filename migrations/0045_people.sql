-- People who use the pages, and the browsers in which they have signed in.
CREATE TABLE person (
    name           TEXT PRIMARY KEY,            -- as events name him
    folded         TEXT NOT NULL UNIQUE,        -- the name in lower case: by this it is compared
    role           TEXT NOT NULL CHECK (role IN ('read', 'order', 'operate', 'admin')),
    password_hash  TEXT NOT NULL DEFAULT '',    -- Argon2id of the password, '' = a proxy says who it is
    pin_hash       TEXT NOT NULL DEFAULT '',    -- Argon2id of the PIN, '' = none
    added_by       TEXT NOT NULL,               -- user@host
    added_at       TEXT NOT NULL,               -- UTC
    signed_in_at   TEXT                         -- UTC, when he last gave his password, NULL = not yet
) STRICT;

CREATE TABLE session (
    token_hash  TEXT PRIMARY KEY,                    -- BLAKE3 of the token in the cookie
    person      TEXT REFERENCES person (name),       -- who uses the device, NULL = nobody just now; it is shared
    opened_by   TEXT NOT NULL REFERENCES person (name), -- who last gave a password on the device
    is_shared   INTEGER NOT NULL,                    -- whether others may go on there with their PIN
    with_pin    INTEGER NOT NULL,                    -- whether the person gave a PIN
    wrong_pins  INTEGER NOT NULL DEFAULT 0,          -- wrong PINs since the last right one
    opened_at   TEXT NOT NULL,                       -- UTC, when the password was given
    seen_at     TEXT NOT NULL                        -- UTC, when the person did something there, to a minute
) STRICT;
CREATE INDEX session_by_person ON session (person);
CREATE INDEX session_by_opener ON session (opened_by);
