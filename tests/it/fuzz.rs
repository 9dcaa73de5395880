//! Replays the corpus of the fuzz targets: small files with which fuzzing reached every branch of the readers, and
//! files that once broke them. The targets themselves are in `fuzz/`.

use std::{fs, path::PathBuf, time::Instant};

use crate::support::entries::TARGETS;

/// Largest file of the corpus, so that the whole corpus is read in seconds.
const MAX_BYTES: u64 = 4096;
/// A reader that takes longer than this hangs, seconds.
const MAX_SECS: f64 = 10.0;

fn corpus(target: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz_corpus").join(target);
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn every_file_of_the_corpus_is_read_or_refused_in_time() {
    for (target, entry) in TARGETS {
        let files = corpus(target);
        assert!(files.len() >= 2, "{target} has {} files", files.len());
        for file in files {
            let bytes = fs::read(&file).unwrap();
            assert!(bytes.len() as u64 <= MAX_BYTES, "{} is {} bytes long", file.display(), bytes.len());
            let began = Instant::now();
            entry(&bytes);
            assert!(began.elapsed().as_secs_f64() < MAX_SECS, "{} takes too long", file.display());
        }
    }
}

#[test]
fn every_target_has_its_program_and_its_corpus() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let manifest = fs::read_to_string(root.join("fuzz/Cargo.toml")).unwrap();
    let names = |folder: &str| {
        let mut names: Vec<String> = (fs::read_dir(root.join(folder)).unwrap())
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let mut targets: Vec<String> = TARGETS.iter().map(|(name, _)| (*name).to_owned()).collect();
    targets.sort();
    assert_eq!(names("fuzz/fuzz_targets"), targets);
    assert_eq!(names("tests/fuzz_corpus"), targets);
    assert!(targets.iter().all(|name| manifest.contains(&format!("name = \"{name}\""))), "{manifest}");
}
