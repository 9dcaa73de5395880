-- A machine may have several printers, each with its queue folder. A build is written for one of them, and moves to another if that one
-- goes down before it took the file. A proved build may wait for a person's yes.
ALTER TABLE build ADD COLUMN printer TEXT;        -- the printer in whose queue folder its file is, or was; NULL = the only one of its machine
ALTER TABLE build ADD COLUMN taken_at TEXT;       -- UTC: when its file was first seen to be gone from the queue folder
ALTER TABLE build ADD COLUMN move_to TEXT;        -- the printer that its published file is being moved to
ALTER TABLE build ADD COLUMN move_queue_id TEXT;  -- marker of the queue folder where all of the moved file is: from then on it may be visible there
ALTER TABLE build ADD COLUMN released_at TEXT;    -- UTC: when a person said that it may be published
ALTER TABLE build ADD COLUMN released_by TEXT;    -- user@host
CREATE INDEX build_in_queue ON build (profile, id) WHERE state = 'published' AND taken_at IS NULL AND printer IS NOT NULL;
CREATE INDEX build_moving ON build (id) WHERE move_to IS NOT NULL;

-- A row is a printer that takes no builds until a person says that it is up again.
CREATE TABLE printer_down (
    profile  TEXT NOT NULL,              -- its machine
    printer  TEXT NOT NULL,
    reason   TEXT NOT NULL DEFAULT '',
    told_by  TEXT NOT NULL DEFAULT '',   -- user@host
    down_at  TEXT NOT NULL,              -- UTC
    PRIMARY KEY (profile, printer)
) STRICT;
