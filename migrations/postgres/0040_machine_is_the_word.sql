-- One name for one meaning: a machine is the thing, a profile the file that describes it; a file that is not taken is refused.
-- People query the views: their columns have the new names too.
DROP VIEW v_build_history;
DROP VIEW v_part_history;
DROP VIEW v_height_by_day;
DROP VIEW v_order_line;

ALTER TABLE part RENAME COLUMN profile TO machine;
ALTER TABLE build RENAME COLUMN profile TO machine;
ALTER TABLE event RENAME COLUMN profile TO machine;
ALTER TABLE command RENAME COLUMN profile TO machine;
ALTER TABLE pause RENAME COLUMN profile TO machine;
ALTER TABLE station RENAME COLUMN profile TO machine;
ALTER TABLE printer_down RENAME COLUMN profile TO machine;
ALTER TABLE ordered_line RENAME COLUMN profile TO machine;

ALTER INDEX build_by_profile_time RENAME TO build_by_machine_time;

-- A part that was refused, and a file that was refused before it became one, are told by one kind of event.
UPDATE event SET kind = 'refused' WHERE kind = 'rejected';
DROP INDEX event_counted;
CREATE INDEX event_counted ON event (kind, machine, cause) WHERE kind IN ('refused', 'proof_failed');

ALTER TABLE part DROP CONSTRAINT part_state_check;
UPDATE part SET state = 'refused' WHERE state = 'rejected';
ALTER TABLE part ADD CONSTRAINT part_state_check CHECK (state IN ('claimed', 'waiting', 'batched', 'built', 'refused'));
-- As on SQLite, where a new column needs one: a part begins claimed.
ALTER TABLE part ALTER COLUMN state SET DEFAULT 'claimed';

COMMENT ON COLUMN ordered_line.machine IS 'its machine';

CREATE VIEW v_build_history AS
SELECT b.id AS build, b.machine, CASE WHEN b.withdrawn_at IS NULL THEN b.state ELSE 'withdrawn' END AS state, b.published_at, CAST(round(CAST(b.height_mm AS numeric), 2) AS DOUBLE PRECISION) AS height_mm,
       CAST(round(CAST(b.density AS numeric), 4) AS DOUBLE PRECISION) AS density, CAST(round(CAST(b.lower_bound_mm AS numeric), 2) AS DOUBLE PRECISION) AS lower_bound_mm, b.layers, b.copies,
       CAST(round(CAST(b.part_volume_mm3 / 1000.0 AS numeric), 2) AS DOUBLE PRECISION) AS part_volume_cm3, CAST(round(CAST(b.clearance_proved_mm AS numeric), 3) AS DOUBLE PRECISION) AS clearance_proved_mm,
       CAST(round(CAST(b.cpu_secs AS numeric), 1) AS DOUBLE PRECISION) AS cpu_secs, b.fired_by, b.file_name, b.reason
FROM build b WHERE b.state <> 'open' ORDER BY b.id DESC;

CREATE VIEW v_part_history AS
SELECT p.id AS part, p.machine, p.order_name, p.name, p.object_name, p.state, p.copies,
       (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.published_at IS NOT NULL) AS copies_built,
       (SELECT string_agg(DISTINCT CAST(l.build_id AS text), ',') FROM placement l WHERE l.part_id = p.id) AS builds,
       p.priority, p.due_at, p.due_text, p.claimed_at, p.state_at, p.reason, p.warnings,
       p.copies - p.cancelled_copies AS copies_wanted,
       (SELECT count(*) FROM bad_placement l JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS copies_bad
FROM part p ORDER BY p.id DESC;

CREATE VIEW v_height_by_day AS
SELECT substr(b.published_at, 1, 10) AS day, b.machine, count(*) AS builds, CAST(sum(b.copies) AS BIGINT) AS copies,
       CAST(round(CAST(sum(b.height_mm) AS numeric), 2) AS DOUBLE PRECISION) AS height_mm, CAST(round(CAST(avg(b.density) AS numeric), 4) AS DOUBLE PRECISION) AS mean_density
FROM build b WHERE b.published_at IS NOT NULL AND b.withdrawn_at IS NULL GROUP BY day, b.machine ORDER BY day DESC, b.machine;

CREATE VIEW v_order_line AS
SELECT n.order_name, n.part, n.machine, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'refused' THEN 0 ELSE n.wanted - n.in_builds - n.printed - n.good END AS waiting,
       n.in_builds, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'refused' THEN n.wanted - n.in_builds - n.printed - n.good ELSE 0 END AS refused, n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.id AS part, p.machine, p.name, p.object_name, p.state, p.due_at, p.due_text,
             p.copies - p.cancelled_copies AS wanted, p.cancelled_copies AS cancelled,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NULL) AS in_builds,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NOT NULL AND b.state <> 'complete') AS printed,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'complete') AS good,
             (SELECT count(*) FROM bad_placement l JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS bad
      FROM part p) n;
