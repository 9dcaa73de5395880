-- A machine may have several printers, each with its queue folder. A build is written for one of them, and moves to another if that one
-- goes down before it took the file. A proved build may wait for a person's yes.
ALTER TABLE build ADD COLUMN printer TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN taken_at TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN move_to TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN move_queue_id TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN released_at TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN released_by TEXT COLLATE "C";
CREATE INDEX build_in_queue ON build (profile, id) WHERE state = 'published' AND taken_at IS NULL AND printer IS NOT NULL;
CREATE INDEX build_moving ON build (id) WHERE move_to IS NOT NULL;
COMMENT ON COLUMN build.printer IS 'the printer in whose queue folder its file is, or was; NULL = the only one of its machine';
COMMENT ON COLUMN build.taken_at IS 'UTC: when its file was first seen to be gone from the queue folder';
COMMENT ON COLUMN build.move_to IS 'the printer that its published file is being moved to';
COMMENT ON COLUMN build.move_queue_id IS 'marker of the queue folder where all of the moved file is: from then on it may be visible there';
COMMENT ON COLUMN build.released_at IS 'UTC: when a person said that it may be published';
COMMENT ON COLUMN build.released_by IS 'user@host';

CREATE TABLE printer_down (
    profile TEXT COLLATE "C" NOT NULL,
    printer TEXT COLLATE "C" NOT NULL,
    reason TEXT COLLATE "C" NOT NULL DEFAULT '',
    told_by TEXT COLLATE "C" NOT NULL DEFAULT '',
    down_at TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (profile, printer)
);
COMMENT ON TABLE printer_down IS 'A row is a printer that takes no builds until a person says that it is up again.';
COMMENT ON COLUMN printer_down.profile IS 'its machine';
COMMENT ON COLUMN printer_down.told_by IS 'user@host';
COMMENT ON COLUMN printer_down.down_at IS 'UTC';
