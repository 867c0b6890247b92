//! Measurement of a log of any length against its own command, in pieces.
//!
//! The figures are those of [`measure`](super::measure()), but for two: the 95th percentile comes from a histogram, to half a per cent, and
//! lags to a thousandth of a sample. Of reversals and segments the largest are listed. There is no circular test.

mod lags;
mod peaks;

use std::collections::VecDeque;

use datasets::{Lengths, LongFile, Piece, PieceFindings, Purpose, Report};
use models::Bundle;
use motion::contour::{ContourError, ExactStream, Window};
use motion::{Trajectory, Vec3};

use super::matching::Match;
use super::measurement::{APART_S, Measurement, Segment, WORST, WorstPoint};
use super::model_check::{Fit, FitSum};
use super::reversals::{Reversal, glitch_samples, tip_component};
use crate::error::{Error, Result};
use crate::input::Input;
use crate::pieces::{RmsMax, later};
use crate::setup::Setup;
use crate::tally::Tally;
use peaks::{Largest, MOST_LISTED, ReversalSum, SegmentSum, WorstSum};

/// Length of a piece, s, and of what is read before and after it: the memory of a model and the longest lag.
const PIECE_S: f64 = 60.0;
const BESIDE_S: f64 = 2.0;

/// A log in a file, to be measured against its own command.
#[derive(Debug)]
pub struct LongLog<'a> {
    file: &'a LongFile,
    setup: Option<&'a Setup>,
    lengths: Lengths,
    lags_s: Vec<Option<f64>>,
}

impl<'a> LongLog<'a> {
    /// Checks the pieces of a log, of `piece_s` seconds where that is given, and finds the lags. `setup` gives the kinematics; `None` is
    /// returned for a machine with rotary axes.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn new(file: &'a LongFile, setup: Option<&'a Setup>, piece_s: Option<f64>) -> Result<Option<(Self, Report)>> {
        let samples = |seconds: f64| (seconds / file.period_s()).round().max(1.0) as usize;
        let lengths = Lengths { own: samples(piece_s.unwrap_or(PIECE_S)), before: samples(BESIDE_S), after: samples(BESIDE_S) };
        if setup.is_some_and(|setup| setup.kinematics.axes() == file.axes() && setup.kinematics.has_rotary_axes()) {
            return Ok(None);
        }
        let mut findings = PieceFindings::default();
        let visit = |piece: &Piece| {
            findings.add(piece, Purpose::Measuring);
            Ok(())
        };
        let lags_s = lags::lags_s(file, lengths, visit)?;
        Ok(Some((Self { file, setup, lengths, lags_s }, findings.into_report())))
    }

    /// Measures the log. With a model also whether that fits.
    ///
    /// # Errors
    /// When the file cannot be read, or the axes of the log do not define a tip.
    pub fn measure(self, model: Option<&Bundle>) -> Result<(Measurement, Option<Vec<Fit>>)> {
        let Self { file, setup, lengths, .. } = &self;
        let mut sums = Sums::new(&self)?;
        let mut fits = model.map(|model| FitSum::new(model, file.axes(), file.period_s(), lengths.before)).transpose()?;
        for piece in file.pieces(*lengths)? {
            let piece = piece?;
            let later = |error| later(error, piece.first as f64 * file.period_s());
            sums.add(&piece, *setup).map_err(later)?;
            if let Some(fits) = &mut fits {
                fits.add(&piece);
            }
        }
        Ok((sums.finish(self.lags_s.clone())?, fits.map(FitSum::finish)))
    }
}

/// Sums over the samples of a log.
struct Sums {
    period_s: f64,
    axes: Vec<motion::Axis>,
    tracking: Vec<RmsMax>,
    stream: ExactStream,
    /// Whether the path moves to the samples whose errors are to come, and the sample of the next error.
    moves: VecDeque<bool>,
    next: usize,
    last: Option<Vec3>,
    contour: Tally,
    worst: WorstSum,
    reversals: Vec<(usize, ReversalSum)>,
    segment: SegmentSum,
    found: (Largest<Reversal>, Largest<Segment>),
}

