//! What customers ask in a week: orders with their lines, and what they say later. The same seed gives the same plan.

use std::{collections::BTreeSet, rc::Rc, time::Duration};

use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use solids::Mesh;

use crate::driven_tests::stl;

const HOUR: Duration = Duration::from_secs(3600);
/// Parts are made smaller where they are longer than this, mm: every machine takes every part.
const LONGEST_MM: f64 = 150.0;

/// How much is asked, and how often something goes wrong.
#[derive(Debug, Clone)]
pub struct WeekSize {
    /// Seed of everything.
    pub seed: u64,
    /// Machines: name and profile.
    pub machines: Vec<(&'static str, String)>,
    /// Time between two looks at the farm.
    pub step: Duration,
    /// Number of orders.
    pub orders: usize,
    /// Lines of each order.
    pub lines: usize,
    /// Different files.
    pub files: u32,
    /// Days on which orders come.
    pub days: u32,
    /// Share of builds that fail.
    pub failed_builds: f64,
    /// Share of copies of the other builds that are bad.
    pub bad_copies: f64,
    /// Share of lines that are changed later.
    pub late_words: f64,
}

/// The content of a file.
#[derive(Debug)]
pub struct PartContent {
    /// The bytes of an STL file.
    pub bytes: Vec<u8>,
    /// BLAKE3 of them.
    pub hash: String,
    /// Volume of the solid, mm³.
    pub volume_mm3: f64,
}

/// What is said of a line after its file was dropped.
#[derive(Debug, Clone)]
pub enum LateWord {
    /// A ticket with this number of copies; with a priority, it is too late once a copy is in a build.
    Ticket { copies: u32, has_priority: bool },
    /// `nestd edit --copies`.
    Edit { copies: u32 },
    /// Another content under the same name.
    Revision(Rc<PartContent>),
    /// `nestd cancel` for one copy.
    Cancel,
    /// `nestd move` to this machine.
    Move { machine: usize },
}

/// A line of an order.
#[derive(Debug, Clone)]
pub struct PlannedLine {
    /// File name.
    pub file: String,
    /// Content.
    pub content: Rc<PartContent>,
    /// Copies.
    pub copies: u32,
}

/// An order.
#[derive(Debug, Clone)]
pub struct PlannedOrder {
    /// Its name.
    pub name: String,
    /// The machine whose hot folder it is dropped into.
    pub machine: usize,
    /// When it is dropped, after the start.
    pub dropped_after: Duration,
    /// When it is due, after the start.
    pub due_after: Duration,
    /// Whether a list says what is asked, or a ticket beside each file.
    pub has_list: bool,
    /// Its lines.
    pub lines: Vec<PlannedLine>,
}

/// Something that is said late.
#[derive(Debug, Clone)]
pub struct PlannedWord {
    /// When, after the start.
    pub said_after: Duration,
    /// Number of the order in the plan.
    pub order: usize,
    /// Number of the line in the order.
    pub line: usize,
    /// What.
    pub word: LateWord,
}

/// All that is asked.
#[derive(Debug)]
pub struct WeekPlan {
    /// The orders, in the sequence in which they come.
    pub orders: Vec<PlannedOrder>,
    /// What is said later, in the sequence in which it is said.
    pub words: Vec<PlannedWord>,
}

impl WeekPlan {
    /// Makes the plan of a week.
    pub fn draw(size: &WeekSize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(size.seed);
        let catalogue: Vec<Rc<PartContent>> =
            (0..size.files).map(|index| Rc::new(any_content(&mut rng, size.seed, index))).collect();
        let mut orders: Vec<PlannedOrder> =
            (0..size.orders).map(|n| any_order(&mut rng, size, n, &catalogue)).collect();
        orders.sort_by_key(|order| order.dropped_after);
        let mut words = Vec::new();
        for (at, order) in orders.iter().enumerate() {
            let mut unused = unused_contents(&catalogue, &order.lines);
            for (line, planned) in order.lines.iter().enumerate() {
                if rng.random_bool(size.late_words) {
                    let word = any_word(&mut rng, size, order, planned, &mut unused);
                    // Most are said within the hour, some after a day.
                    let late = if rng.random_bool(0.7) { HOUR / 3 } else { 24 * HOUR };
                    let said_after = order.dropped_after + late + HOUR * rng.random_range(0..6) / 6;
                    words.push(PlannedWord { said_after, order: at, line, word });
                }
            }
        }
        words.sort_by_key(|word| word.said_after);
        Self { orders, words }
    }

    /// Number of lines.
    pub fn line_count(&self) -> usize {
        self.orders.iter().map(|order| order.lines.len()).sum()
    }
}

/// Contents that are in no line of an order, so that (order, content) names one line.
fn unused_contents(catalogue: &[Rc<PartContent>], lines: &[PlannedLine]) -> Vec<Rc<PartContent>> {
    let used: BTreeSet<&str> = lines.iter().map(|line| line.content.hash.as_str()).collect();
    catalogue.iter().filter(|content| !used.contains(content.hash.as_str())).cloned().collect()
}

/// A part of 10 to 150 mm: most are small.
fn any_content(rng: &mut ChaCha8Rng, seed: u64, index: u32) -> PartContent {
    let mesh = sample_parts::random_part(seed.wrapping_mul(7_919).wrapping_add(index.into()));
    let larger = *[1.0, 1.0, 1.0, 1.5, 1.5, 2.0, 2.5].choose(rng).unwrap();
    let scale = f64::min(larger, LONGEST_MM / mesh.bounds().size().max_element());
    let corners = mesh.vertices().iter().map(|corner| *corner * scale).collect();
    let mesh = Mesh::new(corners, mesh.triangles().to_vec()).unwrap();
    let bytes = stl(&mesh);
    PartContent { hash: blake3::hash(&bytes).to_hex().to_string(), bytes, volume_mm3: mesh.volume_mm3() }
}

fn any_order(rng: &mut ChaCha8Rng, size: &WeekSize, number: usize, catalogue: &[Rc<PartContent>]) -> PlannedOrder {
    // Working hours: 08:00 to 17:00 from the first day on.
    let dropped_after = HOUR * (24 * rng.random_range(0..size.days) + rng.random_range(0..10));
    let lines = catalogue.sample(rng, size.lines).enumerate();
    let lines = lines.map(|(at, content)| PlannedLine {
        file: format!("part {}.stl", (b'a' + at as u8) as char),
        content: content.clone(),
        copies: *[1, 1, 1, 2, 2, 4].choose(rng).unwrap(),
    });
    let lines: Vec<PlannedLine> = lines.collect();
    PlannedOrder {
        name: format!("order-{number:04}"),
        machine: rng.random_range(0..size.machines.len()),
        dropped_after,
        due_after: dropped_after + HOUR * rng.random_range(36..96),
        has_list: rng.random_bool(0.6),
        lines,
    }
}

fn any_word(
    rng: &mut ChaCha8Rng,
    size: &WeekSize,
    order: &PlannedOrder,
    line: &PlannedLine,
    unused: &mut Vec<Rc<PartContent>>,
) -> LateWord {
    match rng.random_range(0..5) {
        0 => LateWord::Ticket { copies: line.copies + rng.random_range(1..4), has_priority: rng.random_bool(0.5) },
        1 => LateWord::Edit { copies: rng.random_range(1..6) },
        2 => LateWord::Revision(unused.swap_remove(rng.random_range(0..unused.len()))),
        3 if line.copies > 1 => LateWord::Cancel,
        3 => LateWord::Edit { copies: 2 },
        _ => LateWord::Move { machine: (order.machine + 1) % size.machines.len() },
    }
}
