//! A ledger of very many builds, made by SQL in a real SQLite file: each build has one part of two copies; the builds
//! are spread evenly over ten years.

use std::path::Path;

use sqlx::{Connection, SqliteConnection};

/// Days over which the builds are spread.
const DAYS: i64 = 3650;

/// Adds `builds` published builds to a ledger that no daemon serves.
pub async fn fill_published(ledger: &Path, builds: u64) {
    let mut db = SqliteConnection::connect(&format!("sqlite:{}", ledger.display())).await.unwrap();
    let last: (i64, i64) =
        sqlx::query_as("SELECT (SELECT coalesce(max(id), 0) FROM part), (SELECT coalesce(max(id), 0) FROM build)")
            .fetch_one(&mut db)
            .await
            .unwrap();
    // A ledger of an earlier schema calls a machine by its profile.
    let named = "SELECT name FROM pragma_table_info('part') WHERE name IN ('machine', 'profile')";
    let machine: String = sqlx::query_scalar(named).fetch_one(&mut db).await.unwrap();
    let at = format!(
        "strftime('%Y-%m-%dT%H:%M:%fZ', unixepoch('now') - ({builds} - i) * {DAYS} * 86400 / {builds} - 60, 'unixepoch')"
    );
    let numbers = format!(
        "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {builds}), t (i, at) AS (SELECT i, {at} FROM n)"
    );
    let (part, build) = last;
    let steps = [
        "PRAGMA synchronous = OFF; PRAGMA cache_size = -200000; BEGIN".to_owned(),
        format!(
            "{numbers} INSERT INTO part (id, claim, {machine}, name, content_hash, bytes, state, copies, triangles, volume_mm3, \
             size_x_mm, size_y_mm, size_z_mm, claimed_at, state_at) SELECT i + {part}, printf('big-%08d', i), 'test', \
             printf('part-%d.stl', i), printf('%064x', i), 684, 'built', 2, 12, 1000.0, 10.0, 10.0, 10.0, at, at FROM t"
        ),
        format!(
            "{numbers} INSERT INTO build (id, {machine}, state, fired_by, attempts, opened_at, nesting_at, verified_at, \
             published_at, state_at, file_name, queue_id, file_hash, file_bytes, height_mm, density, lower_bound_mm, layers, \
             part_volume_mm3, copies, clearance_mm, clearance_proved_mm, cpu_secs, wall_secs, evaluations, seed, method, \
             version, profile_snapshot) SELECT i + {build}, 'test', 'complete', 'full', 1, at, at, at, at, at, \
             printf('20160101T000000Z_test_%06d.build.3mf', i + {build}), 'queue', printf('%064x', i), 123456, 87.5, 0.2, \
             40.0, 875, 2000.0, 2, 3.0, 3.02, 10.5, 5.2, 12345, 7, 'nestd', '0.1.0', '{{\"name\": \"test\"}}' FROM t"
        ),
        format!(
            "INSERT INTO placement (part_id, copy, build_id, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm) \
             SELECT p.id, c.c, p.id - {part} + {build}, 0, 0, 0, 1.0, 1.0, 2.0, 3.0 \
             FROM part p, (SELECT 0 AS c UNION ALL SELECT 1) c WHERE p.id > {part}"
        ),
        format!(
            "INSERT INTO event (at, kind, {machine}, part_id) SELECT claimed_at, 'claimed', 'test', id FROM part WHERE id > {part}"
        ),
        format!(
            "INSERT INTO event (at, kind, {machine}, part_id) SELECT claimed_at, 'built', 'test', id FROM part WHERE id > {part}"
        ),
        format!(
            "INSERT INTO event (at, kind, {machine}, build_id) SELECT opened_at, 'published', 'test', id FROM build WHERE id > {build}"
        ),
        format!(
            "INSERT INTO event (at, kind, {machine}, build_id) SELECT opened_at, 'complete', 'test', id FROM build WHERE id > {build}"
        ),
        "COMMIT; PRAGMA wal_checkpoint(TRUNCATE)".to_owned(),
    ];
    for step in steps {
        sqlx::raw_sql(sqlx::AssertSqlSafe(step)).execute(&mut db).await.unwrap();
    }
    db.close().await.unwrap();
}

/// Adds waiting parts.
pub async fn fill_waiting(ledger: &Path, parts: u64) {
    let mut db = SqliteConnection::connect(&format!("sqlite:{}", ledger.display())).await.unwrap();
    let steps = format!(
        "BEGIN; WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {parts}) \
         INSERT INTO part (claim, machine, name, content_hash, bytes, state, copies, triangles, volume_mm3, size_x_mm, \
         size_y_mm, size_z_mm, claimed_at, state_at) SELECT printf('waiting-%08d', i), 'test', printf('w-%d.stl', i), \
         printf('%064x', i), 684, 'waiting', 2, 12, 1000.0, 10.0, 10.0, 10.0, strftime('%Y-%m-%dT%H:%M:%fZ', 'now'), \
         strftime('%Y-%m-%dT%H:%M:%fZ', 'now') FROM n; \
         INSERT INTO event (at, kind, machine, part_id) SELECT claimed_at, 'waiting', 'test', id FROM part WHERE state = 'waiting'; \
         COMMIT"
    );
    sqlx::raw_sql(sqlx::AssertSqlSafe(steps)).execute(&mut db).await.unwrap();
    db.close().await.unwrap();
}
