-- Messages can be sent by e-mail: each kind of mail is a receiver of its own. An order can say where its customer gets e-mail.
ALTER TABLE part ADD COLUMN email TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.email IS 'where the customer gets e-mail, '''' = not said';
ALTER TABLE receiver DROP CONSTRAINT receiver_name_check;
ALTER TABLE receiver ADD CONSTRAINT receiver_name_check CHECK (name IN (
    'webhook', 'command', 'email-alert', 'email-refused', 'email-at-risk', 'email-order-complete'));
ALTER TABLE receiver ADD COLUMN told_at TEXT COLLATE "C";
COMMENT ON COLUMN receiver.told_at IS 'UTC, when it was told last, NULL = not yet, or not known';
