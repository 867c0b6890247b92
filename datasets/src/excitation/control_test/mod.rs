//! Control test: moves that show how a control plans.
//!
//! Random motion with its own times identifies the axes. It does not show how the control itself
//! accelerates, shapes its acceleration and passes corners. The control test leaves all of this to
//! the control: single moves, corners, arcs, short lines and rapids, each figure from standstill to
//! standstill at its start.

mod block;
mod bounds;
mod figures;

use motion::{Axis, Limits};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use block::{Block, Coordinates, Group};
use bounds::Bounds;
use figures::Figure;

/// Feeds, as shares of the highest feed that the axes of a figure reach in every direction.
const FEEDS: [f64; 3] = [0.9, 0.45, 0.2];
/// Lengths of single moves that are too short for the feed, as shares of the distance that reaches it.
const SHORT: [f64; 3] = [0.1, 0.3, 0.7];
/// Time at the feed of single moves that reach it, s.
const PLATEAU_S: f64 = 0.1;
/// Length of the lines between corners, as a multiple of the distance that reaches the feed: enough for a
/// control that accelerates less than the machine file states.
const CORNER_LENGTHS: f64 = 1.4;
/// Times at the speed of rapids, s. The longer one leaves room for rapids that are faster than the
/// machine file states; it is at the full speed, whatever the share: no other move shows how fast an axis is.
const RAPID_PLATEAUS_S: [f64; 2] = [0.1, 0.25];
/// Radii of full circles and of arcs from standstill, as shares of the radius at which the feed
/// meets the centripetal limit.
const CIRCLES: [f64; 3] = [0.2, 0.8, 1.8];
const ARCS: [f64; 2] = [0.5, 1.4];
/// Arcs between tangent lines: feed, radius in the same distance, and whether an opposite arc follows.
const TANGENT_ARCS: [(f64, f64, bool); 5] =
    [(0.9, 0.5, false), (0.9, 1.0, true), (0.9, 1.4, false), (0.45, 0.5, false), (0.45, 1.4, true)];
/// Lengths of the short lines of an arc and of an S-shape, mm: those of CAM systems.
const ARC_LINES_MM: [f64; 3] = [0.1, 0.25, 0.5];
const S_LINES_MM: [f64; 2] = [0.15, 0.4];
/// Length, mm, and change of direction, degrees, of the lines of a zigzag; number of lines.
const ZIGZAGS: [(f64, f64); 3] = [(0.3, 20.0), (0.6, 45.0), (1.5, 90.0)];
const ZIGZAG_LINES: usize = 8;
/// Radius of an arc of short lines, as a share of the radius at which the feed meets the
/// centripetal limit, and the largest one, mm: short lines, not the curvature, are to limit the speed.
const WIDE: f64 = 3.0;
const WIDEST_MM: f64 = 12.0;
/// Ratio of two figures' sizes, when one is reduced to keep within the travel.
const REDUCTION: f64 = 0.85;
/// Reductions after which a figure is as good as a point.
const REDUCTIONS: usize = 40;
/// Smallest angle between two lines and its multiples up to 165°, degrees; the second one with less content.
const CORNER_STEPS_DEG: [f64; 2] = [15.0, 30.0];

/// Titles of the groups of corners and of rapids.
const CORNERS: &str = "corners";
const RAPIDS: &str = "rapids";

/// Settings of a control test.
#[derive(Clone, Copy)]
pub struct ControlTest<'a> {
    /// Axes of the machine, in the order of the limits. Those outside of x, y, z, a, b, c do not move.
    pub axes: &'a [Axis],
    /// Limits of axes and path.
    pub limits: &'a Limits,
    /// Start and end of every figure.
    pub home: Coordinates,
    /// Share of the path's and axes' speed limits, 0 to 1. Sizes follow from it: a lower share gives
    /// a shorter test.
    pub speed_share: f64,
    /// Whether about half of the figures and corners are left out, for machines whose axes take long to accelerate.
    pub is_short: bool,
    /// Whether a position is within the travel.
    pub is_within: &'a dyn Fn(&Coordinates) -> bool,
}

