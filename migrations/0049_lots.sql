-- The lot of the powder is a text that people say with what they load. A build has the one from which it was printed.
ALTER TABLE loaded_material ADD COLUMN lot TEXT NOT NULL DEFAULT '';      -- the lot that is loaded, '' = not said
ALTER TABLE build ADD COLUMN lot TEXT NOT NULL DEFAULT '';                -- the lot that was loaded when its printer took it, '' = not said
