//! Forecast of a reference of any length, in pieces.

#[cfg(test)]
mod tests;

use datasets::{Lengths, LongFile, Piece};
use machine::Machine;
use models::{Bundle, LearnedMachine, PEAK_S};
use motion::contour::{ContourSummary, ExactStream, Window};
use motion::{Axis, Trajectory};

use crate::error::{Error, Result};
use crate::expectation::{Expectation, ExpectationSum};
use crate::input::Input;
use crate::pieces::{Approach, RmsMax, later};
use crate::progress::{Job, Progress, Steps};
use crate::setup::Setup;
use crate::tally::Tally;
use crate::travel;

/// Length of a piece, s, and of what is read before and after it: the memory of a model.
const PIECE_S: f64 = 60.0;
const BESIDE_S: f64 = 2.0;

/// Forecast for a reference. The 95th percentile comes from a histogram, to half a per cent; everything else is that of the whole.
#[derive(Debug)]
pub struct Forecast {
    /// Axes of the reference.
    pub axes: Vec<Axis>,
    /// Time from the first sample to the last, s.
    pub duration_s: f64,
    /// Predicted contour error, mm.
    pub contour: ContourSummary,
    /// RMS and largest predicted tracking error of every axis, mm or rad.
    pub tracking: Vec<(f64, f64)>,
    /// What a run is expected to come to.
    pub expected: Option<Expectation>,
}

/// Samples of the reference and of the forecast, one column an axis.
pub type Columns<'a> = [Vec<&'a [f64]>; 2];

/// Forecasts the reference in `file`, in pieces of `piece_s` seconds where that is given. `write` gets the samples in their order. `None` on a
/// machine with rotary axes.
///
/// # Errors
/// When the reference does not fit model or machine, the file cannot be read, `write` fails, or `progress` cancels.
pub fn forecast(
    model: &Bundle,
    setup: &Setup,
    file: &LongFile,
    piece_s: Option<f64>,
    write: &mut dyn FnMut(Columns<'_>) -> Result<()>,
    progress: Progress<'_>,
) -> Result<Option<Forecast>> {
    if setup.kinematics.has_rotary_axes() {
        return Ok(None);
    }
    let (period_s, name) = (file.period_s(), file.name());
    let samples = |seconds: f64| (seconds / period_s).round().max(1.0) as usize;
    // The peaks of the expectation are those of the same half seconds, wherever the path is cut.
    let own = samples(PEAK_S) * (piece_s.unwrap_or(PIECE_S) / PEAK_S).round().max(1.0) as usize;
    let lengths = Lengths { own, before: samples(BESIDE_S), after: samples(BESIDE_S) };
    let steps = Steps::new(progress, Job::Forecasting, file.len().div_ceil(own));
    let mut sums = Sums::new(model, file.axes(), lengths.before)?;
    for piece in file.pieces(lengths)? {
        let piece = piece?;
        let by_s = piece.first as f64 * period_s;
        let actual = sums.add(model, setup, &name, &piece).map_err(|error| later(error, by_s))?;
        let of = |run: &'_ Trajectory| -> Vec<Vec<f64>> {
            run.columns().iter().map(|column| column[piece.own.clone()].to_vec()).collect()
        };
        let [reference, actual] = [of(&piece.reference), of(&actual)];
        write([reference.iter().map(Vec::as_slice).collect(), actual.iter().map(Vec::as_slice).collect()])?;
        steps.step(&format!("{:.0} s", by_s))?;
    }
    sums.finish(file).map(Some)
}

/// Sums over the samples of a reference.
struct Sums<'a> {
    machine: LearnedMachine,
    approaches: Vec<Approach>,
    tracking: Vec<RmsMax>,
    stream: ExactStream,
    contour: Tally,
    next: usize,
    expected: ExpectationSum<'a>,
}

impl<'a> Sums<'a> {
    fn new(model: &Bundle, axes: &[Axis], before: usize) -> Result<Self> {
        Ok(Self {
            machine: model.machine()?,
            approaches: axes.iter().map(|_| Approach::new(before)).collect(),
            tracking: vec![RmsMax::default(); axes.len()],
            stream: ExactStream::new(Window::default())?,
            contour: Tally::default(),
            next: 0,
            expected: ExpectationSum::default(),
        })
    }

    /// Adds the next piece, and returns its forecast.
    fn add(&mut self, model: &'a Bundle, setup: &Setup, name: &str, piece: &Piece) -> Result<Trajectory> {
        let reference = &piece.reference;
        let input = Input::reference(name, reference.clone(), Some(setup))?;
        travel::check(&input, setup)?;
        let columns = reference.columns().iter().zip(&mut self.approaches);
        let approached =
            columns.map(|(column, approach)| approach.to(column, piece.first, piece.own.clone(), reference.period_s()));
        let run = self.machine.run(&reference.with_columns(approached.collect())?)?;
        let before = run.len() - reference.len();
        let actual = reference.with_columns(run.columns().iter().map(|column| column[before..].to_vec()).collect())?;
        let tips = input.desired().tips_of(&actual)?;
        for k in piece.own.clone() {
            for ((sum, reference), actual) in self.tracking.iter_mut().zip(reference.at(k)).zip(actual.at(k)) {
                sum.note(reference - actual);
            }
            if let Some(error) = self.stream.push(tips[k], input.desired().poses()[k].tip)? {
                self.note(error.magnitude_mm);
            }
        }
        self.expected.add(ExpectationSum::of(model, &input, reference, &actual, piece.own.clone())?);
        Ok(actual)
    }

    fn note(&mut self, error_mm: f64) {
        self.contour.note(self.next, error_mm);
        self.next += 1;
    }

    fn finish(mut self, file: &LongFile) -> Result<Forecast> {
        let mut rest = Vec::new();
        self.stream.finish(&mut rest);
        rest.iter().for_each(|error| self.note(error.magnitude_mm));
        Ok(Forecast {
            axes: file.axes().to_vec(),
            duration_s: file.len().saturating_sub(1) as f64 * file.period_s(),
            contour: self.contour.summary().ok_or(Error::NoSamples)?,
            tracking: self.tracking.iter().map(RmsMax::figures).collect(),
            expected: self.expected.expectation(),
        })
    }
}
