//! Output settings of compensated programs.

use gcode::{Dialect, Language, MoveKind};
use machine::ControllerSpec;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::part::{Part, coordinates};

/// Time encoding: how the lines of a compensated program state their time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeEncoding {
    /// Inverse time: `F` is one over the line's duration in minutes at the largest speed that the plan has in it.
    G93,
    /// Feed per minute: an `F` on every line, the largest speed that the plan has in it.
    G94,
    /// The program's own feed words, unchanged.
    Keep,
}

impl TimeEncoding {
    /// Name on the command line: `g93`, `g94` or `keep`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::G93 => "g93",
            Self::G94 => "g94",
            Self::Keep => "keep",
        }
    }
}

/// A slow zone before every stop. Axes that lead the command while it brakes pass the end of the path, and come back; no shift of
/// points prevents it, since the control brakes towards the same end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowStop {
    /// Length of the zone along the path, mm.
    pub length_mm: f64,
    /// Time in which it is covered, s.
    pub time_s: f64,
}

impl SlowStop {
    /// Least speed of a slow line, mm/s: controls take feeds from 1 mm/min on (Fanuc 0i-F, B-64604EN).
    pub const LEAST_MM_S: f64 = 1.0 / 60.0;

    /// Speed in the zone, mm/s.
    #[must_use]
    pub fn speed_mm_s(self) -> f64 {
        self.length_mm / self.time_s
    }
}

/// Settings for writing a compensated program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefitSettings {
    /// Time encoding of the lines.
    pub encoding: TimeEncoding,
    /// Decimals of a coordinate in mm; inch coordinates get one more.
    pub decimals: usize,
    /// The same of increments (G91), where it is another: rounding that a control adds to every increment adds up along the program.
    pub increment_decimals: Option<usize>,
    /// Least time between points within one move, s.
    pub spacing_s: f64,
    /// Largest distance of a line between points from the corrected curve, mm.
    pub chord_tolerance_mm: f64,
    /// Path tolerance that segments state, mm, where the control has one; `None` keeps the program's own.
    pub path_tolerance_mm: Option<f64>,
    /// Slow zone before stops; `None` for none.
    pub slow_stop: Option<SlowStop>,
}

/// Largest distance of a written line from the corrected curve between its ends, mm.
const CHORD_TOLERANCE_MM: f64 = 2e-4;
/// Default decimals of coordinates in mm, where neither the caller nor the control profile states them: those for LinuxCNC.
pub const DECIMALS: usize = 6;
/// Decimals of the least input increment of usual controls (IS-B of Fanuc: 0.001 mm, 0.0001 in), mm.
pub(super) const INCREMENT_DECIMALS: usize = 3;
/// Default time between points, ms, likewise: that of LinuxCNC. On four NIST programs and the demo machine, 8 ms forecast 0.07 to 0.09 µm RMS
/// and no longer cycle, 4 ms 0.08 to 0.16 µm and up to 12 % more cycle time.
const SPACING_MS: f64 = 8.0;

/// Decimals of a coordinate in mm that dialogue can have (TNC 640, Technical Information: ±99 999.9999).
const DIALOGUE_DECIMALS: usize = 4;

/// Digits that a coordinate of Fanuc's controls and those like them may have (±99999.999 mm, Operator's Manuals, "Range of command value"); a
/// longer one is an alarm there.
const WORD_DIGITS: usize = 8;

/// Largest correction that is taken into account where digits are counted, mm.
const MOST_SHIFT_MM: f64 = 1.0;

/// Digits of the words of a part that stand beside the decimals of a coordinate in mm: before the point, and the one more that inches have.
fn most_digits(part: &Part) -> usize {
    let digits = |value: f64| value.max(1.0).log10().floor() as usize + 1;
    let of = |step: &gcode::Move| {
        let modal = part.toolpath.modal(step);
        let unit = modal.units.mm();
        let [start, end] = [&step.start, &step.end].map(coordinates);
        let words = |axis: usize| [start[axis], end[axis]].into_iter().map(move |at| (at - modal.shift[axis]).abs());
        let mut largest_mm = (0..3).flat_map(words).fold(0.0, f64::max);
        if let MoveKind::Arc(arc) = &step.kind {
            let [first, second, _] = arc.plane.axes();
            let radius_mm = arc.radius_start_mm.max(arc.radius_end_mm);
            let about = [first, second]
                .into_iter()
                .zip(arc.centre_mm)
                .map(|(axis, centre)| (centre - modal.shift[axis]).abs() + radius_mm);
            largest_mm = about.fold(largest_mm, f64::max);
        }
        let turns = (3..6).flat_map(words).fold(0.0, f64::max).to_degrees();
        let more = usize::from(unit != 1.0);
        (digits((largest_mm + MOST_SHIFT_MM) / unit) + more).max(digits(turns))
    };
    part.toolpath.moves.iter().filter(|step| part.is_shiftable(step)).map(of).max().unwrap_or(1)
}

impl RefitSettings {
    /// The same within what the language of a program allows.
    ///
    /// # Errors
    /// [`Error::DialogueTimes`] for a time encoding that dialogue does not have.
    pub fn suited_to(self, part: &Part) -> Result<Self> {
        // Decimals that nobody states.
        let open = self.increment_decimals.is_some() && part.program.language() == Language::Rs274;
        let decimals = match part.options.dialect {
            Dialect::Fanuc if open => self.decimals.min(WORD_DIGITS.saturating_sub(most_digits(part)).max(INCREMENT_DECIMALS)),
            _ => self.decimals,
        };
        let increment_decimals = self.increment_decimals.filter(|_| part.shifts_increments());
        Self { decimals, increment_decimals, ..self }.in_language_of(part)
    }

    fn in_language_of(self, part: &Part) -> Result<Self> {
        match (part.program.language(), self.encoding) {
            // LinuxCNC adds increments as it reads them.
            (Language::Rs274, _) if part.options.dialect == Dialect::LinuxCnc => Ok(Self { increment_decimals: None, ..self }),
            (Language::Rs274 | Language::Sinumerik, _) => Ok(self),
            (Language::Dialogue, TimeEncoding::Keep) => {
                Ok(Self { decimals: self.decimals.min(DIALOGUE_DECIMALS), increment_decimals: None, ..self })
            }
            (Language::Dialogue, _) => Err(Error::DialogueTimes { name: part.name.clone(), encoding: self.encoding.name() }),
        }
    }

    /// Given values, else those of the control profile, else the defaults.
    #[must_use]
    pub fn of(
        encoding: TimeEncoding,
        decimals: Option<usize>,
        spacing_ms: Option<f64>,
        controller: Option<ControllerSpec>,
    ) -> Self {
        let profile = controller;
        let stated = decimals.or(profile.map(|profile| usize::from(profile.decimals)));
        Self {
            encoding,
            decimals: stated.unwrap_or(DECIMALS),
            increment_decimals: stated.is_none().then_some(INCREMENT_DECIMALS),
            spacing_s: spacing_ms.unwrap_or(profile.map_or(SPACING_MS, |profile| profile.point_spacing_ms)) * 1e-3,
            chord_tolerance_mm: CHORD_TOLERANCE_MM,
            path_tolerance_mm: profile.and_then(|profile| profile.path_tolerance_mm),
            slow_stop: None,
        }
    }
}
