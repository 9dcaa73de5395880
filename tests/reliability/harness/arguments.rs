//! The arguments of a run. Further arguments, as cargo and users of libtest give them, are ignored.

/// The arguments of a run.
#[derive(Debug, Default)]
pub struct RunArguments {
    /// Minutes for all sections together; `None` = a short run.
    pub minutes: Option<f64>,
    /// Sections that were named; empty = all.
    only: Vec<String>,
    /// Only a list of tests was requested: nothing runs.
    list: bool,
}

impl RunArguments {
    /// Reads the arguments of this process.
    pub fn from_args() -> Self {
        let mut asked = Self::default();
        let mut args = std::env::args().skip(1);
        while let Some(arg) = args.next() {
            match arg.as_str() {
                "--minutes" => asked.minutes = Some(args.next().unwrap_or_default().parse().expect("--minutes N")),
                "--only" => {
                    asked.only.extend(args.next().unwrap_or_default().split(',').map(|name| name.trim().to_owned()))
                }
                "--test-threads" | "--skip" | "--color" | "--format" | "--logfile" | "-Z" => drop(args.next()),
                "--list" => asked.list = true,
                flag if flag.starts_with('-') => {}
                name => asked.only.push(name.to_owned()),
            }
        }
        asked
    }

    /// Whether a section is to be run; a name selects all sections that contain it, as in libtest.
    pub fn wants(&self, section: &str) -> bool {
        !self.list && (self.only.is_empty() || self.only.iter().any(|name| section.contains(name)))
    }

    /// Whether this is a long run of all sections; only such a run writes the document.
    pub fn is_whole(&self) -> bool {
        self.minutes.is_some() && self.only.is_empty() && !self.list
    }
}
