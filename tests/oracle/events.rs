//! Canonical calls with the state in which they are made: positions in mm of the machine, feed, modes.

use std::f64::consts::TAU;

use crate::rs274::Call;

/// X, Y, Z in mm, A, B, C in degrees.
pub type Point = [f64; 6];

/// Distance of the ends of a full circle, mm: printed digits, also those of inches before a change of units.
const CLOSED_MM: f64 = 0.01;
/// The feed mode at the start, and in inverse time.
const UNITS_PER_MINUTE: &str = "0, 0";
/// Longest chord of an arc that is compared, as a share of its sweep.
const CHORDS: f64 = TAU / 720.0;
/// Largest distance of a chord from its arc, mm.
const SAGITTA_MM: f64 = 5e-4;

/// A canonical call that is no mode of feeds or paths.
#[derive(Debug, Clone)]
pub struct Event {
    pub call: Call,
    pub start: Point,
    /// Points of the path; empty for calls that do not feed.
    pub path: Vec<Point>,
    /// Radius of an arc, 0 for other calls.
    pub radius_mm: f64,
    pub modes: Modes,
    /// Largest length unit of the program so far, mm: positions are rounded in it.
    pub unit_mm: f64,
}

/// Modes that a compensated segment may state for itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Modes {
    pub rate: f64,
    pub feed: String,
    pub path: String,
}

#[derive(Default)]
struct State {
    at: Point,
    unit_mm: f64,
    coarsest_mm: f64,
    /// The feed follows the spindle: its rate has no meaning.
    is_synchronised: bool,
    work: Point,
    shift: Point,
    tool: Point,
    plane: String,
    modes: Modes,
}

pub fn distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Last printed digit of a coordinate, in units of the program.
const PRINTED: f64 = 1e-4;
/// Distance from the target at which a simulated probing move ends, mm.
const PROBE_SHORT_MM: f64 = 0.254;

/// The calls as events. Feeds, feed modes and path modes become state.
pub fn events(calls: &[Call]) -> Vec<Event> {
    let modes = Modes { feed: UNITS_PER_MINUTE.to_owned(), ..Modes::default() };
    let mut state = State { unit_mm: 1.0, modes, ..State::default() };
    // Canned cycles state a path mode and restore it, in the units of another block perhaps.
    let is_mode = |call: &&Call| call.name == "SET_MOTION_CONTROL_MODE";
    let blocks = calls.chunk_by(|a, b| a.line.is_some() && a.line == b.line);
    let stated = blocks.flat_map(|block| {
        let is_cycle = block.iter().filter(is_mode).count() > 1;
        block.iter().filter(move |call| !(is_cycle && is_mode(call)))
    });
    stated.filter_map(|call| state.take(call)).collect()
}

impl State {
    fn take(&mut self, call: &Call) -> Option<Event> {
        let start = self.at;
        let (mut path, mut radius_mm) = (Vec::new(), 0.0);
        match call.name.as_str() {
            "USE_LENGTH_UNITS" => self.unit_mm = if call.text.contains("MM") { 1.0 } else { 25.4 },
            "START_SPEED_FEED_SYNC" => self.is_synchronised = true,
            "STOP_SPEED_FEED_SYNCH" => self.is_synchronised = false,
            "SELECT_PLANE" => self.plane.clone_from(&call.text),
            "SET_G5X_OFFSET" => self.work = self.offset(&call.numbers[1..]),
            "SET_G92_OFFSET" => self.shift = self.offset(&call.numbers),
            "USE_TOOL_LENGTH_OFFSET" => self.tool = self.offset(&call.numbers[..3]),
            "STRAIGHT_TRAVERSE" => self.at = self.place(&call.numbers),
            "STRAIGHT_PROBE" => self.at = self.probed(&call.numbers),
            "STRAIGHT_FEED" => {
                self.at = self.place(&call.numbers);
                path = vec![start, self.at];
            }
            // The call does not say where the spline ends.
            "NURBS_FEED" => self.at = [f64::NAN; 6],
            "ARC_FEED" => (path, radius_mm) = self.arc(&call.numbers),
            "SET_FEED_RATE" => return self.set(|modes| modes.rate = call.numbers[0]),
            "SET_FEED_MODE" => return self.set(|modes| modes.feed.clone_from(&call.text)),
            "SET_MOTION_CONTROL_MODE" => {
                let tolerance_mm = call.numbers.first().map(|tolerance| tolerance * self.unit_mm);
                let mode = call.text.split(',').next().unwrap_or_default();
                return self.set(|modes| modes.path = tolerance_mm.map_or(mode.to_owned(), |mm| format!("{mode}, {mm:.3} mm")));
            }
            "SET_NAIVECAM_TOLERANCE" => return None,
            "COMMENT" if !call.text.contains("interpreter: ") || call.text.contains("feed mode") => return None,
            _ => {}
        }
        // A motion code alone in its block is a move to the present position. Sums of printed numbers are off by one digit.
        if ["STRAIGHT_FEED", "STRAIGHT_TRAVERSE"].contains(&call.name.as_str())
            && distance(&start, &self.at) < 1.5 * PRINTED * self.unit_mm
        {
            return None;
        }
        self.coarsest_mm = self.coarsest_mm.max(self.unit_mm);
        let rate = if self.is_synchronised { 0.0 } else { self.modes.rate * self.unit_mm };
        let modes = Modes { rate, ..self.modes.clone() };
        Some(Event { call: call.clone(), start, path, radius_mm, modes, unit_mm: self.coarsest_mm })
    }

