//! Ranges of all numbers on the command line.
//!
//! Each range holds every sensible use with a wide margin. It excludes typing errors, wrong units,
//! and numbers with which a command would take hours or gigabytes.

use std::fmt::Display;
use std::str::FromStr;

/// Learning gain of an ILC. An update of more than the whole error diverges from 2 on.
pub fn gain(text: &str) -> Result<f64, String> {
    within(text, 1e-3, 2.0)
}

/// Cut-off of a low-pass, Hz.
pub fn low_pass_hz(text: &str) -> Result<f64, String> {
    within(text, 0.1, 1e5)
}

/// Feed of a test curve, mm/s.
pub fn feed_mm_s(text: &str) -> Result<f64, String> {
    within(text, 0.1, 1e4)
}

/// Sampling period of a log, ms: the range of logs with time stamps.
pub fn period_ms(text: &str) -> Result<f64, String> {
    within(text, 1e-3, 1e4)
}

/// Time between points, ms: the range of a controller profile.
pub fn spacing_ms(text: &str) -> Result<f64, String> {
    within(text, 1e-2, 1e4)
}

/// Tolerance of corners, mm: the range of a machine file.
pub fn corner_tolerance_mm(text: &str) -> Result<f64, String> {
    within(text, 0.0, 10.0)
}

/// Length of a tool, mm.
pub fn tool_length_mm(text: &str) -> Result<f64, String> {
    within(text, -1e4, 1e4)
}

/// Coordinate of a work offset, mm: the range of a machine file.
pub fn offset_mm(text: &str) -> Result<f64, String> {
    within(text, -1e6, 1e6)
}

/// Largest shift of a point, mm.
pub fn max_shift_mm(text: &str) -> Result<f64, String> {
    within(text, 0.0, 100.0)
}

/// Travel of an excitation, mm on either side.
pub fn travel_mm(text: &str) -> Result<f64, String> {
    within(text, 1e-2, 1e4)
}

/// Rotation in an excitation, degrees on either side.
pub fn rotation_deg(text: &str) -> Result<f64, String> {
    within(text, 1e-2, 1e4)
}

/// Duration of an excitation, s.
pub fn excitation_s(text: &str) -> Result<f64, String> {
    within(text, 1.0, 1e5)
}

/// Factor on the noise of a simulated machine.
pub fn noise(text: &str) -> Result<f64, String> {
    within(text, 0.0, 100.0)
}

/// Share of the samples that is held out.
pub fn held_out(text: &str) -> Result<f64, String> {
    within(text, 0.01, 0.9)
}

/// Number of seeds, runs or programs.
pub fn count(text: &str) -> Result<u64, String> {
    within(text, 1, 1000)
}

/// Number of samples of a training: from a minute at 100 Hz on.
pub fn samples(text: &str) -> Result<usize, String> {
    within(text, 6000, 1_000_000_000)
}

/// Number of runs of ILC.
pub fn learning_runs(text: &str) -> Result<usize, String> {
    within(text, 1, 1000)
}

/// Number of iterations; zero for the first forecast alone.
pub fn iterations(text: &str) -> Result<usize, String> {
    within(text, 0, 1000)
}

/// Increase in percent.
pub fn percent(text: &str) -> Result<f64, String> {
    within(text.strip_suffix('%').unwrap_or(text), 0.0, 1e4)
}

/// Relative change from a percentage with its sign: `+1%`, `-20%`.
pub fn change(text: &str) -> Result<f64, String> {
    Ok(0.01 * within(text.strip_suffix('%').unwrap_or(text), -99.0, 1e4)?)
}

/// Feed in a program, in mm/min: `2000`, `2000mm`, `80in`, also with `/min`.
pub fn feed_mm_min(text: &str) -> Result<f64, String> {
    let written = text.strip_suffix("/min").unwrap_or(text);
    let (number, scale) = match (written.strip_suffix("in"), written.strip_suffix("mm")) {
        (Some(inches), _) => (inches, 25.4),
        (None, number) => (number.unwrap_or(written), 1.0),
    };
    Ok(scale * within(number, 1.0, 1e6)?)
}

/// Lines that no program exceeds.
const MOST_LINES: usize = 1_000_000_000;

/// First and last line of a program: `120-480`, or one line.
pub fn lines(text: &str) -> Result<(usize, usize), String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let (first, last) = (within(first, 1, MOST_LINES)?, within(last, 1, MOST_LINES)?);
    if first > last {
        return Err(format!("`{text}` ends before it begins; lines are given as 120-480"));
    }
    Ok((first, last))
}

/// Zero or more, of any unit.
pub fn not_negative(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1e6)
}

