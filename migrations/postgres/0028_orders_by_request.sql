-- Orders that come by request.
CREATE TABLE request_key (
    client TEXT COLLATE "C" NOT NULL,
    key TEXT COLLATE "C" NOT NULL,
    fingerprint TEXT COLLATE "C" NOT NULL,
    answer TEXT COLLATE "C" NOT NULL,
    answered_at TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (client, key)
);
CREATE INDEX request_key_age ON request_key (answered_at);
COMMENT ON TABLE request_key IS 'A row is a request that was carried out, under the key that its client gave it: the same key with the same request is answered with the same answer, with another request it is refused.';
COMMENT ON COLUMN request_key.client IS 'name of the token, or where the request came from';
COMMENT ON COLUMN request_key.key IS 'the header Idempotency-Key';
COMMENT ON COLUMN request_key.fingerprint IS 'BLAKE3 of what was asked, 64 hex digits';
COMMENT ON COLUMN request_key.answer IS 'JSON that was answered';
COMMENT ON COLUMN request_key.answered_at IS 'UTC';

CREATE TABLE ordered_line (
    claim TEXT COLLATE "C" PRIMARY KEY,
    client TEXT COLLATE "C" NOT NULL,
    profile TEXT COLLATE "C" NOT NULL,
    order_name TEXT COLLATE "C" NOT NULL,
    name TEXT COLLATE "C" NOT NULL,
    content_hash TEXT COLLATE "C" NOT NULL,
    copies BIGINT NOT NULL,
    ticket TEXT COLLATE "C" NOT NULL,
    ordered_at TEXT COLLATE "C" NOT NULL,
    taken_at TEXT COLLATE "C"
);
CREATE INDEX ordered_line_arriving ON ordered_line (profile, ordered_at) WHERE taken_at IS NULL;
CREATE INDEX ordered_line_age ON ordered_line (ordered_at);
COMMENT ON TABLE ordered_line IS 'A row is a line of an order that came by request: a file that was put, and what was asked with it. Its claim is put together from the row until the ledger has a part of that claim.';
COMMENT ON COLUMN ordered_line.claim IS 'made of the client, its key and the request, so that a line has one claim for ever';
COMMENT ON COLUMN ordered_line.client IS 'who ordered it';
COMMENT ON COLUMN ordered_line.profile IS 'machine profile';
COMMENT ON COLUMN ordered_line.order_name IS 'the order that the line belongs to';
COMMENT ON COLUMN ordered_line.name IS 'file name';
COMMENT ON COLUMN ordered_line.content_hash IS 'BLAKE3 of the file, 64 hex digits';
COMMENT ON COLUMN ordered_line.copies IS 'copies ordered';
COMMENT ON COLUMN ordered_line.ticket IS 'what was asked with it, as a ticket in JSON';
COMMENT ON COLUMN ordered_line.ordered_at IS 'UTC';
COMMENT ON COLUMN ordered_line.taken_at IS 'UTC: when its part was recorded';
