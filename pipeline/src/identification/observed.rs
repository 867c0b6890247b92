//! A recorded run over the path of its program.

use std::sync::Arc;

use datasets::Log;
use machine::MachineSpec;
use motion::contour::{Exact, follow};
use motion::{Kinematics, Piece, ToolPath, Trajectory, Vec3};

use crate::error::{Error, Result};
use crate::input::Input;
use crate::measure::{readback, without_approach};
use crate::part::{Part, ReadSettings};
use crate::setup::Setup;

/// Speed along the path below which a command stands, mm/s. The time at rest does not count: dwells and acknowledgements are not planned.
const STANDS_MM_S: f64 = 0.1;
/// Time in motion at the beginning that does not count, s: the corner between the approach and the path is not planned.
const FIRST_S: f64 = 0.03;
/// Time in motion from cell to cell, s.
pub(super) const CELL_S: f64 = 0.01;

/// Least time at rest that parts a run in two, s: what comes after it is no matter of what was before.
const REST_S: f64 = 0.02;
/// Time over which the speed of a rapid is taken, s.
const RAPID_SPAN_S: f64 = 0.01;
/// Places that are nearer are the same, mm.
const SAME_PLACE_MM: f64 = 1e-9;
/// Time before and after a corner in which the command is nearest to it, and in which it is slowest, s.
const NEAR_S: f64 = 0.1;
const SLOW_S: f64 = 0.03;
/// Smallest angle between pieces that counts as a corner, rad.
const CORNER_RAD: f64 = 0.17;

/// A program and the log of its run.
#[derive(Debug)]
pub struct KnownRun<'a> {
    /// Name of the program, for messages.
    pub name: String,
    /// The program.
    pub program: Vec<u8>,
    /// The log of its run.
    pub log: &'a Log,
}

/// A recorded run.
pub(super) struct Observed {
    pub name: String,
    path: ToolPath,
    kinematics: Arc<dyn Kinematics>,
    settings: ReadSettings,
    period_s: f64,
    /// The path by which the log was read, and the arc length at each of its points, mm: the common measure of places, of records and of
    /// plans.
    tips: Vec<Vec3>,
    tip_places_mm: Vec<f64>,
    /// Place, time in motion and command at the cells.
    cells: Vec<Cell>,
    /// How the command passes every corner.
    corners: Vec<Passage>,
    /// Speeds of the axes in rapids, one span after another; `None` between rapids.
    rapids: Vec<Option<Vec<f64>>>,
    /// Pieces that end in a dwell before which the command comes to rest, and the places of their ends, mm.
    rests: Vec<(usize, f64)>,
}

/// The command at a place of the path.
#[derive(Clone)]
struct Cell {
    place_mm: f64,
    /// Time in motion up to here, s.
    clock_s: f64,
    /// Positions in the frame of the program, mm or rad.
    position: Vec<f64>,
}

/// How a command passes a corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage {
    /// Least distance from the corner, mm.
    pub rounded_mm: f64,
    /// Least speed along the path, mm/s.
    pub speed_mm_s: f64,
    /// Angle between the directions before and after it, rad.
    pub turn_rad: f64,
    /// The largest change of an axis's share of the speed.
    pub change: f64,
}

/// Differences between a plan and the recorded run.
pub(super) struct Difference {
    /// Planned minus recorded time from cell to cell, s.
    pub late_s: Vec<f64>,
    /// Time in motion, s.
    pub planned_s: f64,
    /// The same of the record, s.
    pub recorded_s: f64,
    /// Planned minus recorded positions at the cells, one after another, mm.
    pub off_mm: Vec<f64>,
    /// Number of axes.
    pub axes: usize,
}

impl Difference {
    /// Distances at the cells, mm.
    pub fn distances_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.off_mm.chunks(self.axes.max(1)).map(|off| off.iter().map(|off| off * off).sum::<f64>().sqrt())
    }
}

