-- Messages can be sent by e-mail: each kind of mail is a receiver of its own. An order can say where its customer gets e-mail.
-- Where the customer gets e-mail, '' = not said.
ALTER TABLE part ADD COLUMN email TEXT NOT NULL DEFAULT '';

-- A row is a receiver that is configured.
CREATE TABLE new_receiver (
    name       TEXT    PRIMARY KEY NOT NULL CHECK (name IN (
                       'webhook', 'command', 'email-alert', 'email-refused', 'email-at-risk', 'email-order-complete')),
    told_id    INTEGER NOT NULL,                    -- the latest event that it has been told, or that is not for it
    told_at    TEXT,                                -- UTC, when it was told last, NULL = not yet, or not known
    failing_at TEXT,                                -- UTC, since when it cannot be told, NULL = it can
    failure    TEXT    NOT NULL DEFAULT '',         -- why
    dropped    INTEGER NOT NULL DEFAULT 0           -- events that became too old before it could be told, or were refused for ever
) STRICT, WITHOUT ROWID;
INSERT INTO new_receiver (name, told_id, failing_at, failure, dropped) SELECT name, told_id, failing_at, failure, dropped FROM receiver;
DROP TABLE receiver;
ALTER TABLE new_receiver RENAME TO receiver;
