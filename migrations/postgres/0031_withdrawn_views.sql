-- Builds that were withdrawn were not printed: they are no failed ones, and their copies no bad ones.
CREATE OR REPLACE VIEW v_build_history AS
SELECT b.id AS build, b.profile, CASE WHEN b.withdrawn_at IS NULL THEN b.state ELSE 'withdrawn' END AS state, b.published_at, CAST(round(CAST(b.height_mm AS numeric), 2) AS DOUBLE PRECISION) AS height_mm,
       CAST(round(CAST(b.density AS numeric), 4) AS DOUBLE PRECISION) AS density, CAST(round(CAST(b.lower_bound_mm AS numeric), 2) AS DOUBLE PRECISION) AS lower_bound_mm, b.layers, b.copies,
       CAST(round(CAST(b.part_volume_mm3 / 1000.0 AS numeric), 2) AS DOUBLE PRECISION) AS part_volume_cm3, CAST(round(CAST(b.clearance_proved_mm AS numeric), 3) AS DOUBLE PRECISION) AS clearance_proved_mm,
       CAST(round(CAST(b.cpu_secs AS numeric), 1) AS DOUBLE PRECISION) AS cpu_secs, b.fired_by, b.file_name, b.reason
FROM build b WHERE b.state <> 'open' ORDER BY b.id DESC;

CREATE OR REPLACE VIEW v_part_history AS
SELECT p.id AS part, p.profile, p.order_name, p.name, p.object_name, p.state, p.copies,
       (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.published_at IS NOT NULL) AS copies_built,
       (SELECT string_agg(DISTINCT CAST(l.build_id AS text), ',') FROM placement l WHERE l.part_id = p.id) AS builds,
       p.priority, p.due_at, p.due_text, p.claimed_at, p.state_at, p.reason, p.warnings,
       p.copies - p.cancelled_copies AS copies_wanted,
       (SELECT count(*) FROM bad_placement l JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS copies_bad
FROM part p ORDER BY p.id DESC;

CREATE OR REPLACE VIEW v_order_line AS
SELECT n.order_name, n.part, n.profile, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'rejected' THEN 0 ELSE n.wanted - n.in_builds - n.printed - n.good END AS waiting,
       n.in_builds, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'rejected' THEN n.wanted - n.in_builds - n.printed - n.good ELSE 0 END AS refused, n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.id AS part, p.profile, p.name, p.object_name, p.state, p.due_at, p.due_text,
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

ALTER TABLE part ADD COLUMN file_copies BIGINT;
COMMENT ON COLUMN part.file_copies IS 'copies of the part that its file holds itself; NULL = it was read before this was noted';
