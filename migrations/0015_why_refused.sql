-- Why a rejected part is refused, as one of few words: texts are for people, and nothing is decided by them. NULL = it is not
-- rejected, or was before words were kept.
ALTER TABLE part ADD COLUMN refusal TEXT;
UPDATE part SET refusal =
    (SELECT nullif(e.cause, '') FROM event e WHERE e.part_id = part.id AND e.kind = 'rejected' ORDER BY e.id DESC LIMIT 1)
    WHERE state = 'rejected';
-- The copies of these are not known. It was told by this sentence alone.
UPDATE part SET refusal = 'ticket'
    WHERE state = 'rejected' AND instr(reason, 'Its copies are not known, so it is not printed') > 0;
