//! Entry point: passes the arguments to `cli` and returns its exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    nestd::cli::main()
}
