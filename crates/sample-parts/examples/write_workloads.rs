//! Writes the workloads of the public benchmark into a folder, for packers of others:
//!
//! `cargo run --release -p sample-parts --example write_workloads -- FOLDER`
//!
//! Each different part becomes a binary STL in mm. `workloads/NAME.csv` lists them with their copies, `workloads/NAME.json`
//! has base and clearance. `SHA256SUMS` is for `sha256sum -c`; the printed sum of it is the same for all who have the same
//! parts.
#![allow(clippy::print_stdout)] // it says what it wrote

use std::{env, error::Error, fs, path::PathBuf};

use sample_parts::COMPARED_WORKLOADS;
use sha2::{Digest, Sha256};

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = env::args_os().nth(1).map(PathBuf::from) else {
        return Err("say into which folder: write_workloads FOLDER".into());
    };
    let mut sums = String::new();
    for workload in &COMPARED_WORKLOADS {
        for file in workload.files() {
            let target = folder.join(&file.path);
            if let Some(parent) = target.parent() {
                fs::create_dir_all(parent)?;
            }
            sums += &format!("{}  {}\n", hex(&file.bytes), file.path);
            fs::write(target, file.bytes)?;
        }
        println!("{} is written", workload.name);
    }
    fs::write(folder.join("SHA256SUMS"), &sums)?;
    println!("SHA-256 of SHA256SUMS: {}", hex(sums.as_bytes()));
    Ok(())
}

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
