-- Orders that come by request. A row is a request that was carried out, under the key that its client gave it: the same key with the same
-- request is answered with the same answer, with another request it is refused.
CREATE TABLE request_key (
    client       TEXT NOT NULL,   -- name of the token, or where the request came from
    key          TEXT NOT NULL,   -- the header Idempotency-Key
    fingerprint  TEXT NOT NULL,   -- BLAKE3 of what was asked, 64 hex digits
    answer       TEXT NOT NULL,   -- JSON that was answered
    answered_at  TEXT NOT NULL,   -- UTC
    PRIMARY KEY (client, key)
) STRICT;
CREATE INDEX request_key_age ON request_key (answered_at);

-- A row is a line of such an order: a file that was put, and what was asked with it. Its claim is put together from the row until the ledger
-- has a part of that claim.
CREATE TABLE ordered_line (
    claim         TEXT PRIMARY KEY,  -- made of the client, its key and the request, so that a line has one claim for ever
    client        TEXT NOT NULL,     -- who ordered it
    profile       TEXT NOT NULL,     -- machine profile
    order_name    TEXT NOT NULL,     -- the order that the line belongs to
    name          TEXT NOT NULL,     -- file name
    content_hash  TEXT NOT NULL,     -- BLAKE3 of the file, 64 hex digits
    copies        INTEGER NOT NULL,  -- copies ordered
    ticket        TEXT NOT NULL,     -- what was asked with it, as a ticket in JSON
    ordered_at    TEXT NOT NULL,     -- UTC
    taken_at      TEXT               -- UTC: when its part was recorded
) STRICT;
CREATE INDEX ordered_line_arriving ON ordered_line (profile, ordered_at) WHERE taken_at IS NULL;
CREATE INDEX ordered_line_age ON ordered_line (ordered_at);
