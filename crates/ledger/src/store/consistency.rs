//! Consistency checks: verifies in SQL, from scratch, the rules between states and placements. Slow.

use crate::base::{
    error::Result,
    sql::{self, SqlTransaction},
};

/// The rules of states and places of copies. Each violation as a sentence, and the query that finds it.
const PLACE_RULES: [(&str, &str); 15] = [
    (
        "a claimed or refused part has a copy in a build that is not published",
        "\
        SELECT p.id FROM part p JOIN placement l ON l.part_id = p.id JOIN build b ON b.id = l.build_id \
        WHERE p.state IN ('claimed', 'refused') AND b.published_at IS NULL",
    ),
    (
        "a waiting part has no copy left that could wait",
        "\
        SELECT p.id FROM part p WHERE p.state = 'waiting' \
        AND (SELECT count(*) FROM placement l WHERE l.part_id = p.id) >= p.copies - p.cancelled_copies",
    ),
    (
        "a batched or built part has a copy in no build",
        "\
        SELECT p.id FROM part p WHERE p.state IN ('batched', 'built') \
        AND (SELECT count(*) FROM placement l WHERE l.part_id = p.id) <> p.copies - p.cancelled_copies",
    ),
    (
        "a batched part has all copies in published builds",
        "\
        SELECT p.id FROM part p WHERE p.state = 'batched' AND NOT EXISTS (SELECT 1 FROM placement l \
        JOIN build b ON b.id = l.build_id WHERE l.part_id = p.id AND b.published_at IS NULL)",
    ),
    (
        "a built part has a copy in a build that is not published",
        "\
        SELECT p.id FROM part p WHERE p.state = 'built' AND EXISTS (SELECT 1 FROM placement l \
        JOIN build b ON b.id = l.build_id WHERE l.part_id = p.id AND b.published_at IS NULL)",
    ),
    (
        "a placement has a copy number that its part does not have",
        "\
        SELECT l.part_id FROM placement l JOIN part p ON p.id = l.part_id WHERE l.copy >= p.copies",
    ),
    (
        "a placement is for another machine than its part",
        "\
        SELECT l.part_id FROM placement l JOIN part p ON p.id = l.part_id JOIN build b ON b.id = l.build_id \
        WHERE p.machine <> b.machine AND b.published_at IS NULL",
    ),
    (
        "an open build, or one that failed before it was published, holds a copy",
        "\
        SELECT b.id FROM build b JOIN placement l ON l.build_id = b.id \
        WHERE b.state = 'open' OR (b.state = 'failed' AND b.published_at IS NULL)",
    ),
    (
        "a build that is past nesting does not hold as many copies as it says",
        "\
        SELECT b.id FROM build b WHERE b.verified_at IS NOT NULL \
        AND b.copies IS DISTINCT FROM (SELECT count(*) FROM build_copy l WHERE l.build_id = b.id)",
    ),
    (
        "a verified build has a copy without a pose, height, or file",
        "\
        SELECT b.id FROM build b WHERE b.verified_at IS NOT NULL AND (b.height_mm IS NULL OR b.file_name IS NULL \
        OR EXISTS (SELECT 1 FROM build_copy l WHERE l.build_id = b.id AND (l.qw IS NULL OR l.tz_mm IS NULL)))",
    ),
    (
        "a build's times do not agree with its state",
        "\
        SELECT b.id FROM build b WHERE (b.nesting_at IS NULL) <> (b.state = 'open') \
        OR (b.state IN ('open', 'nesting') AND b.verified_at IS NOT NULL) \
        OR (b.state IN ('verified', 'published', 'printing', 'complete', 'interrupted') AND b.verified_at IS NULL) \
        OR (b.state IN ('open', 'nesting', 'verified') AND b.published_at IS NOT NULL) \
        OR (b.state IN ('published', 'printing', 'complete', 'interrupted') AND b.published_at IS NULL)",
    ),
    (
        "a waiting part does not say whether its material is loaded on its machine",
        "\
        SELECT p.id FROM part p WHERE p.state = 'waiting' AND p.awaits_material <> (p.material_key <> '' AND p.material_key <> \
        coalesce((SELECT l.material_key FROM loaded_material l WHERE l.machine = p.machine), ''))",
    ),
    (
        "a build that is not published holds parts of two materials, or of one that it does not name",
        "\
        SELECT b.id FROM build b WHERE b.state IN ('nesting', 'verified') AND (SELECT count(DISTINCT p.material_key) FROM placement l \
        JOIN part p ON p.id = l.part_id WHERE l.build_id = b.id AND p.material_key <> '') > CASE b.material WHEN '' THEN 0 ELSE 1 END",
    ),
    ("a refused part has no reason", "SELECT id FROM part WHERE state = 'refused' AND reason = ''"),
    (
        "a part or build is in a state without an event for it",
        "\
        SELECT p.id FROM part p WHERE NOT EXISTS \
        (SELECT 1 FROM event e WHERE e.part_id = p.id AND e.kind = p.state) \
        UNION ALL SELECT b.id FROM build b WHERE b.state <> 'open' AND NOT EXISTS \
        (SELECT 1 FROM event e WHERE e.build_id = b.id AND e.kind = b.state)",
    ),
];

/// The rules of the sum of an order: copies wanted, and what became of them.
const ORDER_RULES: [(&str, &str); 4] = [
    (
        "the copies wanted of a part are not those that its events tell",
        "\
        SELECT p.id FROM part p WHERE p.copies - p.cancelled_copies <> \
        (SELECT sum(e.wanted_change) FROM event e WHERE e.part_id = p.id) \
        AND EXISTS (SELECT 1 FROM event e WHERE e.part_id = p.id AND e.wanted_change IS NOT NULL \
        AND e.kind = 'waiting')",
    ),
    (
        "more copies of a part stand in builds than are wanted",
        "\
        SELECT p.id FROM part p WHERE p.state <> 'claimed' \
        AND (SELECT count(*) FROM placement l WHERE l.part_id = p.id) > p.copies - p.cancelled_copies",
    ),
    (
        "a copy was told to be bad of a build that was not published",
        "\
        SELECT l.part_id FROM bad_placement l JOIN build b ON b.id = l.build_id \
        WHERE b.published_at IS NULL OR l.copy >= (SELECT p.copies FROM part p WHERE p.id = l.part_id)",
    ),
    (
        "a part of an order has no row of its order",
        "\
        SELECT p.id FROM part p WHERE p.order_name <> '' \
        AND NOT EXISTS (SELECT 1 FROM customer_order o WHERE o.name = p.order_name)",
    ),
];

/// The rules of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RuleScope {
    /// States of parts and builds, and the places of copies.
    Places,
    /// The sum of an order: copies wanted, and what became of them.
    OrderSums,
}

impl RuleScope {
    /// Every scope.
    pub const ALL: [Self; 2] = [Self::Places, Self::OrderSums];

    fn rules(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Places => &PLACE_RULES,
            Self::OrderSums => &ORDER_RULES,
        }
    }
}

/// Finds the inconsistencies against these rules in the database as seen by this connection.
pub async fn find_inconsistencies(db: &mut SqlTransaction, scopes: &[RuleScope]) -> Result<Vec<String>> {
    let mut faults = Vec::new();
    for (sentence, query) in scopes.iter().flat_map(|scope| scope.rules()) {
        for id in sql::query_scalar::<i64>(*query).fetch_all(&mut *db).await? {
            faults.push(format!("{id}: {sentence}"));
        }
    }
    Ok(faults)
}
