//! Checks the dependencies: docs/dependencies.md lists each with its reason, and licences, bans and sources follow
//! `deny.toml`. Where it is installed, `cargo deny check bans licenses sources` checks the same; these tests need only
//! cargo.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

use serde_json::Value;
use toml::Table;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn toml_file(name: &str) -> Table {
    fs::read_to_string(root().join(name)).unwrap().parse().unwrap()
}

/// The manifests of all crates of the workspace.
fn manifests() -> Vec<Table> {
    let workspace = toml_file("Cargo.toml");
    let others = words(&workspace["workspace"]["exclude"]);
    let folders = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let crates = folders.filter(|path| !others.iter().any(|other| *path == root().join(other)));
    let below = crates.map(|path| path.join("Cargo.toml").to_str().unwrap().to_owned());
    below.chain(["Cargo.toml".to_owned()]).map(|name| toml_file(&name)).collect()
}

/// Crates of others that a first `cargo run` compiles, at most: a dependency is weight, and so is each of its features. PostgreSQL's driver
/// takes eight, the catalogs of languages twelve, mails five, passwords five; two are there so that tests compile nothing again.
const MAX_CRATES: usize = 299;

fn text_at(value: &toml::Value) -> String {
    value.as_str().unwrap().to_owned()
}

fn words(value: &toml::Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect()
}

/// All packages that are built on the first target of `deny.toml`, for tests and benches too.
fn packages(target: &str) -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--offline", "--filter-platform", target])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let used: BTreeSet<&str> =
        metadata["resolve"]["nodes"].as_array().unwrap().iter().map(|node| node["id"].as_str().unwrap()).collect();
    let packages = metadata["packages"].as_array().unwrap();
    packages.iter().filter(|package| used.contains(package["id"].as_str().unwrap())).cloned().collect()
}

/// Whether the allowed licences satisfy an SPDX expression. `/` and `or` are older spellings of OR.
fn is_allowed(expression: &str, allowed: &[&str]) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ").replace(" or ", " OR ");
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let (holds, rest) = either(&tokens, allowed);
    assert!(rest.is_empty(), "{expression} is no SPDX expression");
    holds
}