    fn set(&mut self, change: impl FnOnce(&mut Modes)) -> Option<Event> {
        change(&mut self.modes);
        None
    }

    fn offset(&self, numbers: &[f64]) -> Point {
        std::array::from_fn(|axis| numbers.get(axis).copied().unwrap_or(0.0) * if axis < 3 { self.unit_mm } else { 1.0 })
    }

    fn place(&self, numbers: &[f64]) -> Point {
        let own = self.offset(numbers);
        std::array::from_fn(|axis| own[axis] + self.work[axis] + self.shift[axis] + self.tool[axis])
    }

    /// End of a probing move: the stand-alone interpreter takes it as [`PROBE_SHORT_MM`] short of the target.
    fn probed(&self, numbers: &[f64]) -> Point {
        let target = self.place(numbers);
        let share = PROBE_SHORT_MM / distance(&self.at, &target).max(PROBE_SHORT_MM);
        std::array::from_fn(|axis| target[axis] + (self.at[axis] - target[axis]) * share)
    }

    /// `ARC_FEED(first end, second end, first centre, second centre, rotation, end along the normal, A, B, C)`.
    fn arc(&mut self, numbers: &[f64]) -> (Vec<Point>, f64) {
        let [first, second, normal] = match self.plane.as_str() {
            "CANON_PLANE_XZ" => [2, 0, 1],
            "CANON_PLANE_YZ" => [1, 2, 0],
            _ => [0, 1, 2],
        };
        let (mut end, mut centre) = ([0.0; 6], [0.0; 6]);
        [end[first], end[second], end[normal]] = [numbers[0], numbers[1], numbers[5]];
        end[3..].copy_from_slice(&numbers[6..9]);
        [centre[first], centre[second]] = [numbers[2], numbers[3]];
        let (start, end, centre) = (self.at, self.place(&end), self.place(&centre));
        let angle = |of: &Point| (of[second] - centre[second]).atan2(of[first] - centre[first]);
        let radius = |of: &Point| (of[second] - centre[second]).hypot(of[first] - centre[first]);
        let turns = numbers[4];
        let direction = turns.signum();
        let turned = (direction * (angle(&end) - angle(&start))).rem_euclid(TAU);
        // A full circle ends where it starts, up to the printed digits.
        let apart = (end[first] - start[first]).hypot(end[second] - start[second]);
        let turned = if apart < CLOSED_MM { TAU } else { turned };
        let sweep = direction * (turned + TAU * (turns.abs() - 1.0));
        let step = CHORDS.min((8.0 * SAGITTA_MM / radius(&start).max(radius(&end))).sqrt());
        let count = (sweep.abs() / step).ceil().max(2.0) as usize;
        self.at = end;
        let point = |i: usize| {
            let share = i as f64 / count as f64;
            let (angle, radius) = (angle(&start) + sweep * share, radius(&start) + (radius(&end) - radius(&start)) * share);
            let mut point: Point = std::array::from_fn(|axis| start[axis] + (end[axis] - start[axis]) * share);
            point[first] = centre[first] + radius * angle.cos();
            point[second] = centre[second] + radius * angle.sin();
            point
        };
        ((0..=count).map(point).collect(), radius(&start))
    }
}
