//! What customers order, and the files or the request in which they send it.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use zip::CompressionMethod;

use super::MACHINES;
use crate::support::{
    block,
    samples::{package, with_a_hole, workbook},
    stl,
};

/// How customers send an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SentAs {
    /// A folder with a list; the words of its columns, and what separates them.
    List([&'static str; 4], char),
    Workbook,
    Archive,
    /// The copies stand in the names.
    Names,
    /// A ticket for each part.
    Tickets,
    /// OBJ, with a list.
    Obj,
    /// Meshes that lack a triangle, with a list.
    Broken,
    /// A program's request.
    Door,
}

/// All of them.
pub const KINDS: [SentAs; 11] = [
    SentAs::List(["file", "copies", "material", "customer"], ','),
    SentAs::List(["Datei", "Anzahl", "Werkstoff", "Kunde"], ';'),
    SentAs::List(["Fichier", "Quantité", "Matière", "Client"], ';'),
    SentAs::List(["ファイル名", "数量", "材質", "顧客名"], '\t'),
    SentAs::Workbook,
    SentAs::Archive,
    SentAs::Names,
    SentAs::Tickets,
    SentAs::Obj,
    SentAs::Broken,
    SentAs::Door,
];

/// What people do with an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrderFate {
    /// They print it.
    Printed,
    Cancelled,
    Closed,
    /// It came to a machine that has another material loaded, and is moved.
    Moved,
}

/// A line of an order.
pub struct CustomerLine {
    pub file: String,
    pub copies: u32,
    /// BLAKE3 of its file.
    pub hash: String,
    /// Volume of a copy, litres.
    pub litres: f64,
}

/// What a program sends.
pub struct ProgramRequest {
    pub document: String,
    /// Files by BLAKE3.
    pub contents: Vec<(String, Vec<u8>)>,
}

/// An order, and what was sent for it.
pub struct CustomerOrder {
    pub name: String,
    pub customer: String,
    /// The machine that is to make it, and what that has loaded.
    pub machine: &'static str,
    pub material: &'static str,
    /// Whether the customer says the material, and who it is.
    pub names_material: bool,
    /// The machine in whose folder it is put.
    pub folder: &'static str,
    pub lines: Vec<CustomerLine>,
    pub fate: OrderFate,
    /// Whether its meshes are to be mended.
    pub is_broken: bool,
    pub files: Vec<(String, Vec<u8>)>,
    pub request: Option<ProgramRequest>,
}

/// How customers write each material.
fn spelt(material: &str, rng: &mut ChaCha8Rng) -> &'static str {
    let words: &[&str] = match material {
        "PA12" => &["PA12", "pa 12", "Nylon 12", "PA2200"],
        "PA11" => &["PA11", "Rilsan", "pa-11"],
        _ => &["316L", "1.4404", "316l"],
    };
    words[rng.random_range(0..words.len())]
}

impl CustomerOrder {
    /// The order of this number: each kind of customer in turn, each part of a size of its own.
    pub fn think_of(number: usize, rng: &mut ChaCha8Rng) -> Self {
        let kind = KINDS[number % KINDS.len()];
        let (machine, material) = MACHINES[rng.random_range(0..MACHINES.len())];
        let fate = match rng.random_range(0..10) {
            0 => OrderFate::Cancelled,
            1 => OrderFate::Closed,
            // Who says no material gets what is loaded.
            2 if !matches!(kind, SentAs::Names | SentAs::Door) => OrderFate::Moved,
            _ => OrderFate::Printed,
        };
        let other = MACHINES.iter().find(|(_, loaded)| *loaded != material).unwrap().0;
        let mut order = Self {
            name: format!("K-{number}"),
            customer: ["Brandt", "Durand et fils", "山田製作所", "Smith & Co"][number % 4].to_owned(),
            machine,
            material,
            names_material: kind != SentAs::Names,
            folder: if fate == OrderFate::Moved { other } else { machine },
            lines: Vec::new(),
            fate,
            is_broken: kind == SentAs::Broken,
            files: Vec::new(),
            request: None,
        };
        let mut meshes = Vec::new();
        for at in 0..rng.random_range(1..4) {
            let size = DVec3::new(
                rng.random_range(8.0..14.0),
                rng.random_range(6.0..12.0),
                4.0 + (3 * number + at) as f64 * 0.01,
            );
            let bytes = match kind {
                SentAs::Obj => obj(size),
                SentAs::Broken => with_a_hole(stl(&block(size.x, size.y, size.z))),
                _ => stl(&block(size.x, size.y, size.z)),
            };
            let copies = rng.random_range(1..5);
            let stem = ["bracket", "Halter", "crochet", "ヒンジ", "cover plate"][rng.random_range(0..5)];
            let file = match kind {
                SentAs::Names => named_with_copies(stem, at, copies, rng),
                SentAs::Obj => format!("{stem} {at}a.obj"),
                _ => format!("{stem} {at}a.stl"),
            };
            let hash = blake3::hash(&bytes).to_hex().to_string();
            order.lines.push(CustomerLine { file, copies, hash, litres: size.x * size.y * size.z / 1e6 });
            meshes.push(bytes);
        }
        order.write(kind, meshes, rng);
        order
    }

