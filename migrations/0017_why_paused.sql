-- Why a profile is paused, as one word: a person may have the name that the daemon used to pause under.
ALTER TABLE pause ADD COLUMN cause TEXT NOT NULL DEFAULT 'person' CHECK (cause IN ('person', 'build-failed'));
UPDATE pause SET cause = 'build-failed' WHERE paused_by = 'nestd';
