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

DROP INDEX build_by_profile_time;
CREATE INDEX build_by_machine_time ON build (machine, coalesce(published_at, state_at), id)
    WHERE state NOT IN ('open', 'nesting');

-- A part that was refused, and a file that was refused before it became one, are told by one kind of event.
UPDATE event SET kind = 'refused' WHERE kind = 'rejected';
DROP INDEX event_counted;
CREATE INDEX event_counted ON event (kind, machine, cause) WHERE kind IN ('refused', 'proof_failed');

-- SQLite changes no constraint of a column: the state of parts moves into a new one.
ALTER TABLE part ADD COLUMN state_now TEXT NOT NULL DEFAULT 'claimed' CHECK (state_now IN ('claimed', 'waiting', 'batched', 'built', 'refused'));
UPDATE part SET state_now = CASE state WHEN 'rejected' THEN 'refused' ELSE state END;
DROP INDEX part_by_state;
DROP INDEX part_by_state_time;
DROP INDEX part_by_due;
ALTER TABLE part DROP COLUMN state;
ALTER TABLE part RENAME COLUMN state_now TO state;
CREATE INDEX part_by_state ON part (state, machine);
CREATE INDEX part_by_state_time ON part (state, state_at);
CREATE INDEX part_by_due ON part (due_at)
    WHERE due_at IS NOT NULL AND at_risk_at IS NULL AND state IN ('claimed', 'waiting', 'batched');

-- For operators with sqlite3: every build with its height, newest first.
CREATE VIEW v_build_history AS
SELECT b.id AS build, b.machine, CASE WHEN b.withdrawn_at IS NULL THEN b.state ELSE 'withdrawn' END AS state, b.published_at, round(b.height_mm, 2) AS height_mm,
       round(b.density, 4) AS density, round(b.lower_bound_mm, 2) AS lower_bound_mm, b.layers, b.copies,
       round(b.part_volume_mm3 / 1000.0, 2) AS part_volume_cm3, round(b.clearance_proved_mm, 3) AS clearance_proved_mm,
       round(b.cpu_secs, 1) AS cpu_secs, b.fired_by, b.file_name, b.reason
FROM build b WHERE b.state <> 'open' ORDER BY b.id DESC;

-- For operators with sqlite3: every part, how many of its copies are in a published build, and in which builds.
CREATE VIEW v_part_history AS
SELECT p.id AS part, p.machine, p.order_name, p.name, p.object_name, p.state, p.copies,
       (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.published_at IS NOT NULL) AS copies_built,
       (SELECT group_concat(DISTINCT l.build_id) FROM placement l WHERE l.part_id = p.id) AS builds,
       p.priority, p.due_at, p.due_text, p.claimed_at, p.state_at, p.reason, p.warnings,
       p.copies - p.cancelled_copies AS copies_wanted,
       (SELECT count(*) FROM bad_placement l CROSS JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS copies_bad
FROM part p ORDER BY p.id DESC;

-- For operators with sqlite3: builds and heights per machine and day (UTC).
CREATE VIEW v_height_by_day AS
SELECT substr(b.published_at, 1, 10) AS day, b.machine, count(*) AS builds, sum(b.copies) AS copies,
       round(sum(b.height_mm), 2) AS height_mm, round(avg(b.density), 4) AS mean_density
FROM build b WHERE b.published_at IS NOT NULL AND b.withdrawn_at IS NULL GROUP BY day, b.machine ORDER BY day DESC, b.machine;

-- For operators with sqlite3: each line of each order. wanted = waiting + in_builds + printed + good, or + refused.
CREATE VIEW v_order_line AS
SELECT n.order_name, n.part, n.machine, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'refused' THEN 0 ELSE n.wanted - n.in_builds - n.printed - n.good END AS waiting,
       n.in_builds, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'refused' THEN n.wanted - n.in_builds - n.printed - n.good ELSE 0 END AS refused, n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.id AS part, p.machine, p.name, p.object_name, p.state, p.due_at, p.due_text,
             p.copies - p.cancelled_copies AS wanted, p.cancelled_copies AS cancelled,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NULL) AS in_builds,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NOT NULL AND b.state <> 'complete') AS printed,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'complete') AS good,
             (SELECT count(*) FROM bad_placement l CROSS JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS bad
      FROM part p) n;