    fn write(&mut self, kind: SentAs, meshes: Vec<Vec<u8>>, rng: &mut ChaCha8Rng) {
        let material = spelt(self.material, rng);
        let words: [&str; 4] = match kind {
            SentAs::List(words, _) => words,
            _ => ["file", "quantity", "material", "customer"],
        };
        let mut rows: Vec<[String; 4]> = vec![words.map(str::to_owned)];
        rows.extend(
            self.lines
                .iter()
                .map(|line| [line.file.clone(), line.copies.to_string(), material.to_owned(), self.customer.clone()]),
        );
        let text = |separator: char| {
            let rows = rows.iter().map(|row| row.join(&separator.to_string()));
            rows.collect::<Vec<_>>().join("\r\n").into_bytes()
        };
        let parts: Vec<(String, Vec<u8>)> = self.lines.iter().map(|line| line.file.clone()).zip(meshes).collect();
        let mut files = match kind {
            SentAs::List(_, separator) => vec![("order.csv".to_owned(), text(separator))],
            SentAs::Obj | SentAs::Broken | SentAs::Archive => vec![("list.csv".to_owned(), text(';'))],
            SentAs::Workbook => vec![("Bestellung.xlsx".to_owned(), workbook(&rows))],
            SentAs::Tickets => (self.lines.iter())
                .map(|line| {
                    let ticket = format!(
                        "copies = {}\nmaterial = \"{material}\"\ncustomer = \"{}\"\n",
                        line.copies, self.customer
                    );
                    (format!("{}.toml", line.file), ticket.into_bytes())
                })
                .collect(),
            SentAs::Names => Vec::new(),
            SentAs::Door => return self.request = Some(self.request_of(material, parts)),
        };
        files.extend(parts);
        if kind == SentAs::Archive {
            let entries: Vec<(&str, &[u8])> =
                files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
            files = vec![(format!("{}.zip", self.name), package(&entries, CompressionMethod::Deflated))];
        } else {
            files.iter_mut().for_each(|(name, _)| *name = format!("{}/{name}", self.name));
        }
        self.files = files;
    }

    fn request_of(&self, material: &str, parts: Vec<(String, Vec<u8>)>) -> ProgramRequest {
        let line = |line: &CustomerLine| json!({ "name": line.file, "content": line.hash, "copies": line.copies, "material": material });
        let document = json!({ "machine": self.machine, "order": self.name, "customer": self.customer,
            "lines": self.lines.iter().map(line).collect::<Vec<_>>() });
        let hashes = self.lines.iter().map(|line| line.hash.clone());
        ProgramRequest {
            document: document.to_string(),
            contents: hashes.zip(parts.into_iter().map(|(_, bytes)| bytes)).collect(),
        }
    }
}

/// A name that says the number of copies, as people write it.
fn named_with_copies(stem: &str, at: usize, copies: u32, rng: &mut ChaCha8Rng) -> String {
    let name = ["a", "b", "c"][at];
    match rng.random_range(0..4) {
        0 => format!("{copies}x {stem} {name}.stl"),
        1 => format!("{stem}_{name}_{copies}pcs.stl"),
        2 => format!("{stem} {name} {copies} Stk.stl"),
        _ => format!("{stem}_{name}_x{copies}.stl"),
    }
}

/// A box as a modelling program writes it.
fn obj(size: DVec3) -> Vec<u8> {
    let mut text = "# box\no box\n".to_owned();
    for corner in 0..8 {
        let [x, y, z] = [corner & 1, corner >> 1 & 1, corner >> 2 & 1].map(f64::from);
        text += &format!("v {} {} {}\n", x * size.x, y * size.y, z * size.z);
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    text.into_bytes()
}
