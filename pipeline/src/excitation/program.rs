//! An excitation run as a part program in the dialect of its control.

use gcode::{Feed, MoveKind, append_number, format_number};
use motion::{Axis, AxisKind, Trajectory};

use super::style::{FEED_DECIMALS, Style, WAIT_S, header, in_work_coordinates};
use crate::error::{Error, ProgramFault};
use crate::refit::TimeEncoding;
use crate::units::in_programs;

/// Relative difference between program time and run time that rounding may cause.
const TIME_SHARE: f64 = 0.01;

/// Program of short lines through `reference`, whose positions are program coordinates, mm and rad; `number` is the
/// index of the run, from 0.
///
/// The program first raises the tool to the highest Z of the run, then moves above the first point, then descends at a
/// feed. The text is read back and compared with `reference`. `None` where an axis is [without a word](without_words).
///
/// # Errors
/// When a position cannot be written, or the text read back does not match.
pub fn program(name: &str, number: usize, reference: &Trajectory, style: &Style) -> Result<Option<String>, Error> {
    if !without_words(reference.axes()).is_empty() {
        return Ok(None);
    }
    let reference = in_work_coordinates(reference, style)?;
    written(name, number, &reference, style).map(Some).map_err(|source| Error::Excitation { run: name.to_owned(), source })
}

/// The axes whose positions no word of a part program states: those other than x, y, z, a, b, c, such as an arm's joints.
#[must_use]
pub fn without_words(axes: &[Axis]) -> Vec<&str> {
    axes.iter().filter(|axis| axis.slot().is_none()).map(|axis| axis.name.as_str()).collect()
}

fn written(name: &str, number: usize, reference: &Trajectory, style: &Style) -> Result<String, ProgramFault> {
    let mut lines = Lines { reference, style, text: String::new(), words: Vec::new(), at: Vec::new(), ends: Vec::new() };
    lines.motion()?;
    let ranges: Vec<[f64; 2]> = reference.columns().iter().map(|column| extent(column)).collect();
    let mut header = header(name, (reference.axes(), &ranges), reference.duration_s(), style, lines.feeds());
    header.push("The time is that of a control that keeps these feeds".to_owned());
    let text = style.framed(number, &header, &lines.text);
    check(&text, reference, &lines.ends, style)?;
    Ok(text)
}

fn extent(column: &[f64]) -> [f64; 2] {
    [column.iter().copied().fold(f64::INFINITY, f64::min), column.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

/// End of a written line, and its duration.
struct End {
    /// Position as read back, in the order of the reference's axes, mm and rad.
    at: Vec<f64>,
    /// Speed of the linear axes, mm/min.
    feed_mm_min: f64,
    seconds: f64,
}

/// State of the motion while it is written.
struct Lines<'a> {
    reference: &'a Trajectory,
    style: &'a Style,
    text: String,
    /// Words of the last written position.
    words: Vec<String>,
    /// The last written position as read back, mm and rad.
    at: Vec<f64>,
    ends: Vec<End>,
}

impl Lines<'_> {
    fn motion(&mut self) -> Result<(), ProgramFault> {
        let Style { encoding, spacing_s, .. } = *self.style;
        let period_s = self.reference.period_s();
        self.text += &self.style.first_block()?;
        self.approach()?;
        self.text += &format!("{}\n", self.style.dwell(WAIT_S)?);
        if encoding == TimeEncoding::G93 {
            self.text += "G93\n";
        }
        let stride = ((spacing_s / period_s).round() as usize).max(1);
        let last = self.reference.len().saturating_sub(1);
        let (mut from, mut waited) = (0, 0);
        for k in (stride..last).step_by(stride).chain([last]) {
            let (words, at) = self.words_at(k)?;
            if words == self.words {
                waited += k - from;
            } else {
                self.wait(waited as f64 * period_s)?;
                waited = 0;
                self.line(words, at, (k - from) as f64 * period_s)?;
            }
            from = k;
        }
        if encoding == TimeEncoding::G93 {
            self.text += "G94\n";
        }
        self.text += &format!("{}\n", self.style.dwell(WAIT_S)?);
        Ok(())
    }

    /// Raises the tool, moves above the first point, descends.
    fn approach(&mut self) -> Result<(), ProgramFault> {
        let (words, at) = self.words_at(0)?;
        let z = self.reference.axes().iter().position(|axis| axis.name == "z");
        if let Some(z) = z {
            let [_, highest] = extent(&self.reference.columns()[z]);
            self.text += &format!("G0 Z{}\n", format_number(highest, self.style.decimals)?);
        }
        let others: Vec<&str> = (0..words.len()).filter(|axis| Some(*axis) != z).map(|axis| words[axis].as_str()).collect();
        if !others.is_empty() {
            self.text += &format!("G0 {}\n", others.join(" "));
        }
        if let Some(z) = z {
            self.text += &format!("G1 {} F{}\n", words[z], format_number(self.style.plunge_mm_min, FEED_DECIMALS)?);
        }
        (self.words, self.at) = (words, at);
        Ok(())
    }

    /// Words of a sample, one for each axis, and the position as read back.
    fn words_at(&self, sample: usize) -> Result<(Vec<String>, Vec<f64>), ProgramFault> {
        let axes = self.reference.axes().iter().zip(self.reference.at(sample));
        axes.map(|(axis, position)| {
            let (scale, _) = in_programs(axis.kind);
            let mut word = axis.name.to_ascii_uppercase();
            let read = append_number(&mut word, position * scale, self.style.decimals)?;
            Ok((word, read / scale))
        })
        .collect::<Result<Vec<_>, ProgramFault>>()
        .map(|words| words.into_iter().unzip())
    }

    fn wait(&mut self, seconds: f64) -> Result<(), ProgramFault> {
        if seconds > 0.0 {
            self.text += &format!("{}\n", self.style.dwell(seconds)?);
        }
        Ok(())
    }

    fn line(&mut self, words: Vec<String>, at: Vec<f64>, seconds: f64) -> Result<(), ProgramFault> {
        let distance = |kind: AxisKind| {
            let steps = self.reference.axes().iter().zip(at.iter().zip(&self.at)).filter(|(axis, _)| axis.kind == kind);
            steps.map(|(_, (to, from))| (to - from).powi(2)).sum::<f64>().sqrt()
        };
        let (linear_mm, rotary_deg) = (distance(AxisKind::Linear), distance(AxisKind::Rotary).to_degrees());
        // F is the speed of the linear axes; where none of them moves, that of the rotary axes in degrees.
        let length = if linear_mm > 0.0 { linear_mm } else { rotary_deg };
        let feed = match self.style.encoding {
            TimeEncoding::G93 => 60.0 / seconds,
            TimeEncoding::G94 | TimeEncoding::Keep => (length / seconds * 60.0).max(1e-4),
        };
        // Words without motion would make a pure rotation look like a move of the linear axes.
        let moved: Vec<&str> = words.iter().zip(&self.words).filter(|(to, from)| to != from).map(|(to, _)| to.as_str()).collect();
        self.text += &format!("G1 {} F{}\n", moved.join(" "), format_number(feed, FEED_DECIMALS)?);
        self.ends.push(End { at: at.clone(), feed_mm_min: linear_mm / seconds * 60.0, seconds });
        (self.words, self.at) = (words, at);
        Ok(())
    }

    /// Lowest and highest speed of the linear axes, mm/min; `None` where none of them moves.
    fn feeds(&self) -> Option<(f64, f64)> {
        let feeds: Vec<f64> = self.ends.iter().map(|end| end.feed_mm_min).filter(|feed| *feed > 0.0).collect();
        (!feeds.is_empty()).then(|| extent(&feeds)).map(|[slowest, fastest]| (slowest, fastest))
    }
}