/// A length with its unit, in mm: `2um`, `2µm`, `0.002mm`, `0.0001in`.
pub fn length_mm(text: &str) -> Result<f64, String> {
    let units = [("µm", 1e-3), ("um", 1e-3), ("mm", 1.0), ("in", 25.4)];
    let (number, scale) = units
        .iter()
        .find_map(|(unit, scale)| Some((text.strip_suffix(unit)?, scale)))
        .ok_or_else(|| format!("`{text}` needs a unit: um, mm or in, as in 2um"))?;
    Ok(scale * within(number, 1e-6, 1e5)?)
}

/// Letters of axes, each once.
pub fn axes(text: &str) -> Result<String, String> {
    let letters: String =
        text.chars().filter(|letter| !matches!(letter, ' ' | ',')).map(|letter| letter.to_ascii_lowercase()).collect();
    let is_once = |letter: char| letters.matches(letter).count() == 1;
    match letters.chars().all(|letter| "xyzabc".contains(letter) && is_once(letter)) && !letters.is_empty() {
        true => Ok(letters),
        false => Err(format!("`{text}` names no axes: letters out of x y z a b c, each once, as in xyz")),
    }
}

/// Largest speed of an axis, mm/s or °/s.
pub fn speed(text: &str) -> Result<f64, String> {
    within(text, 0.01, 1e5)
}

/// Largest acceleration of an axis, mm/s² or °/s².
pub fn acceleration(text: &str) -> Result<f64, String> {
    within(text, 0.1, 1e7)
}

/// Travel of an axis, mm or degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    /// Name of the axis.
    pub axis: String,
    /// Lowest and highest position.
    pub range: [f64; 2],
}

/// Travel of an axis: `x=-250..250`.
pub fn axis_travel(text: &str) -> Result<Travel, String> {
    let fault = || format!("`{text}` is no travel: write an axis and its lowest and highest position, as in x=-250..250");
    let (axis, range) = text.split_once('=').ok_or_else(fault)?;
    let (low, high) = range.split_once("..").ok_or_else(fault)?;
    let range = [within(low, -1e6, 1e6)?, within(high, -1e6, 1e6)?];
    let axis = axes(axis)?;
    if axis.len() == 1 && range[0] < range[1] { Ok(Travel { axis, range }) } else { Err(fault()) }
}

/// Position of an axis, mm or degrees: `x=150`.
#[derive(Debug, Clone, PartialEq)]
pub struct Position {
    /// Name of the axis.
    pub axis: String,
    /// The position.
    pub at: f64,
}

/// Position of an axis: `x=150`.
pub fn axis_position(text: &str) -> Result<Position, String> {
    let fault = || format!("`{text}` is no position: write an axis and its position, as in x=150");
    let (axis, at) = text.split_once('=').ok_or_else(fault)?;
    let axis = axes(axis)?;
    if axis.len() == 1 { Ok(Position { axis, at: within(at, -1e6, 1e6)? }) } else { Err(fault()) }
}

/// A number within a range.
pub fn within<T: FromStr + PartialOrd + Display>(text: &str, low: T, high: T) -> Result<T, String> {
    match text.trim().parse::<T>() {
        // A value that is no number is in no range.
        Ok(value) if (&low..=&high).contains(&&value) => Ok(value),
        _ => Err(format!("`{text}` is not a number from {low} to {high}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused_with_the_range() {
        for text in ["1e-300", "-1", "0", "nan", "inf", "1e308", "x", ""] {
            assert_eq!(gain(text).unwrap_err(), format!("`{text}` is not a number from 0.001 to 2"));
        }
        assert_eq!((gain("2"), offset_mm(" -12.5 "), count("7")), (Ok(2.0), Ok(-12.5), Ok(7)));
        assert_eq!((change("+1%"), change("-20"), percent("50%")), (Ok(0.01), Ok(-0.2), Ok(50.0)));
        assert!(change("-100%").is_err() && change("1x").is_err());
        assert_eq!((lines("120-480"), lines("7")), (Ok((120, 480)), Ok((7, 7))));
        assert!(lines("0-3").is_err() && lines("9-3").unwrap_err().contains("120-480"));
        assert!(count("0").is_err() && count("1.5").is_err() && iterations("18446744073709551616").is_err());
        assert_eq!(
            ["2000", "2000mm", "80in", "80in/min"].map(|feed| feed_mm_min(feed).unwrap()),
            [2000.0, 2000.0, 2032.0, 2032.0]
        );
        assert!(feed_mm_min("80um").is_err() && feed_mm_min("0").is_err());
        assert!(length_mm("1e300um").is_err() && length_mm("2").unwrap_err().contains("unit"));
    }
}
