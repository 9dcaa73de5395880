//! Looks at what is to be written before the search, so that nobody waits for a build that has no place, or loses a part to
//! it.

use std::path::{Path, PathBuf};

use anyhow::Result;

use super::{args::Args, parts::Row};
use crate::cli::Usage;

/// Refuses an output that cannot be written, that is another output, or that is a file which is read.
pub fn check(args: &Args, rows: &[Row]) -> Result<()> {
    let mut taken: Vec<(PathBuf, &str)> = Vec::new();
    let inputs = rows.iter().map(|row| &row.file).chain(&args.source.list);
    for input in inputs {
        // A link is read through, so that both it and its target are inputs.
        taken.extend(written_as(input).map(|path| (path, "a file that is read")));
        taken.extend(input.canonicalize().map(|path| (path, "a file that is read")));
    }
    let outputs = [
        ("-o", Some(&args.files.output)),
        ("--report", args.files.report.as_ref()),
        ("--stl", args.files.stl.as_ref()),
    ];
    for (option, output) in outputs.into_iter().filter_map(|(option, output)| Some((option, output?))) {
        let wrong = |what: String| Usage(format!("{option} {}: {what}", output.display()));
        let folder = folder_of(output);
        if !folder.is_dir() {
            return Err(wrong(format!("there is no folder {}", folder.display())).into());
        }
        let path = written_as(output).filter(|path| !path.is_dir());
        let path = path.ok_or_else(|| wrong("this is a folder; name a file".to_owned()))?;
        if let Some((_, other)) = taken.iter().find(|(known, _)| *known == path) {
            return Err(wrong(format!("this is also {other}, which would be overwritten")).into());
        }
        taken.push((path, option));
    }
    Ok(())
}

/// The folder in which a path's file stands.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The one spelling of a path that is written by a rename, which replaces a link and does not follow it. `None` = it has no
/// file name, or its folder is not there.
fn written_as(path: &Path) -> Option<PathBuf> {
    Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?))
}