impl Observed {
    /// Reads a run along its program.
    ///
    /// # Errors
    /// When the program cannot be read, or the log is of another one.
    pub fn new(run: &KnownRun<'_>, setup: &Setup, settings: &ReadSettings) -> Result<Self> {
        let part = Part::read(&run.name, run.program.clone(), setup, settings)?;
        let input = Input::from(part);
        let (log, _) = run.log.with_axes(input.trajectory().axes())?.resampled(input.trajectory().period_s())?;
        let (log, _) = without_approach(&log, input.desired())?;
        let (_, matched) = readback(&log, &input, &mut Exact::default()).map_err(|source| Error::OtherRun {
            log: log.name.clone(),
            program: run.name.clone(),
            source: Box::new(source),
        })?;
        let Input::Program(part) = input else { return Err(Error::NoProgram) };
        let offsets = matched.offsets(log.reference.axes());
        let tip_places_mm: Vec<f64> = part.plan.samples.iter().map(|sample| sample.position_mm).collect();
        let places: Vec<f64> = matched.path_positions.iter().map(|at| place(&tip_places_mm, *at)).collect();
        let moved = log.reference.columns().iter().zip(&offsets);
        let moved = moved.map(|(column, offset)| column.iter().map(|at| at - offset).collect()).collect();
        let command = log.reference.with_columns(moved)?;
        let commanded = part.plan.desired.tips_of(&command)?;
        Ok(Self {
            corners: corners(&part).map(|corner| passage(&part, corner, &places, &commanded, setup.period_s)).collect(),
            rapids: rapids(&part, &matched.path_positions, &command),
            rests: rests(&part, &places, &commanded, setup.period_s),
            name: run.name.clone(),
            period_s: setup.period_s,
            cells: cells(&places, setup.period_s, |k| command.at(k).collect()),
            tips: part.plan.desired.tips(),
            tip_places_mm,
            kinematics: Arc::clone(&setup.kinematics),
            settings: settings.clone(),
            path: part.path,
        })
    }

    /// Its parts from rest to rest, each as a run.
    pub fn parts(&self) -> Vec<Self> {
        let ends = self.rests.iter().copied().chain([(self.path.pieces().len().saturating_sub(1), f64::INFINITY)]);
        let mut from = (0, f64::NEG_INFINITY);
        let part = |(piece, place_mm): (usize, f64)| {
            let (first, from_mm) = std::mem::replace(&mut from, (piece + 1, place_mm));
            let within = self.cells.iter().filter(|cell| (from_mm..place_mm).contains(&cell.place_mm));
            // The last of the points at the start, the first of those at the end.
            let last = (self.tip_places_mm.partition_point(|at| *at < place_mm - SAME_PLACE_MM) + 1).min(self.tips.len());
            let first_tip = self.tip_places_mm.partition_point(|at| *at <= from_mm + SAME_PLACE_MM).saturating_sub(1);
            let points = first_tip.min(last)..last;
            Self {
                name: self.name.clone(),
                path: self.path.pieces().get(first..=piece).unwrap_or_default().to_vec().into(),
                kinematics: Arc::clone(&self.kinematics),
                settings: self.settings.clone(),
                period_s: self.period_s,
                tips: self.tips[points.clone()].to_vec(),
                tip_places_mm: self.tip_places_mm[points].to_vec(),
                cells: within.cloned().collect(),
                corners: Vec::new(),
                rapids: Vec::new(),
                rests: Vec::new(),
            }
        };
        ends.map(part).filter(|part| part.cells.len() > 1).collect()
    }

    /// How the command passes every corner of the program.
    pub fn corners(&self) -> &[Passage] {
        &self.corners
    }

    /// Speeds of the axes in rapids, mm/s or rad/s, over spans of 10 ms one after another; `None` between rapids.
    pub fn rapids(&self) -> &[Option<Vec<f64>>] {
        &self.rapids
    }

    /// Time in motion, s.
    pub fn seconds(&self) -> f64 {
        self.cells.first().zip(self.cells.last()).map_or(0.0, |(first, last)| last.clock_s - first.clock_s)
    }

