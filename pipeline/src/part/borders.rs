//! Positions at which the tool has to be where the program states it: between a move that may be compensated and everything that is left
//! alone.

use std::ops::Range;

use gcode::{Word, WordKind};
use motion::{Axis, AxisKind};

use super::Part;

/// G codes that neither move the tool, nor depend on its position, nor change coordinates: motion codes, dwell, exact stop, planes, units,
/// G40, path modes, G80, distances, feed modes, spindle modes, return levels.
const NEUTRAL_G: [f64; 43] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 9.0, 17.0, 18.0, 19.0, 20.0, 21.0, 40.0, 61.0, 61.1, 64.0, 70.0, 71.0, 80.0, 90.0, 90.1, 91.0, 91.1,
    93.0, 94.0, 95.0, 96.0, 97.0, 98.0, 99.0, 5.1, 60.0, 601.0, 602.0, 603.0, 641.0, 642.0, 643.0, 644.0, 645.0, 450.0, 451.0,
    700.0, 710.0,
];
/// M codes of stops.
const STOPS: [f64; 3] = [0.0, 1.0, 60.0];
/// M codes of spindle, coolant, overrides and outputs. Those of stops are none of them: the tool waits at the place that the program states. Nor is
/// M68, an output of LinuxCNC: it clamps an axis on other controls.
const NEUTRAL_M: [f64; 18] =
    [3.0, 4.0, 5.0, 7.0, 8.0, 9.0, 13.0, 14.0, 48.0, 49.0, 50.0, 51.0, 52.0, 53.0, 62.0, 63.0, 64.0, 65.0];

/// Motion of a rotary axis that is none but for rounding, rad.
const STILL_RAD: f64 = 1e-9;

/// Consecutive path pieces that may be compensated together, between two [borders](Part::borders), and their samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathSegment {
    /// Path pieces.
    pub pieces: Range<usize>,
    /// Samples of the plan.
    pub samples: Range<usize>,
}

impl Part {
    /// The segments that may be compensated, in their order.
    #[must_use]
    pub fn segments(&self) -> Vec<PathSegment> {
        let borders = self.borders();
        let pieces: Vec<usize> = (0..self.owners.len()).collect();
        let chunks = pieces.chunk_by(|piece, _| !borders[*piece]);
        let mut from = 0;
        let segment = |chunk: &[usize]| {
            let pieces = chunk[0]..chunk[chunk.len() - 1] + 1;
            let samples = from..from + self.plan.samples[from..].partition_point(|sample| sample.piece < pieces.end);
            from = samples.end;
            let changes = self.owners[pieces.start].is_some_and(|owner| self.is_shiftable(&self.toolpath.moves[owner]));
            changes.then_some(PathSegment { pieces, samples })
        };
        chunks.filter_map(segment).collect()
    }

    /// Samples in which an axis of the machine is at rest over a whole segment, if it is a rotary one: where it is not to move, it may be clamped.
    pub(crate) fn resting(&self) -> Vec<Vec<Range<usize>>> {
        let path = self.plan.desired.trajectory();
        let (axes, segments) = (path.axes().iter().zip(path.columns()), self.segments());
        let resting = |(axis, column): (&Axis, &Vec<f64>)| {
            let rests =
                |samples: &Range<usize>| column[samples.clone()].iter().all(|at| (at - column[samples.start]).abs() < STILL_RAD);
            let all = segments.iter().map(|segment| segment.samples.clone());
            if axis.kind == AxisKind::Rotary { all.filter(rests).collect() } else { Vec::new() }
        };
        axes.map(resting).collect()
    }

    /// What of a segment belongs to the moves with these indices; `None` where nothing does.
    pub(crate) fn within(&self, of: PathSegment, moves: &Range<usize>) -> Option<PathSegment> {
        let belongs = |piece: &usize| self.owners[*piece].is_some_and(|owner| moves.contains(&owner));
        if belongs(&of.pieces.start) && belongs(&(of.pieces.end - 1)) {
            return Some(of);
        }
        // The moves of a segment follow one another.
        let start = of.pieces.clone().find(belongs)?;
        let end = of.pieces.clone().rfind(belongs)? + 1;
        let at = |piece: usize| {
            of.samples.start + self.plan.samples[of.samples.clone()].partition_point(|sample| sample.piece < piece)
        };
        Some(PathSegment { pieces: start..end, samples: at(start)..at(end) })
    }

