-- A published build whose file the printer has not taken can be withdrawn: its file is taken back, and its copies wait again.
ALTER TABLE build ADD COLUMN withdraw_by TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN withdraw_reason TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN withdrawn_at TEXT COLLATE "C";
ALTER TABLE build ADD COLUMN takes_over BIGINT;
CREATE INDEX build_withdrawing ON build (profile, id) WHERE withdraw_by IS NOT NULL;
COMMENT ON COLUMN build.withdraw_by IS 'who wants the file back: user@host, or nestd; NULL = nobody, or it is done';
COMMENT ON COLUMN build.withdraw_reason IS 'why';
COMMENT ON COLUMN build.withdrawn_at IS 'UTC: when its file was taken back and its copies put back';
COMMENT ON COLUMN build.takes_over IS 'of the open build: the build that nestd withdrew for it, so that it fires at once';

-- As before, without the builds that were withdrawn: they were not printed.
CREATE OR REPLACE VIEW v_height_by_day AS
SELECT substr(b.published_at, 1, 10) AS day, b.profile, count(*) AS builds, CAST(sum(b.copies) AS BIGINT) AS copies,
       CAST(round(CAST(sum(b.height_mm) AS numeric), 2) AS DOUBLE PRECISION) AS height_mm, CAST(round(CAST(avg(b.density) AS numeric), 4) AS DOUBLE PRECISION) AS mean_density
FROM build b WHERE b.published_at IS NOT NULL AND b.withdrawn_at IS NULL GROUP BY day, b.profile ORDER BY day DESC, b.profile;