    /// Differences of the plan of `machine` from the run; `None` where it cannot be planned.
    pub fn difference(&self, machine: &MachineSpec) -> Option<Difference> {
        let setup = Setup { period_s: self.period_s, ..Setup::new(machine, None).ok()? };
        let settings = setup.program_plan(self.settings.corner_tolerance_mm);
        let plan = motion::plan(&self.path, &self.kinematics, &setup.limits, &settings).ok()?;
        let command = plan.command.as_ref().unwrap_or(plan.desired.trajectory());
        let clock = Clock::of(self.places_mm(&plan.desired.tips_of(command).ok()?)?, self.period_s);
        let axes = command.columns().len();
        let [late_s, off_mm] = [1, axes].map(|of_cell| Vec::with_capacity(of_cell * self.cells.len()));
        let mut found = Difference { late_s, planned_s: 0.0, recorded_s: 0.0, off_mm, axes };
        let mut last: Option<(f64, f64)> = None;
        let mut after = 0;
        for cell in &self.cells {
            let (time_s, sample) = clock.at(cell.place_mm, &mut after);
            found.off_mm.extend(differences(command, sample, &cell.position));
            if let Some((planned_s, recorded_s)) = last {
                let (planned_s, recorded_s) = (time_s - planned_s, cell.clock_s - recorded_s);
                found.late_s.push(planned_s - recorded_s);
                found.planned_s += planned_s;
                found.recorded_s += recorded_s;
            }
            last = Some((time_s, cell.clock_s));
        }
        Some(found)
    }

    /// Places on the path of the tips of a command, mm; `None` where it leaves the path.
    fn places_mm(&self, command: &[Vec3]) -> Option<Vec<f64>> {
        Some(follow(command, &self.tips).ok()?.into_iter().map(|at| place(&self.tip_places_mm, at)).collect())
    }
}

/// Pieces of the program that end in a corner without a stop, with the directions before and after it.
fn corners(part: &Part) -> impl Iterator<Item = (usize, [Vec3; 2])> + '_ {
    let directions = |pair: &[Piece]| {
        [(&pair[0], pair[0].range.1), (&pair[1], pair[1].range.0)].map(|(piece, at)| piece.curve.derivatives(at)[1].normalize())
    };
    let all = part.path.pieces().windows(2).map(directions).enumerate();
    let stops = |piece: &Piece| piece.stop_after || piece.dwell_s > 0.0;
    all.filter(move |(k, [leaving, entering])| leaving.angle(entering) > CORNER_RAD && !stops(&part.path.pieces()[*k]))
}

/// How a command passes the corner at the end of a piece.
fn passage(
    part: &Part,
    (piece, [leaving, entering]): (usize, [Vec3; 2]),
    places: &[f64],
    commanded: &[Vec3],
    period_s: f64,
) -> Passage {
    let end = &part.path.pieces()[piece];
    let corner = end.curve.point(end.range.1);
    let at = places.partition_point(|place| *place < part.plan.piece_ends_mm[piece]);
    let around = |time_s: f64| {
        let near = ((time_s / period_s) as usize).max(1);
        &commanded[at.saturating_sub(near).min(commanded.len())..(at + near).min(commanded.len())]
    };
    let way_mm = around(SLOW_S).windows(2).map(|pair| (pair[1] - pair[0]).norm());
    Passage {
        rounded_mm: around(NEAR_S).iter().map(|tip| (tip - corner).norm()).fold(f64::INFINITY, f64::min),
        speed_mm_s: way_mm.fold(f64::INFINITY, f64::min) / period_s,
        turn_rad: leaving.angle(&entering),
        change: (entering - leaving).amax(),
    }
}

/// Pieces that end in a dwell before which a command comes to rest, and the places of their ends, mm.
fn rests(part: &Part, places: &[f64], commanded: &[Vec3], period_s: f64) -> Vec<(usize, f64)> {
    let ends = part.path.pieces().iter().zip(&part.plan.piece_ends_mm).enumerate();
    let dwells = ends.filter(|(_, (piece, _))| piece.dwell_s > 0.0).map(|(piece, (_, end_mm))| (piece, *end_mm));
    let stands = |(_, end_mm): &(usize, f64)| {
        let arrived = places.partition_point(|place| *place < end_mm - STANDS_MM_S * period_s);
        let after = &commanded[arrived.min(commanded.len())..];
        let waits = after.iter().take_while(|tip| (*tip - after[0]).norm() < STANDS_MM_S * period_s).count();
        waits as f64 * period_s >= REST_S
    };
    let last = part.path.pieces().len().saturating_sub(1);
    dwells.filter(|(piece, _)| *piece < last).filter(stands).collect()
}

