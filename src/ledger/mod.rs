//! The database, the only source of truth. All SQL of nestd is in this room.