    /// Whether the correction is zero behind each path piece: beside moves that are left alone, at dwells, and where anything between two
    /// moves depends on the position, such as G92, a work offset, homing, or a call.
    #[must_use]
    pub fn borders(&self) -> Vec<bool> {
        let shiftable = |owner: Option<usize>| owner.filter(|index| self.is_shiftable(&self.toolpath.moves[*index]));
        let meets = |pair: [Option<usize>; 2]| match pair.map(shiftable) {
            [Some(before), Some(after)] => !self.is_neutral_between(before, after),
            _ => true,
        };
        let next = |piece: usize| self.owners.get(piece + 1).copied().flatten();
        (0..self.owners.len()).map(|piece| meets([self.owners[piece], next(piece)])).collect()
    }

    /// Whether nothing between two moves needs the programmed position.
    fn is_neutral_between(&self, before: usize, after: usize) -> bool {
        let moves = &self.toolpath.moves;
        // Runs of different path modes are written apart.
        let alike = self.stops_exactly(&moves[before]) == self.stops_exactly(&moves[after]);
        // A dwell is no place for a correction along the path, which no forecast of the contour error opposes: on a straight line it grew from
        // 7 nm to its bound in ten updates.
        let stays = moves[before + 1..after].iter().all(|step| self.is_shiftable(step));
        let (first, last) = (moves[before].block as usize, moves[after].block as usize);
        // Of the words of the first block, the M codes may act after its motion.
        let own = self.program.block_words(first).iter().filter(|word| word.is(b'M'));
        // A stop in the last block comes behind its motion.
        let others = (first + 1..=last).flat_map(|block| self.program.block_words(block).iter().map(move |word| (block, word)));
        let others =
            others.filter(|(block, word)| *block < last || !(word.is(b'M') && STOPS.contains(&word.value))).map(|(_, word)| word);
        let neutral = |word: &Word| is_neutral(word, self.program.text(word.span));
        // The tool waits at the place that the program states.
        let goes_on = !moves[after].after_stop;
        alike && stays && goes_on && !self.is_interrupted(before, after) && own.chain(others).all(neutral)
    }
}

fn is_neutral(word: &Word, text: &[u8]) -> bool {
    match word.kind {
        WordKind::Comment | WordKind::BlockDelete | WordKind::Percent | WordKind::Motion => true,
        WordKind::Expression | WordKind::Assignment | WordKind::Flow if reads_position(text) => false,
        WordKind::Expression if word.value.is_nan() => false,
        WordKind::Assignment | WordKind::Flow => true,
        WordKind::Number | WordKind::Expression => match word.letter {
            b'G' => NEUTRAL_G.contains(&word.value),
            b'M' => NEUTRAL_M.contains(&word.value),
            b'D' | b'E' | b'H' | b'O' | b'T' | b'U' | b'V' | b'W' => false,
            _ => true,
        },
        WordKind::Keyword => word.is_silent(),
        WordKind::Unknown => false,
    }
}

/// Whether a statement may read a parameter that holds a position (LinuxCNC #5420 and #<_x>, Fanuc #5001 on, $AA_IW of SINUMERIK), itself or through a
/// computed number.
fn reads_position(text: &[u8]) -> bool {
    let computed = [&b"#<_"[..], b"##", b"#["].iter().any(|mark| text.windows(mark.len()).any(|window| window == *mark));
    computed
        || text.contains(&b'$')
        || text.windows(5).any(|window| window.starts_with(b"#5") && window[2..].iter().all(u8::is_ascii_digit))
}

#[cfg(test)]
mod tests {
    use super::reads_position;

    #[test]
    fn parameters_of_positions_are_known_by_their_numbers() {
        for text in ["#1=#5420", "[#5001+1]", "#<_x>", "#[#1+1]", "##2", "R1=$AA_IW[X]"] {
            assert!(reads_position(text.as_bytes()), "{text}");
        }
        for text in ["#5=3", "[#51*2]", "#530+#512", "#<depth>=1"] {
            assert!(!reads_position(text.as_bytes()), "{text}");
        }
    }
}