/// Reads the program as its control does and checks the end of every line and the total time.
fn check(text: &str, reference: &Trajectory, ends: &[End], style: &Style) -> Result<(), ProgramFault> {
    let program = gcode::parse(text.as_bytes().to_vec());
    let toolpath = gcode::interpret(&program, &style.options(&program))?;
    let feeds: Vec<&gcode::Move> = toolpath.moves.iter().filter(|of| of.is_feed()).collect();
    // The descent comes first.
    let lines = feeds.get(feeds.len().saturating_sub(ends.len())..).unwrap_or_default();
    if lines.len() != ends.len() {
        return Err(ProgramFault::Lines { read: lines.len(), wanted: ends.len() });
    }
    let rounding = 0.51 * 0.1_f64.powi(i32::try_from(style.decimals).unwrap_or(i32::MAX)) + 1e-9;
    let (mut read_s, mut wanted_s) = (0.0, 0.0);
    for (line, end) in lines.iter().zip(ends) {
        let (linear, rotary) = (line.end.nominal_mm(), line.end.nominal_rotary_rad());
        let positions = reference.axes().iter().zip(&end.at).filter_map(|(axis, wanted)| Some((axis.slot()?, wanted)));
        for (slot, wanted) in positions {
            let read = if slot < 3 { linear[slot] } else { rotary[slot - 3] };
            if (read - wanted).is_nan() || (read - wanted).abs() > rounding {
                return Err(ProgramFault::Elsewhere { line: line.block as usize + 1, read, wanted: *wanted });
            }
        }
        let length_mm = line.length_mm().unwrap_or(0.0);
        let turned_rad = (0..3).map(|axis| (rotary[axis] - line.start.nominal_rotary_rad()[axis]).powi(2)).sum::<f64>().sqrt();
        read_s += match line.feed {
            Some(Feed::Linear { mm_s }) => length_mm / mm_s,
            Some(Feed::Angular { rad_s }) => turned_rad / rad_s,
            Some(Feed::Duration { seconds }) => seconds,
            None => return Err(ProgramFault::NoFeed { line: line.block as usize + 1 }),
        };
        wanted_s += end.seconds;
    }
    if read_s.is_nan() || (read_s - wanted_s).abs() > TIME_SHARE * wanted_s {
        return Err(ProgramFault::Time { read_s, wanted_s });
    }
    let waits = toolpath.moves.iter().filter_map(|of| match of.kind {
        MoveKind::Dwell { seconds } => Some(seconds.unwrap_or(f64::INFINITY)),
        _ => None,
    });
    let (waited_s, longest_s) = (waits.sum::<f64>(), reference.duration_s() + 2.0 * WAIT_S);
    if waited_s.is_nan() || waited_s > longest_s {
        return Err(ProgramFault::Waits { waited_s, longest_s });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use gcode::Dialect;
    use machine::MachineSpec;
    use motion::Axis;

    use super::*;
    use crate::output::{OutputFormat, OutputSettings};
    use crate::setup::Setup;

    /// Descent from above with a dwell half-way.
    fn run() -> Trajectory {
        let ease = |k: i32| (std::f64::consts::PI * f64::from(k.clamp(0, 100)) / 100.0).cos();
        let columns = [(20.0, 0), (-5.0, 0), (24.0, 50), (0.4, 0)]
            .map(|(size, late)| (0..260).map(|k| size * if k < 100 { ease(k - late) } else { ease(k - 60 - late) }).collect());
        Trajectory::new(0.002, ["x", "y", "z", "c"].map(Axis::named).to_vec(), columns.to_vec()).unwrap()
    }

    fn style(controller: Option<&str>, format: Option<OutputFormat>) -> Style {
        let profile = controller.map(|name| machine::ControllerSpec::builtin(name).unwrap());
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), profile).unwrap();
        Style::of(&OutputSettings::new(&setup, format, None, None).refit(), None, &setup)
    }

    fn written(controller: Option<&str>) -> String {
        program("01-full", 0, &run(), &style(controller, None)).unwrap().unwrap()
    }

    #[test]
    fn every_control_gets_words_that_it_reads() {
        for name in [None, Some("linuxcnc"), Some("fanuc"), Some("siemens"), Some("grbl"), Some("generic")] {
            let text = written(name);
            let linuxcnc = name == Some("linuxcnc");
            assert_eq!((text.contains("G64 P"), text.contains("G93")), (linuxcnc, linuxcnc), "{name:?}");
            assert_eq!((text.contains("\nO7001\n"), text.contains("G4 P500\n")), (name == Some("fanuc"), name == Some("fanuc")));
            let siemens = name == Some("siemens");
            assert_eq!(
                (text.starts_with("; "), text.contains("G4 F0.5\n"), text.contains(['(', '%'])),
                (siemens, siemens, !siemens)
            );
            let decimals = text
                .lines()
                .filter(|line| line.starts_with("G1 "))
                .flat_map(|line| line.split(' '))
                .filter(|word| word.starts_with('X'))
                .map(|word| word.split_once('.').map_or(0, |(_, digits)| digits.len()));
            let most = match name {
                Some("fanuc" | "grbl") => 4,
                Some("generic") => 5,
                _ => 6,
            };
            assert_eq!(decimals.max(), Some(most), "{name:?}");
        }
    }

    #[test]
    fn the_tool_is_lifted_first_and_lowered_at_a_feed() {
        let text = written(Some("fanuc"));
        let moves: Vec<&str> = text.lines().filter(|line| line.starts_with(['G']) && line[2..].starts_with(' ')).collect();
        assert_eq!(&moves[..3], ["G0 Z24.", "G0 X20. Y-5. C22.9183", "G1 Z24. F600."], "{text}");
        assert_eq!(text.matches("G0 ").count(), 2);
    }

    #[test]
    fn the_header_says_what_will_move_and_how_far() {
        let text = written(None);
        for line in ["(RUN FROM A CLEAR START: NO TOOL, NO PART)", "(X -20.000 TO 20.000 MM)", "(C -22.918 TO 22.918 DEG)"] {
            assert!(text.contains(line), "{text}");
        }
        assert!(
            text.contains("FOR MACHINE BALLSCREW")
                && text.contains("ACTIVE WORK OFFSET, G54")
                && text.contains(" MM/MIN, 0.5 S)"),
            "{text}"
        );
    }

    #[test]
    fn a_program_that_reads_back_as_another_is_refused() {
        let keep = OutputFormat::Program(TimeEncoding::Keep);
        let style = Style { dialect: Some(Dialect::Fanuc), ..style(None, Some(keep)) };
        let mut lines =
            Lines { reference: &run(), style: &style, text: String::new(), words: Vec::new(), at: Vec::new(), ends: Vec::new() };
        lines.motion().unwrap();
        assert!(check(&lines.text, &run(), &lines.ends, &style).is_ok());
        let mended = lines.text.replacen("G4 P500", "G4 X500.", 1);
        assert!(check(&mended, &run(), &lines.ends, &style).unwrap_err().to_string().contains("waits"));
        let mended = lines.text.replace("G94", "G95 S100");
        assert!(check(&mended, &run(), &lines.ends, &style).is_err());
        lines.ends[7].at[1] += 1e-3;
        assert!(check(&lines.text, &run(), &lines.ends, &style).unwrap_err().to_string().contains("leads to"));
    }
}