impl Sums {
    fn new(log: &LongLog<'_>) -> Result<Self> {
        let (file, period_s) = (log.file, log.file.period_s());
        let axes = file.axes().to_vec();
        let reversal = |(index, axis): (usize, &motion::Axis)| {
            let component = tip_component(axis)?;
            let samples = glitch_samples(log.lags_s[index], period_s);
            Some((index, ReversalSum::new(axis.name.clone(), component, samples, period_s)))
        };
        Ok(Self {
            period_s,
            tracking: vec![RmsMax::default(); axes.len()],
            stream: ExactStream::new(Window::default())?,
            moves: VecDeque::new(),
            next: 0,
            last: None,
            contour: Tally::default(),
            worst: WorstSum::new(WORST, (APART_S / period_s).ceil() as usize),
            reversals: axes.iter().enumerate().filter_map(reversal).collect(),
            segment: SegmentSum::new(),
            found: (
                Largest::new(MOST_LISTED, |reversal: &Reversal| reversal.glitch_mm),
                Largest::new(MOST_LISTED, |segment: &Segment| segment.contour.rms_mm),
            ),
            axes,
        })
    }

    fn add(&mut self, piece: &Piece, setup: Option<&Setup>) -> Result<()> {
        let Some(actual) = &piece.actual else { return Ok(()) };
        let path = Input::reference("command", piece.reference.clone(), setup)?;
        let tips = path.desired().tips_of(actual)?;
        let at = |run: &Trajectory, axis: usize, k: usize| run.columns()[axis][k];
        for k in piece.own.clone() {
            for (axis, sum) in self.tracking.iter_mut().enumerate() {
                sum.note(at(&piece.reference, axis, k) - at(actual, axis, k));
            }
            for (axis, reversals) in &mut self.reversals {
                reversals.command(piece.first + k, at(&piece.reference, *axis, k));
            }
            let commanded = path.desired().poses()[k].tip;
            self.moves.push_back(self.last.is_some_and(|last| last != commanded));
            self.last = Some(commanded);
            if let Some(error) = self.stream.push(tips[k], commanded)? {
                self.note(&error);
            }
        }
        Ok(())
    }

    /// Notes the error of the next sample.
    fn note(&mut self, error: &ContourError) {
        let (sample, moves) = (self.next, self.moves.pop_front().unwrap_or(false));
        self.next += 1;
        self.contour.note(sample, error.magnitude_mm);
        self.worst.note(sample, error);
        self.reversals.iter_mut().for_each(|(_, reversals)| reversals.error(sample, error, &mut self.found.0));
        self.segment.note(sample, moves, error.magnitude_mm, self.period_s, &mut self.found.1);
    }

    fn finish(mut self, lags_s: Vec<Option<f64>>) -> Result<Measurement> {
        let mut rest = Vec::new();
        self.stream.finish(&mut rest);
        rest.iter().for_each(|error| self.note(error));
        let (mut reversals, mut segments) = self.found;
        self.reversals.into_iter().for_each(|(_, sum)| sum.finish(&mut reversals));
        self.segment.close(self.period_s, &mut segments);
        reversals.trim();
        segments.trim();
        let place = |reversal: &Reversal| self.axes.iter().position(|axis| axis.name == reversal.axis);
        reversals.items.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(place(a).cmp(&place(b))));
        segments.items.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        let worst: Vec<WorstPoint> = self.worst.points(self.period_s);
        Ok(Measurement {
            tracking: self.tracking.iter().map(RmsMax::figures).collect(),
            axes: self.axes,
            contour: self.contour.summary().ok_or(Error::NoSamples)?,
            orientation: None,
            matched: Match { delay_s: Some(0.0), offset: Vec3::zeros(), path_positions: Vec::new(), path: Vec::new() },
            lags_s,
            reversals_found: reversals.seen,
            reversals: reversals.items,
            worst,
            segments_found: segments.seen,
            segments: segments.items,
            circle: None,
            errors: Vec::new(),
            weights: Vec::new(),
        })
    }
}
