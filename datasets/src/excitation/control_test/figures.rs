//! Figures of the control test: polylines, arcs, and arcs cut into short lines.

use std::f64::consts::{FRAC_PI_2, TAU};

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::block::{Block, Coordinates};

/// Smallest and largest angle between the directions of two lines, degrees.
const CORNERS_DEG: [f64; 2] = [15.0, 165.0];
/// Draws of a polyline of corners, of which the most compact one is taken.
const DRAWS: usize = 64;
/// Points of a block at which its position is checked.
const CHECKED: usize = 16;

/// Consecutive blocks from a start, in one plane.
pub(super) struct Figure {
    blocks: Vec<Block>,
    start: Coordinates,
    at: Coordinates,
    plane: [usize; 2],
    /// Direction of travel, rad from the first axis of the plane.
    heading: f64,
    feed: f64,
}

impl Figure {
    /// In the x-y plane.
    pub fn at(start: Coordinates, feed: f64) -> Self {
        Self { blocks: Vec::new(), start, at: start, plane: [0, 1], heading: 0.0, feed }
    }

    /// Lines of equal length, and the return.
    pub fn polyline(start: Coordinates, plane: [usize; 2], feed: f64, headings: &[f64], length: f64) -> Vec<Block> {
        let begun = Self { plane, ..Self::at(start, feed) };
        headings.iter().fold(begun, |figure, heading| figure.line(*heading, length)).closed()
    }

    pub fn line(mut self, heading: f64, length: f64) -> Self {
        self.heading = heading;
        self.line_on(length)
    }

    /// A line in the present direction.
    pub fn line_on(mut self, length: f64) -> Self {
        self.step([length * self.heading.cos(), length * self.heading.sin()]);
        self.blocks.push(Block::Line { to: self.at, feed: self.feed });
        self
    }

    pub fn arc(mut self, heading: f64, radius: f64, sweep_deg: f64, clockwise: bool) -> Self {
        self.heading = heading;
        self.arc_on(radius, sweep_deg, clockwise)
    }

    /// An arc that begins in the present direction.
    pub fn arc_on(mut self, radius: f64, sweep_deg: f64, clockwise: bool) -> Self {
        let turn = if clockwise { -1.0 } else { 1.0 };
        let towards = self.heading + turn * FRAC_PI_2;
        let centre_mm = [radius * towards.cos(), radius * towards.sin()];
        if sweep_deg < 360.0 {
            self.heading += turn * sweep_deg.to_radians();
            let from_centre = self.heading - turn * FRAC_PI_2;
            self.step([centre_mm[0] + radius * from_centre.cos(), centre_mm[1] + radius * from_centre.sin()]);
        }
        self.blocks.push(Block::Arc { to: self.at, centre_mm, clockwise, feed: self.feed });
        self
    }

    /// An arc as chords of about `length_mm`; a negative sweep is clockwise.
    pub fn cut_arc(mut self, heading: f64, radius: f64, sweep_deg: f64, length_mm: f64) -> Self {
        self.heading = heading;
        self.cut_arc_on(radius, sweep_deg, length_mm)
    }

    /// The same, beginning in the present direction.
    pub fn cut_arc_on(self, radius: f64, sweep_deg: f64, length_mm: f64) -> Self {
        let sweep = sweep_deg.to_radians();
        let count = (radius * sweep.abs() / length_mm).round().max(2.0);
        let step = sweep / count;
        let chord = 2.0 * radius * (0.5 * step.abs()).sin();
        // A chord lies half a step off the tangents at its ends.
        (0..count as usize).fold(self, |figure, _| {
            let heading = figure.heading;
            Self { heading: heading + step, ..figure.line(heading + 0.5 * step, chord) }
        })
    }

    /// The blocks with a dwell and a rapid back to the start, unless they end there.
    pub fn closed(mut self) -> Vec<Block> {
        if self.at != self.start {
            self.blocks.extend([Block::Dwell, Block::Rapid { to: self.start }]);
        }
        self.blocks
    }

    fn step(&mut self, by: [f64; 2]) {
        self.at[self.plane[0]] += by[0];
        self.at[self.plane[1]] += by[1];
    }
}

pub(super) fn heading(rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(0.0..TAU)
}

/// Directions of lines with corners of all angles between them, `step_deg` apart, in random order to either side: the draw
/// that stays closest to its start.
pub(super) fn headings(step_deg: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let [least, most] = CORNERS_DEG;
    let corners = ((most - least) / step_deg) as usize + 1;
    let mut draw = || {
        let mut angles: Vec<f64> = (0..corners).map(|k| least + k as f64 * step_deg).collect();
        angles.shuffle(rng);
        let mut out = vec![heading(rng)];
        for angle in angles {
            let turn = if rng.random_bool(0.5) { angle } else { -angle };
            out.push(out[out.len() - 1] + turn.to_radians());
        }
        (reach(&out), out)
    };
    let draws = (0..DRAWS).map(|_| draw());
    draws.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, headings)| headings).unwrap_or_default()
}

/// Largest distance from the start of a polyline of unit lengths.
fn reach(headings: &[f64]) -> f64 {
    let (mut at, mut most) = ([0.0_f64; 2], 0.0_f64);
    for heading in headings {
        at = [at[0] + heading.cos(), at[1] + heading.sin()];
        most = most.max(at[0].hypot(at[1]));
    }
    most
}

/// Whether all points of `blocks`, which begin at `start`, are within the travel.
pub(super) fn is_within(start: Coordinates, blocks: &[Block], within: &dyn Fn(&Coordinates) -> bool) -> bool {
    let mut at = start;
    blocks.iter().all(|block| {
        let from = at;
        at = match *block {
            Block::Rapid { to } | Block::Line { to, .. } | Block::Arc { to, .. } => to,
            Block::Dwell => at,
        };
        (1..=CHECKED).all(|k| within(&point(&from, block, k as f64 / CHECKED as f64)))
    })
}

/// Point at a share of a block that begins at `from`.
fn point(from: &Coordinates, block: &Block, share: f64) -> Coordinates {
    match *block {
        Block::Rapid { to } | Block::Line { to, .. } => std::array::from_fn(|slot| from[slot] + share * (to[slot] - from[slot])),
        Block::Arc { to, centre_mm, clockwise, .. } => {
            let centre = [from[0] + centre_mm[0], from[1] + centre_mm[1]];
            let angle = |at: &Coordinates| (at[1] - centre[1]).atan2(at[0] - centre[0]);
            let turn = if clockwise { -1.0 } else { 1.0 };
            let sweep = (turn * (angle(&to) - angle(from))).rem_euclid(TAU);
            let sweep = if to == *from { TAU } else { sweep };
            let at = angle(from) + turn * share * sweep;
            let radius = centre_mm[0].hypot(centre_mm[1]);
            let mut out = *from;
            (out[0], out[1]) = (centre[0] + radius * at.cos(), centre[1] + radius * at.sin());
            out
        }
        Block::Dwell => *from,
    }
}
