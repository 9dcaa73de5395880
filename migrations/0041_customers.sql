-- Copies that lie in a queue, are printed, or were printed are told apart. Who an order is for is a field of its own; until now it stood in
-- the notes of its parts. A person can close an order as it is.
DROP VIEW v_order_line;

-- Who it is for, '' = not said.
ALTER TABLE part ADD COLUMN customer TEXT NOT NULL DEFAULT '';
-- For whom its parts are, '' = not said; several are joined by ', '.
ALTER TABLE customer_order ADD COLUMN customer TEXT NOT NULL DEFAULT '';
-- When a person closed it as it was, UTC; NULL = nobody did, or more of it is wanted since.
ALTER TABLE customer_order ADD COLUMN closed_at TEXT;
-- user@host; NULL = nobody did.
ALTER TABLE customer_order ADD COLUMN closed_by TEXT;
-- Copies that were accepted then, of how many.
ALTER TABLE customer_order ADD COLUMN accepted_copies INTEGER CHECK (accepted_copies >= 0);
ALTER TABLE customer_order ADD COLUMN closed_of INTEGER CHECK (closed_of >= 0);

UPDATE part SET customer = substr('; ' || note || '; ', instr('; ' || note, '; customer: ') + 12) WHERE instr('; ' || note, '; customer: ') > 0;
UPDATE part SET customer = trim(substr(customer, 1, instr(customer, '; ') - 1)) WHERE customer <> '';
UPDATE customer_order SET customer = coalesce((SELECT group_concat(n.customer, ', ') FROM (
    SELECT DISTINCT p.customer FROM part p WHERE p.order_name = customer_order.name AND p.order_name <> '' AND p.customer <> ''
    ORDER BY p.customer) n), '') WHERE EXISTS (
    SELECT 1 FROM part p WHERE p.order_name = customer_order.name AND p.order_name <> '' AND p.customer <> '');

-- For operators with sqlite3: each line of each order. wanted = waiting + in_builds + queued + printing + printed + good, or + refused.
CREATE VIEW v_order_line AS
SELECT n.order_name, n.customer, n.part, n.machine, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'refused' THEN 0 ELSE n.wanted - n.in_builds - n.queued - n.printing - n.printed - n.good END AS waiting,
       n.in_builds, n.queued, n.printing, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'refused' THEN n.wanted - n.in_builds - n.queued - n.printing - n.printed - n.good ELSE 0 END AS refused,
       n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.customer, p.id AS part, p.machine, p.name, p.object_name, p.state, p.due_at, p.due_text,
             p.copies - p.cancelled_copies AS wanted, p.cancelled_copies AS cancelled,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NULL) AS in_builds,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'published' AND b.taken_at IS NULL) AS queued,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND (b.state = 'printing' OR b.state = 'published' AND b.taken_at IS NOT NULL)) AS printing,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NOT NULL AND b.state NOT IN ('published', 'printing', 'complete')) AS printed,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'complete') AS good,
             (SELECT count(*) FROM bad_placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.withdrawn_at IS NULL) AS bad
      FROM part p) n;
