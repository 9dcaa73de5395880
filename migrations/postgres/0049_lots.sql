-- The lot of the powder is a text that people say with what they load. A build has the one from which it was printed.
ALTER TABLE loaded_material ADD COLUMN lot TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN loaded_material.lot IS 'the lot that is loaded, '''' = not said';
ALTER TABLE build ADD COLUMN lot TEXT COLLATE "C" NOT NULL DEFAULT '';
COMMENT ON COLUMN build.lot IS 'the lot that was loaded when its printer took it, '''' = not said';
