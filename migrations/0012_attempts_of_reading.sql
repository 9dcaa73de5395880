-- How often reading a part's file was begun, counted before each attempt (the first with its claim): a file that ended the process
-- twice is read alone, in a process of its own. What the disk hindered does not count.
ALTER TABLE part ADD COLUMN reads INTEGER NOT NULL DEFAULT 0;
-- How often a search for an open build was begun since one came to its end: parts that end the process there are tried alone.
ALTER TABLE build ADD COLUMN searches INTEGER NOT NULL DEFAULT 0;