fn either<'t>(tokens: &'t [&'t str], allowed: &[&str]) -> (bool, &'t [&'t str]) {
    let (mut holds, mut rest) = both(tokens, allowed);
    while let Some((&"OR", more)) = rest.split_first() {
        let (other, after) = both(more, allowed);
        (holds, rest) = (holds || other, after);
    }
    (holds, rest)
}

fn both<'t>(tokens: &'t [&'t str], allowed: &[&str]) -> (bool, &'t [&'t str]) {
    let (mut holds, mut rest) = one(tokens, allowed);
    while let Some((&"AND", more)) = rest.split_first() {
        let (other, after) = one(more, allowed);
        (holds, rest) = (holds && other, after);
    }
    (holds, rest)
}

fn one<'t>(tokens: &'t [&'t str], allowed: &[&str]) -> (bool, &'t [&'t str]) {
    match tokens {
        ["(", inner @ ..] => {
            let (holds, rest) = either(inner, allowed);
            assert_eq!(rest.first(), Some(&")"));
            (holds, &rest[1..])
        }
        [licence, "WITH", exception, rest @ ..] => {
            (allowed.contains(&format!("{licence} WITH {exception}").as_str()), rest)
        }
        [licence, rest @ ..] => (allowed.contains(licence), rest),
        [] => panic!("an expression ends early"),
    }
}

#[test]
fn licences_bans_and_sources_are_as_deny_toml_says() {
    let deny = toml_file("deny.toml");
    let allowed = words(&deny["licenses"]["allow"]);
    let banned: Vec<&str> =
        deny["bans"]["deny"].as_array().unwrap().iter().map(|ban| ban["crate"].as_str().unwrap()).collect();
    let sources = words(&deny["sources"]["allow-registry"]);
    let packages = packages(words(&deny["graph"]["targets"])[0]);
    let own: BTreeSet<String> = manifests().iter().map(|manifest| text_at(&manifest["package"]["name"])).collect();
    assert!(packages.len() > 100, "only {} packages", packages.len());
    let mut faults = Vec::new();
    for package in &packages {
        let name = package["name"].as_str().unwrap();
        match package["license"].as_str() {
            Some(licence) if is_allowed(licence, &allowed) => {}
            licence => faults.push(format!("{name}: licence {licence:?}")),
        }
        if banned.contains(&name) {
            faults.push(format!("{name} is banned"));
        }
        let source = package["source"].as_str().unwrap_or_default();
        let is_own = source.is_empty() && own.contains(name);
        if !is_own && !sources.iter().any(|registry| source == format!("registry+{registry}")) {
            faults.push(format!("{name}: source {source:?}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What `cargo tree` prints, a line each.
fn tree(arguments: &[&str]) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--offline", "--prefix", "none", "--target", "x86_64-unknown-linux-gnu"])
        .args(arguments)
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

#[test]
fn a_first_build_compiles_no_more_crates_than_it_must() {
    let tree = tree(&["--package", "nestd", "--edges", "normal,build", "--format", "{p}"]);
    // One of our own is followed by its path.
    let of_others = tree.iter().filter(|line| !line.contains("(/"));
    let crates: BTreeSet<&str> = of_others.map(|line| line.split(" (").next().unwrap()).collect();
    assert!(crates.len() > 100 && crates.len() <= MAX_CRATES, "{} crates: look at `cargo tree -d`", crates.len());
    assert!(!crates.iter().any(|name| name.starts_with("icu_")), "idna_adapter is not 1.1: see docs/dependencies.md");
}

#[test]
fn the_notices_of_the_package_name_each_linked_crate_with_its_licence_and_a_text_of_it() {
    let output = Command::new("sh").arg("packaging/notices.sh").current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let notices = String::from_utf8(output.stdout).unwrap();
    let lines: BTreeSet<&str> = notices.lines().collect();
    let with_text: BTreeSet<&str> =
        notices.lines().filter_map(|line| line.strip_prefix("----- ")).flat_map(|crates| crates.split(", ")).collect();
    let linked = tree(&["--package", "nestd", "--edges", "normal", "--format", "{p}"]);
    let mut found = 0;
    for package in packages("x86_64-unknown-linux-gnu") {
        let text = |key: &str| package[key].as_str().unwrap_or_default();
        let (name, version, licence) = (text("name"), text("version"), text("license"));
        let is_linked = |line: &String| line.split(" (").next() == Some(&format!("{name} v{version}"));
        if text("source").is_empty() || !linked.iter().any(is_linked) {
            continue;
        }
        found += 1;
        assert!(lines.contains(format!("{name} {version}: {licence}").as_str()), "{name} {version} is not named");
        // The texts of these two come with others.
        let has_text = with_text.contains(format!("{name} {version}").as_str());
        assert!(has_text || is_allowed(licence, &["MIT", "Apache-2.0"]), "{name} {version} has no text of {licence}");
    }
    assert!(found > 150, "{found}");
}

#[test]
fn tests_compile_again_no_crate_that_the_program_has_compiled() {
    let of_the_program = tree(&["--package", "nestd", "--edges", "normal,build", "--format", "{p} [{f}]"]);
    let of_the_tests = tree(&["--workspace", "--edges", "normal,build,dev", "--format", "{p} [{f}]"]);
    let again: Vec<_> = of_the_program.difference(&of_the_tests).collect();
    assert!(again.is_empty(), "tests add features to these: name them in Cargo.toml as it does others: {again:#?}");
}

#[test]
fn expressions_of_licences_are_understood() {
    let allowed = ["MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception"];
    for (expression, holds) in [
        ("MIT", true),
        ("GPL-3.0", false),
        ("GPL-3.0 OR MIT", true),
        ("MIT/GPL-3.0", true),
        ("MIT AND GPL-3.0", false),
        ("(GPL-3.0 OR MIT) AND Apache-2.0", true),
        ("GPL-3.0 WITH Classpath-exception", false),
        ("Apache-2.0 WITH LLVM-exception", true),
    ] {
        assert_eq!(is_allowed(expression, &allowed), holds, "{expression}");
    }
}

#[test]
fn the_lock_files_are_kept_and_name_one_registry() {
    let ignored = fs::read_to_string(root().join(".gitignore")).unwrap();
    assert!(!ignored.contains("lock"), "{ignored}");
    for name in ["Cargo.lock", "crates/nester-python/Cargo.lock", "fuzz/Cargo.lock", "tests/mutants/Cargo.lock"] {
        let lock = toml_file(name);
        for package in lock["package"].as_array().unwrap() {
            let source = package.get("source").map(|s| s.as_str().unwrap());
            let is_registry = source == Some("registry+https://github.com/rust-lang/crates.io-index");
            assert!(is_registry || source.is_none(), "{name}: {package}");
        }
    }
}

#[test]
fn every_dependency_stands_in_the_architecture_with_why_it_is_there() {
    let mut wanted = BTreeSet::new();
    for (name, requirement) in toml_file("Cargo.toml")["workspace"]["dependencies"].as_table().unwrap() {
        if requirement.get("path").is_some() {
            continue;
        }
        let version = requirement.as_str().or_else(|| requirement.get("version")?.as_str());
        assert!(version.is_some_and(|version| !version.contains('*')), "{name}: no version");
        wanted.insert(name.clone());
    }
    let mut used = BTreeSet::new();
    for manifest in manifests() {
        let tables =
            ["dependencies", "dev-dependencies"].into_iter().filter_map(|table| manifest.get(table)?.as_table());
        for (name, requirement) in tables.flatten() {
            let is_shared = requirement.get("workspace").and_then(toml::Value::as_bool) == Some(true);
            assert!(is_shared, "{}: {name} has a version of its own", manifest["package"]["name"]);
            used.insert(name.clone());
        }
    }
    let unused: Vec<_> = wanted.difference(&used).collect();
    assert!(unused.is_empty(), "no crate uses {unused:?}");
    let text = fs::read_to_string(root().join("docs/dependencies.md")).unwrap();
    let mut documented = BTreeSet::new();
    for line in text.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        assert!(cells.len() == 2 && cells[1].len() > 10, "{line}");
        documented.extend(cells[0].split(',').map(|name| name.trim().trim_matches('`').to_owned()));
    }
    assert_eq!(documented, wanted);
}
