-- The final search for a build runs on the node of its machine alone. A build that is searched in lanes is searched anew.
DROP TABLE lane;
DROP TABLE lane_search;
ALTER TABLE node DROP COLUMN lanes;
