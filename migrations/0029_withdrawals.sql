-- A published build whose file the printer has not taken can be withdrawn: its file is taken back, and its copies wait again.
ALTER TABLE build ADD COLUMN withdraw_by TEXT;      -- who wants the file back: user@host, or nestd; NULL = nobody, or it is done
ALTER TABLE build ADD COLUMN withdraw_reason TEXT;  -- why
ALTER TABLE build ADD COLUMN withdrawn_at TEXT;     -- UTC: when its file was taken back and its copies put back
ALTER TABLE build ADD COLUMN takes_over INTEGER;    -- of the open build: the build that nestd withdrew for it, so that it fires at once
CREATE INDEX build_withdrawing ON build (profile, id) WHERE withdraw_by IS NOT NULL;

-- As before, without the builds that were withdrawn: they were not printed.
DROP VIEW v_height_by_day;
-- For operators with sqlite3: builds and heights per machine and day (UTC).
CREATE VIEW v_height_by_day AS
SELECT substr(b.published_at, 1, 10) AS day, b.profile, count(*) AS builds, sum(b.copies) AS copies,
       round(sum(b.height_mm), 2) AS height_mm, round(avg(b.density), 4) AS mean_density
FROM build b WHERE b.published_at IS NOT NULL AND b.withdrawn_at IS NULL GROUP BY day, b.profile ORDER BY day DESC, b.profile;
