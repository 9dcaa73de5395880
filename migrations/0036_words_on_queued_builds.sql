-- A word of a person that makes copies of a build bad, while its file lies in the queue, is carried out once the file is taken back.
ALTER TABLE build ADD COLUMN withdraw_word TEXT;  -- JSON of the word that is carried out when the file is back; NULL = none, its copies wait again
