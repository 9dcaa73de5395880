-- What was said of a build and was not done, for its file could not be taken out of the queue, is told until an outcome of it is told.
ALTER TABLE build ADD COLUMN word_dropped TEXT COLLATE "C";
COMMENT ON COLUMN build.word_dropped IS 'why what was said of it was not done, and what a person must look at, without a full stop; NULL = nothing';
CREATE INDEX build_word_dropped ON build (id) WHERE word_dropped IS NOT NULL;
