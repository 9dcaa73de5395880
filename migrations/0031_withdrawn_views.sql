-- Builds that were withdrawn were not printed: they are no failed ones, and their copies no bad ones.
DROP VIEW v_build_history;
-- For operators with sqlite3: every build with its height, newest first.
CREATE VIEW v_build_history AS
SELECT b.id AS build, b.profile, CASE WHEN b.withdrawn_at IS NULL THEN b.state ELSE 'withdrawn' END AS state, b.published_at, round(b.height_mm, 2) AS height_mm,
       round(b.density, 4) AS density, round(b.lower_bound_mm, 2) AS lower_bound_mm, b.layers, b.copies,
       round(b.part_volume_mm3 / 1000.0, 2) AS part_volume_cm3, round(b.clearance_proved_mm, 3) AS clearance_proved_mm,
       round(b.cpu_secs, 1) AS cpu_secs, b.fired_by, b.file_name, b.reason
FROM build b WHERE b.state <> 'open' ORDER BY b.id DESC;

DROP VIEW v_part_history;
-- For operators with sqlite3: every part, how many of its copies are in a published build, and in which builds.
CREATE VIEW v_part_history AS
SELECT p.id AS part, p.profile, p.order_name, p.name, p.object_name, p.state, p.copies,
       (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.published_at IS NOT NULL) AS copies_built,
       (SELECT group_concat(DISTINCT l.build_id) FROM placement l WHERE l.part_id = p.id) AS builds,
       p.priority, p.due_at, p.due_text, p.claimed_at, p.state_at, p.reason, p.warnings,
       p.copies - p.cancelled_copies AS copies_wanted,
       (SELECT count(*) FROM bad_placement l CROSS JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS copies_bad
FROM part p ORDER BY p.id DESC;

DROP VIEW v_order_line;
-- For operators with sqlite3: each line of each order. wanted = waiting + in_builds + printed + good, or + refused.
CREATE VIEW v_order_line AS
SELECT n.order_name, n.part, n.profile, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'rejected' THEN 0 ELSE n.wanted - n.in_builds - n.printed - n.good END AS waiting,
       n.in_builds, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'rejected' THEN n.wanted - n.in_builds - n.printed - n.good ELSE 0 END AS refused, n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.id AS part, p.profile, p.name, p.object_name, p.state, p.due_at, p.due_text,
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

-- Copies of the part that its file holds itself: a revision takes over how often the file was wanted. NULL = it was read before this was noted.
ALTER TABLE part ADD COLUMN file_copies INTEGER;
