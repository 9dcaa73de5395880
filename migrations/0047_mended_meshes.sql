-- A mesh that is not closed is mended when somebody says yes, and the mended one is what is printed.
ALTER TABLE part ADD COLUMN mend_allowed_by TEXT NOT NULL DEFAULT '';  -- Who said that its mesh may be mended: user@host, 'ticket', 'mesh_errors' (the setting of its machine). '' = nobody.
ALTER TABLE part ADD COLUMN mended TEXT NOT NULL DEFAULT '';           -- What was done to its mesh, in words with measures. '' = it is printed as it was dropped.
ALTER TABLE part ADD COLUMN mended_hash TEXT NOT NULL DEFAULT '';      -- BLAKE3 of the mended mesh, 64 hex digits: its file is mended to the same each time it is read. '' = not mended.
