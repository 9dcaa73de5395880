-- A document or picture that came with parts is a line of its order of which nobody cancelled anything, as is a row whose file came late.
DROP VIEW v_order_line;

-- For operators with sqlite3: each line of each order. wanted = waiting + in_builds + queued + printing + printed + good, or + refused.
CREATE VIEW v_order_line AS
SELECT n.order_name, n.customer, n.part, n.machine, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'refused' THEN 0 ELSE n.wanted - n.in_builds - n.queued - n.printing - n.printed - n.good END AS waiting,
       n.in_builds, n.queued, n.printing, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'refused' THEN n.wanted - n.in_builds - n.queued - n.printing - n.printed - n.good ELSE 0 END AS refused,
       n.state, n.due_at, n.due_text
FROM (SELECT p.order_name, p.customer, p.id AS part, p.machine, p.name, p.object_name, p.state, p.due_at, p.due_text,
             p.copies - p.cancelled_copies AS wanted, CASE WHEN p.refusal = 'document' OR p.replaced_by IS NOT NULL AND p.claim LIKE 'row-%' THEN 0 ELSE p.cancelled_copies END AS cancelled,
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
