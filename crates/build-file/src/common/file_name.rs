//! The name of a build file: `<utc>_<machine>_<build-id>.build.3mf`.

/// `20261120T044900Z_mjf-5200_000042.build.3mf`: ASCII, sortable, no spaces, at most 100 characters. Core 1.4 reserves the
/// double suffix for a complete plate. Sidecars share the stem.
pub fn build_file_name(created_utc: jiff::Timestamp, machine: &str, build_id: u64) -> String {
    let machine: String = (machine.chars().take(50))
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '.' { c } else { '-' })
        .collect();
    format!("{}_{machine}_{build_id:06}.build.3mf", created_utc.strftime("%Y%m%dT%H%M%SZ"))
}