impl ControlTest<'_> {
    /// Standstill between figures, s: longer than the filters of most controls.
    pub const DWELL_S: f64 = 0.1;

    /// The groups of figures, in a fixed order; `seed` draws the order within a group, directions
    /// and angles. Empty where the machine has none of the axes x, y, z, a, b, c.
    #[must_use]
    pub fn groups(&self, seed: u64) -> Vec<Group> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let bounds = Bounds::of(self.axes, self.limits, self.speed_share);
        let groups = [
            ("single axes", self.single_axes(&bounds, &mut rng)),
            ("diagonals", self.diagonals(&bounds, &mut rng)),
            (CORNERS, self.corners(&bounds, &mut rng)),
            ("circles and arcs", self.arcs(&bounds, &mut rng)),
            ("lines and arcs with common tangents", self.tangent_arcs(&bounds, &mut rng)),
            ("short lines", self.short_lines(&bounds, &mut rng)),
            (RAPIDS, self.rapids(&bounds, &mut rng)),
            ("rotary axes", self.rotary_axes(&bounds, &mut rng)),
        ];
        let joined = |(title, figures): (&'static str, Vec<Vec<Block>>)| {
            // Every polyline of corners has another feed or plane: it has fewer corners instead. A short test has one rapid of every axis.
            let is_kept = |k: &usize| !self.is_short || [CORNERS, RAPIDS].contains(&title) || k % 2 == 1;
            let mut figures: Vec<Vec<Block>> = (0..figures.len()).filter(is_kept).map(|k| figures[k].clone()).collect();
            figures.shuffle(&mut rng);
            Group { title, blocks: figures.concat() }
        };
        groups.into_iter().map(joined).filter(|group| !group.blocks.is_empty()).collect()
    }

    fn single_axes(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let directions = bounds.linear().into_iter().map(|slot| direction(&[(slot, 1.0)]));
        directions.flat_map(|along| self.moves(&along, bounds, rng)).collect()
    }

    /// Equal shares of two and three axes; of two also unequal ones.
    fn diagonals(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let slots = bounds.linear();
        let mut directions: Vec<Coordinates> =
            pairs(&slots).into_iter().map(|[a, b]| direction(&[(a, 1.0), (b, sign(rng))])).collect();
        directions.extend(pairs(&slots).first().map(|[a, b]| direction(&[(*a, 2.0), (*b, sign(rng))])));
        if let [x, y, z] = slots[..] {
            directions.push(direction(&[(x, 1.0), (y, sign(rng)), (z, sign(rng))]));
        }
        let length = |along: &Coordinates| {
            let [distance, feed] = bounds.along(along).distance_to_reach(FEEDS[0]);
            distance + PLATEAU_S * feed
        };
        directions.iter().flat_map(|along| self.there_and_back(along, &[length(along)], Some(FEEDS[0]), bounds, rng)).collect()
    }

    /// Corners of all angles between lines that reach the feed: at every feed in one plane, at one feed in another plane.
    /// Directions turn to either side in random order.
    fn corners(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let planes = pairs(&bounds.linear());
        let Some(first) = planes.first() else { return Vec::new() };
        let others = &planes[1..];
        let [step_deg, wider_deg] = CORNER_STEPS_DEG;
        let step_deg = if self.is_short { wider_deg } else { step_deg };
        let mut tests: Vec<([usize; 2], f64, f64)> = FEEDS.iter().map(|share| (*first, *share, step_deg)).collect();
        if !others.is_empty() {
            tests.push((others[rng.random_range(0..others.len())], FEEDS[1], wider_deg));
        }
        let mut out = Vec::new();
        for (plane, share, step_deg) in tests {
            let [distance, feed] = bounds.within(&plane).distance_to_reach(share);
            let headings = figures::headings(step_deg, rng);
            let length = CORNER_LENGTHS * distance;
            out.push(self.fitted(|scale| Figure::polyline(self.home, plane, feed, &headings, scale * length)));
        }
        out
    }

    /// Full circles and arcs from standstill to standstill.
    fn arcs(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let Some(limits) = bounds.in_xy() else { return Vec::new() };
        let mut out = Vec::new();
        for share in FEEDS {
            let (feed, radius) = limits.radius_at(share);
            let circles = CIRCLES.map(|size| (size, 360.0));
            let arcs = if share > FEEDS[2] { &ARCS[..] } else { &[] };
            let arcs: Vec<(f64, f64)> = arcs.iter().map(|size| (*size, rng.random_range(60.0..300.0))).collect();
            for (size, sweep) in circles.into_iter().chain(arcs) {
                let (heading, clockwise) = (figures::heading(rng), rng.random_bool(0.5));
                let drawn = |scale: f64| Figure::at(self.home, feed).arc(heading, scale * size * radius, sweep, clockwise);
                out.push(self.fitted(|scale| drawn(scale).closed()));
            }
        }
        out
    }

    /// Line, arc, line; and line, arc, opposite arc, line. All join without a corner.
    fn tangent_arcs(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let Some(limits) = bounds.in_xy() else { return Vec::new() };
        let mut draw = |(share, size, is_s): (f64, f64, bool)| {
            let ((feed, radius), [length, _]) = (limits.radius_at(share), limits.distance_to_reach(share));
            let (heading, sweep, clockwise) = (figures::heading(rng), rng.random_range(60.0..120.0), rng.random_bool(0.5));
            self.fitted(|scale| {
                let radius = scale * size * radius;
                let arc = Figure::at(self.home, feed).line(heading, scale * length).arc_on(radius, sweep, clockwise);
                let arcs = if is_s { arc.arc_on(radius, sweep, !clockwise) } else { arc };
                arcs.line_on(scale * length).closed()
            })
        };
        TANGENT_ARCS.map(&mut draw).to_vec()
    }

    /// Arcs, S-shapes and zigzags as CAM systems write them.
    fn short_lines(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let Some(limits) = bounds.in_xy() else { return Vec::new() };
        let (feed, radius) = limits.radius_at(FEEDS[1]);
        let radius = (WIDE * radius).min(WIDEST_MM);
        let mut out = Vec::new();
        for length_mm in ARC_LINES_MM {
            let (heading, sweep) = (figures::heading(rng), 150.0 * sign(rng));
            let arc = |scale: f64| Figure::at(self.home, feed).cut_arc(heading, scale * radius, sweep, length_mm);
            out.push(self.fitted(|scale| arc(scale).closed()));
        }
        for length_mm in S_LINES_MM {
            let (heading, sweep) = (figures::heading(rng), 90.0 * sign(rng));
            let half = |scale: f64| Figure::at(self.home, feed).cut_arc(heading, scale * radius, sweep, length_mm);
            out.push(self.fitted(|scale| half(scale).cut_arc_on(scale * radius, -sweep, length_mm).closed()));
        }
        for (length_mm, angle_deg) in ZIGZAGS {
            let (heading, half) = (figures::heading(rng), 0.5 * angle_deg.to_radians());
            let headings: Vec<f64> =
                (0..ZIGZAG_LINES).map(|k| if k % 2 == 0 { heading + half } else { heading - half }).collect();
            out.push(self.fitted(|scale| Figure::polyline(self.home, [0, 1], feed, &headings, scale * length_mm)));
        }
        out
    }

    /// Rapids of one axis and of two axes with equal and unequal distances.
    fn rapids(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let slots = bounds.linear();
        let whole = Bounds::of(self.axes, self.limits, 1.0);
        let at_speed = |along: &Coordinates, time_s: f64, bounds: &Bounds| {
            let [distance, speed] = bounds.along(along).distance_to_reach(1.0);
            distance + time_s * speed
        };
        let mut out = Vec::new();
        for slot in &slots {
            let along = direction(&[(*slot, 1.0)]);
            let short = SHORT[1] * bounds.along(&along).distance_to_reach(1.0)[0];
            let [less, more] = RAPID_PLATEAUS_S;
            let lengths = [short, at_speed(&along, less, bounds), at_speed(&along, more, &whole)];
            let lengths = if self.is_short { &lengths[2..] } else { &lengths };
            out.extend(self.there_and_back(&along, lengths, None, bounds, rng));
        }
        let pairs = if self.is_short { Vec::new() } else { pairs(&slots) };
        // Unequal distances tell a straight path from axes that move each at its own speed.
        for ([a, b], ratio) in pairs.iter().map(|pair| (pair, 0.4)).chain(pairs.first().map(|pair| (pair, 1.0))) {
            let along = direction(&[(*a, 1.0), (*b, ratio * sign(rng))]);
            out.extend(self.there_and_back(&along, &[at_speed(&along, RAPID_PLATEAUS_S[0], bounds)], None, bounds, rng));
        }
        out
    }

    /// Every rotary axis alone, at a feed and at the speed of rapids.
    fn rotary_axes(&self, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let mut out = Vec::new();
        for slot in bounds.rotary() {
            let along = direction(&[(slot, 1.0)]);
            let [distance, speed] = bounds.along(&along).distance_to_reach(1.0);
            out.extend(self.moves(&along, bounds, rng));
            out.extend(self.there_and_back(&along, &[SHORT[1] * distance, distance + PLATEAU_S * speed], None, bounds, rng));
        }
        out
    }

    /// Moves along a direction, some too short to reach the feed.
    fn moves(&self, along: &Coordinates, bounds: &Bounds, rng: &mut ChaCha8Rng) -> Vec<Vec<Block>> {
        let [distance, feed] = bounds.along(along).distance_to_reach(FEEDS[0]);
        let lengths: Vec<f64> = SHORT.iter().map(|share| share * distance).chain([distance + PLATEAU_S * feed]).collect();
        self.there_and_back(along, &lengths, Some(FEEDS[0]), bounds, rng)
    }

    /// One figure for each of `lengths` along a direction; a rapid where `share` is `None`.
    fn there_and_back(
        &self,
        along: &Coordinates,
        lengths: &[f64],
        share: Option<f64>,
        bounds: &Bounds,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Vec<Block>> {
        let feed = share.map(|share| share * bounds.along(along).velocity);
        let block = |to: Coordinates| feed.map_or(Block::Rapid { to }, |feed| Block::Line { to, feed });
        lengths
            .iter()
            .map(|length| {
                let signed = sign(rng) * length;
                self.fitted(|scale| {
                    let end = std::array::from_fn(|slot| self.home[slot] + scale * signed * along[slot]);
                    vec![block(end), Block::Dwell, block(self.home)]
                })
            })
            .collect()
    }

    /// A figure, at most as large as `draw` makes it with the scale 1, within the travel; a dwell after it.
    fn fitted(&self, draw: impl Fn(f64) -> Vec<Block>) -> Vec<Block> {
        let scales = (0..REDUCTIONS).map(|k| REDUCTION.powi(k as i32));
        let mut drawn = scales.map(&draw);
        let mut blocks = drawn.find(|blocks| figures::is_within(self.home, blocks, self.is_within)).unwrap_or_default();
        if !blocks.is_empty() {
            blocks.push(Block::Dwell);
        }
        blocks
    }
}

/// All pairs of axes.
fn pairs(slots: &[usize]) -> Vec<[usize; 2]> {
    let later = |k: usize| slots[k + 1..].iter().map(move |b| (k, *b));
    (0..slots.len()).flat_map(later).map(|(k, b)| [slots[k], b]).collect()
}

/// Unit vector of these components.
fn direction(parts: &[(usize, f64)]) -> Coordinates {
    let length = parts.iter().map(|(_, part)| part * part).sum::<f64>().sqrt();
    let mut out = [0.0; 6];
    parts.iter().for_each(|(slot, part)| out[*slot] = part / length);
    out
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}
