//! Checks the output paths before the search, so that the search does not end with a build that cannot be written, and
//! no output overwrites an input.

use std::path::{Path, PathBuf};

use anyhow::Result;

use super::{args::NestArgs, parts::RequestedFile};
use crate::cli::UsageError;

/// Refuses an output that cannot be written, that equals another output, or that is an input.
pub fn check_paths(args: &NestArgs, rows: &[RequestedFile]) -> Result<()> {
    let mut taken: Vec<(PathBuf, &str)> = Vec::new();
    let inputs = rows.iter().map(|row| &row.file).chain(&args.source.list);
    for input in inputs {
        // Reading follows links, so both the link and its target are inputs.
        taken.extend(resolve_parent(input).map(|path| (path, "a file that is read")));
        taken.extend(input.canonicalize().map(|path| (path, "a file that is read")));
    }
    let outputs = [
        ("-o", Some(&args.files.output)),
        ("--report", args.files.report.as_ref()),
        ("--stl", args.files.stl.as_ref()),
    ];
    for (option, output) in outputs.into_iter().filter_map(|(option, output)| Some((option, output?))) {
        let wrong = |what: String| UsageError(format!("{option} {}: {what}", output.display()));
        let folder = parent_folder(output);
        if !folder.is_dir() {
            return Err(wrong(format!("there is no folder {}", folder.display())).into());
        }
        let path = resolve_parent(output).filter(|path| !path.is_dir());
        let path = path.ok_or_else(|| wrong("this is a folder; name a file".to_owned()))?;
        if let Some((_, other)) = taken.iter().find(|(known, _)| *known == path) {
            return Err(wrong(format!("this is also {other}, which would be overwritten")).into());
        }
        taken.push((path, option));
    }
    Ok(())
}

/// The folder of a path's file.
fn parent_folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The canonical form of an output path. The output is written by a rename, which replaces a link and does not follow
/// it, so only the folder is resolved. `None`: the path has no file name, or its folder does not exist.
fn resolve_parent(path: &Path) -> Option<PathBuf> {
    Some(parent_folder(path).canonicalize().ok()?.join(path.file_name()?))
}
