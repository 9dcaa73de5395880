-- What is asked of a ledger of a million builds is answered from an index.
-- History: builds past nesting by the time they were published, else by the time they entered their state; of all machines ...
CREATE INDEX build_by_time ON build (coalesce(published_at, state_at), id) WHERE state NOT IN ('open', 'nesting');
-- ... and of one.
CREATE INDEX build_by_profile_time ON build (profile, coalesce(published_at, state_at), id)
    WHERE state NOT IN ('open', 'nesting');
-- A build file belongs to one build.
CREATE UNIQUE INDEX build_by_file ON build (file_name) WHERE file_name IS NOT NULL;
-- What was refused or built lately.
CREATE INDEX part_by_state_time ON part (state, state_at);
-- Parts are asked for by the name that they were dropped with.
CREATE INDEX part_by_name ON part (name);
-- Orders by hand about a part.
CREATE INDEX command_by_part ON command (part_id) WHERE part_id IS NOT NULL;
