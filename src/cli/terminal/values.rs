//! Parsers of option values that several commands use.

use clap::{Arg, Command, builder::UnknownArgumentValueParser};
use glam::DVec3;
use nester::VolumeMargins;

/// Longest side of a picture, pixels. Drawing the largest picture needs half a gigabyte of memory.
const MAX_PIXELS: u32 = 4096;

/// Tells whoever gives `--profile`, as a machine was named before, how it is named now: with every command that takes a machine.
pub(crate) fn with_former_option(command: Command) -> Command {
    let is_option = command.get_arguments().any(|arg| arg.get_long() == Some("machine"));
    let is_named = |arg: &Arg| {
        let names = arg.get_value_names().unwrap_or_default();
        arg.is_positional() && names.iter().any(|name| name.contains("MACHINE"))
    };
    let told = match () {
        () if is_option => Some(UnknownArgumentValueParser::suggest_arg("--machine")),
        () if command.get_arguments().any(is_named) => {
            Some(UnknownArgumentValueParser::suggest("the machine is named without an option: MACHINE"))
        }
        () => None,
    };
    let command = match told {
        Some(told) => command.arg(Arg::new("profile").long("profile").hide(true).value_parser(told)),
        None => command,
    };
    command.mut_subcommands(with_former_option)
}

/// `380x284x380`.
pub(crate) fn parse_volume(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(['x', 'X']).map(|n| n.trim().parse().ok()).collect();
    let size = numbers.and_then(|n| <[f64; 3]>::try_from(n).ok()).map(DVec3::from_array);
    size.filter(|s| s.is_finite() && s.min_element() > 0.0)
        .ok_or_else(|| "wants three sizes, e.g. 380x284x380".to_owned())
}

/// Width and height of a picture: `1024x768`.
pub(crate) fn parse_pixels(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=MAX_PIXELS).contains(side));
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| side(width).zip(side(height)));
    sides.ok_or_else(|| format!("wants width and height, 1 to {MAX_PIXELS} pixels each, e.g. 1024x768"))
}

/// A share of a whole: above 0, at most 1.
pub(crate) fn parse_share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|share: &f64| *share > 0.0 && *share <= 1.0);
    number.ok_or_else(|| "wants a share above 0, at most 1, e.g. 0.3".to_owned())
}

/// `2` (all around) or `2,5,3` (walls, floor, lid).
pub(crate) fn parse_margins(text: &str) -> Result<VolumeMargins, String> {
    let wrong = || "wants one distance in mm, or those to walls, floor and lid, e.g. 2,5,3".to_owned();
    let numbers =
        text.split(',').map(|n| parse_distance(n.trim())).collect::<Result<Vec<f64>, _>>().map_err(|_| wrong())?;
    match numbers[..] {
        [all] => Ok(VolumeMargins { wall_mm: all, floor_mm: all, lid_mm: all }),
        [wall_mm, floor_mm, lid_mm] => Ok(VolumeMargins { wall_mm, floor_mm, lid_mm }),
        _ => Err(wrong()),
    }
}

/// A distance in mm.
pub(crate) fn parse_distance(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|d: &f64| d.is_finite() && *d >= 0.0);
    number.ok_or_else(|| "wants a distance in mm".to_owned())
}

/// The number of a build: `4`, or `b4` as `nestd show` accepts it.
pub(crate) fn parse_build_number(text: &str) -> Result<i64, String> {
    parse_prefixed_number(text, 'b')
        .ok_or_else(|| "wants a build as status and history print it, e.g. 4 or b4".to_owned())
}

/// The number of a part: `5`, or `p5` as `nestd show` accepts it.
pub(crate) fn parse_part_number(text: &str) -> Result<i64, String> {
    parse_prefixed_number(text, 'p').ok_or_else(|| "wants a part as status and show print it, e.g. 5 or p5".to_owned())
}

/// A part and a number of its copies: `5=2` or `p5=2`.
pub(crate) fn parse_part_copies(text: &str) -> Result<(i64, u32), String> {
    let wrong = || "wants a part and a number of copies, e.g. 5=2".to_owned();
    let (part, copies) = text.split_once('=').ok_or_else(wrong)?;
    let copies = copies.trim().parse().ok().filter(|copies| *copies > 0).ok_or_else(wrong)?;
    Ok((parse_part_number(part.trim())?, copies))
}

/// A number with or without its letter.
pub(crate) fn parse_prefixed_number(text: &str, letter: char) -> Option<i64> {
    let digits = text.strip_prefix([letter, letter.to_ascii_uppercase()]).unwrap_or(text);
    digits.parse().ok().filter(|number| *number >= 0)
}

/// A value of one of the settings' enumerations.
pub fn parse_word<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(serde_json::Value::String(text.to_owned())).map_err(|error| {
        // The parser names what was given, then all that is known.
        let told = error.to_string();
        let known: Vec<&str> = told.split('`').skip(1).step_by(2).skip(1).collect();
        if known.is_empty() { told } else { format!("wants one of {}", known.join(", ")) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_that_is_none_is_told_the_words_that_there_are() {
        let told = parse_word::<build_file::LengthUnit>("furlong").unwrap_err();
        assert!(told.starts_with("wants one of ") && told.contains("inch") && !told.contains('`'), "{told}");
        assert!(parse_word::<build_file::LengthUnit>("inch").is_ok());
    }
}
