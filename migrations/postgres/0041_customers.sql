-- Copies that lie in a queue, are printed, or were printed are told apart. Who an order is for is a field of its own; until now it stood in
-- the notes of its parts. A person can close an order as it is.
DROP VIEW v_order_line;

ALTER TABLE part ADD COLUMN customer TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN part.customer IS 'who it is for, '''' = not said';
ALTER TABLE customer_order ADD COLUMN customer TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN customer_order.customer IS 'for whom its parts are, '''' = not said; several are joined by '', ''';
ALTER TABLE customer_order ADD COLUMN closed_at TEXT COLLATE "C";
COMMENT ON COLUMN customer_order.closed_at IS 'when a person closed it as it was, UTC; NULL = nobody did, or more of it is wanted since';
ALTER TABLE customer_order ADD COLUMN closed_by TEXT COLLATE "C";
COMMENT ON COLUMN customer_order.closed_by IS 'user@host; NULL = nobody did';
ALTER TABLE customer_order ADD COLUMN accepted_copies BIGINT CHECK (accepted_copies >= 0);
COMMENT ON COLUMN customer_order.accepted_copies IS 'copies that were accepted then; NULL = it was not closed';
ALTER TABLE customer_order ADD COLUMN closed_of BIGINT CHECK (closed_of >= 0);
COMMENT ON COLUMN customer_order.closed_of IS 'of how many copies wanted; NULL = it was not closed';

UPDATE part SET customer = trim(split_part(substr('; ' || note, strpos('; ' || note, '; customer: ') + 12), '; ', 1))
    WHERE strpos('; ' || note, '; customer: ') > 0;
UPDATE customer_order SET customer = coalesce((SELECT string_agg(n.customer, ', ' ORDER BY n.customer) FROM (
    SELECT DISTINCT p.customer FROM part p WHERE p.order_name = customer_order.name AND p.order_name <> '' AND p.customer <> '') n), '');

CREATE VIEW v_order_line AS
SELECT n.order_name, n.customer, n.part, n.machine, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'refused' THEN 0 ELSE n.wanted - n.in_builds - n.queued - n.printing - n.printed - n.good END AS waiting,
       n.in_builds, n.queued, n.printing, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'refused' THEN n.wanted - n.in_builds - n.queued - n.printing - n.printed - n.good ELSE 0 END AS refused,
       n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.customer, p.id AS part, p.machine, p.name, p.object_name, p.state, p.due_at, p.due_text,
             p.copies - p.cancelled_copies AS wanted, p.cancelled_copies AS cancelled,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NULL) AS in_builds,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'published' AND b.taken_at IS NULL) AS queued,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND (b.state = 'printing' OR b.state = 'published' AND b.taken_at IS NOT NULL)) AS printing,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NOT NULL AND b.state NOT IN ('published', 'printing', 'complete')) AS printed,
             (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'complete') AS good,
             (SELECT count(*) FROM bad_placement l JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS bad
      FROM part p) n;
