-- How often a part was refused, cancelled or taken back; it only grows. The note of its claim beside the stored file carries the
-- sum over the claim's parts in its name, so that a ledger that went back in time is noticed.
ALTER TABLE part ADD COLUMN decisions INTEGER NOT NULL DEFAULT 0;
