//! What the command line asks for. What cargo and libtest's users say besides is let pass.

/// The arguments of a run.
#[derive(Debug, Default)]
pub struct Asked {
    /// Minutes for all sections together; `None` = a short run.
    pub minutes: Option<f64>,
    /// Sections that were named; empty = all.
    only: Vec<String>,
    /// Only a list of tests was asked for: nothing runs.
    list: bool,
}

impl Asked {
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

    /// Whether a section is to be run; a name asks for all sections that contain it, as libtest does.
    pub fn wants(&self, section: &str) -> bool {
        !self.list && (self.only.is_empty() || self.only.iter().any(|name| section.contains(name)))
    }

    /// Whether this is a long run of everything, which is what the document tells of.
    pub fn is_whole(&self) -> bool {
        self.minutes.is_some() && self.only.is_empty() && !self.list
    }
}