/// Speeds of the axes in rapids, span after span.
fn rapids(part: &Part, path_positions: &[f64], command: &Trajectory) -> Vec<Option<Vec<f64>>> {
    let span = (RAPID_SPAN_S / command.period_s()).round().max(1.0) as usize;
    let piece = |at: f64| part.plan.samples.get(at.round() as usize).and_then(|sample| part.path.pieces().get(sample.piece));
    let is_rapid = |at: f64| piece(at).is_some_and(|piece| piece.feed_mm_s.is_infinite());
    let speed = |from: usize| {
        let rapid = is_rapid(path_positions[from]) && is_rapid(path_positions[from + span]);
        let over = |column: &Vec<f64>| (column[from + span] - column[from]).abs() / (span as f64 * command.period_s());
        rapid.then(|| command.columns().iter().map(over).collect())
    };
    (0..path_positions.len().saturating_sub(span)).step_by(span).map(speed).collect()
}

/// Arc length at a sample index with fraction, mm.
fn place(places_mm: &[f64], at: f64) -> f64 {
    let last = places_mm.len().saturating_sub(1);
    let before = (at as usize).min(last);
    let (from, to) = (places_mm[before], places_mm[(before + 1).min(last)]);
    from + (to - from) * (at - before as f64)
}

/// The samples that move on, a cell apart.
fn cells(places: &[f64], period_s: f64, at: impl Fn(usize) -> Vec<f64>) -> Vec<Cell> {
    let least_mm = STANDS_MM_S * period_s;
    let apart = (CELL_S / period_s).round().max(1.0) as usize;
    let mut cells: Vec<Cell> = Vec::new();
    let (mut moving, mut furthest) = (0_usize, f64::NEG_INFINITY);
    for (k, place_mm) in places.iter().enumerate() {
        if *place_mm < furthest + least_mm {
            continue;
        }
        furthest = *place_mm;
        if moving % apart == 0 && moving as f64 * period_s >= FIRST_S {
            cells.push(Cell { place_mm: *place_mm, clock_s: moving as f64 * period_s, position: at(k) });
        }
        moving += 1;
    }
    cells
}

/// The time in motion of a plan over the common measure of places.
struct Clock {
    places_mm: Vec<f64>,
    /// Index of the sample at every place.
    samples: Vec<usize>,
    period_s: f64,
}

impl Clock {
    fn of(of_samples: Vec<f64>, period_s: f64) -> Self {
        let least_mm = STANDS_MM_S * period_s;
        let (mut places_mm, mut samples): (Vec<f64>, Vec<usize>) = (Vec::new(), Vec::new());
        for (k, place_mm) in of_samples.into_iter().enumerate() {
            if places_mm.last().is_none_or(|last| place_mm >= last + least_mm) {
                places_mm.push(place_mm);
                samples.push(k);
            }
        }
        Self { places_mm, samples, period_s }
    }

    /// Time in motion and sample index with fraction at a place; `after` is where the last search ended.
    fn at(&self, place_mm: f64, after: &mut usize) -> (f64, f64) {
        while *after + 1 < self.places_mm.len() && self.places_mm[*after] < place_mm {
            *after += 1;
        }
        let Some(before) = after.checked_sub(1) else { return (0.0, self.samples.first().map_or(0.0, |k| *k as f64)) };
        let [from, to] = [self.places_mm[before], self.places_mm[*after]];
        let share = if to > from { ((place_mm - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        let [first, second] = [self.samples[before] as f64, self.samples[*after] as f64];
        // Over a rest the place belongs to its end.
        let sample = if second - first > 1.5 { second } else { first + share * (second - first) };
        ((before as f64 + share) * self.period_s, sample)
    }
}

/// Positions of a command at a sample index with fraction, minus others, mm.
fn differences<'a>(command: &'a Trajectory, sample: f64, position: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let before = (sample as usize).min(command.len() - 1);
    let after = (before + 1).min(command.len() - 1);
    let share = sample - before as f64;
    command.columns().iter().zip(position).map(move |(column, at)| column[before] + (column[after] - column[before]) * share - at)
}
