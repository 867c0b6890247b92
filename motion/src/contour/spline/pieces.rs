//! A path of cubic pieces, and the nearest point on a range of it.

use super::cubic::{Cubic, Near, TOLERANCE_MM};
use crate::Vec3;
use crate::contour::{ContourError, Location};

/// Cubic pieces end to end. Pieces dropped at the front still count in every index.
#[derive(Debug, Clone, Default)]
pub(in crate::contour) struct Pieces {
    /// Piece `i` is stored at `i` modulo the length, which is a power of two.
    ring: Vec<Piece>,
    /// Ring length minus 1.
    mask: usize,
    /// Index of the first piece kept.
    first: usize,
    /// One past the index of the last piece.
    end: usize,
    /// Length along the chords up to the end of the last piece, mm.
    length_mm: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Piece {
    cubic: Cubic,
    /// Length along the chords up to the start of the piece, mm.
    arc: f64,
}

/// Initial capacity, pieces.
const FIRST_ROOM: usize = 64;

/// Number of pieces above which their middles are searched first.
const MANY: usize = 8;
/// Samples ahead and back that a slope of the spline depends on.
const SLOPE_REACH: usize = 2;

/// A point on the path.
#[derive(Debug, Clone, Copy)]
pub(in crate::contour) struct PathPoint {
    pub piece: usize,
    /// Parameter in `[0, 1]`.
    pub t: f64,
    /// Distance from the query point, mm.
    pub distance: f64,
}

impl PathPoint {
    /// Piece and parameter as one number.
    pub fn position(&self) -> f64 {
        self.piece as f64 + self.t
    }
}

impl Pieces {
    pub fn clear(&mut self) {
        (self.first, self.end) = (0, 0);
        self.length_mm = 0.0;
    }

    /// Adds the piece between two points with these end derivatives.
    #[inline(always)]
    pub fn push(&mut self, start: Vec3, start_slope: Vec3, end: Vec3, end_slope: Vec3) {
        if self.kept() == self.ring.len() {
            self.grow();
        }
        let arc = self.length_mm;
        let cubic = Cubic::hermite(start, start_slope, end, end_slope);
        self.length_mm += cubic.length;
        let slot = self.slot(self.end);
        self.ring[slot] = Piece { cubic, arc };
        self.end += 1;
    }

    /// Doubles the capacity.
    #[cold]
    fn grow(&mut self) {
        let mut ring = vec![Piece::default(); (2 * self.ring.len()).max(FIRST_ROOM)];
        for piece in self.first..self.end {
            let slot = piece & (ring.len() - 1);
            ring[slot] = self.ring[self.slot(piece)];
        }
        self.mask = ring.len() - 1;
        self.ring = ring;
    }

    #[inline(always)]
    fn slot(&self, piece: usize) -> usize {
        piece & self.mask
    }

    /// Drops the pieces before `piece`, except the last `least`.
    pub fn drop_before(&mut self, piece: usize, least: usize) {
        self.first = self.first.max(piece.min(self.end.saturating_sub(least)));
    }

    /// Index of the first piece kept.
    #[inline]
    pub fn first(&self) -> usize {
        self.first
    }

    /// One past the index of the last piece.
    #[inline]
    pub fn end(&self) -> usize {
        self.end
    }

    /// Number of pieces kept.
    #[inline]
    pub fn kept(&self) -> usize {
        self.end - self.first
    }

    #[inline]
    pub fn cubic(&self, piece: usize) -> &Cubic {
        &self.ring[self.slot(piece)].cubic
    }

    /// Length along the chords up to the start of `piece`, mm. `piece` may be one past the last.
    #[inline]
    pub fn arc(&self, piece: usize) -> f64 {
        if piece < self.end { self.ring[self.slot(piece)].arc } else { self.length_mm }
    }

    /// Length along the chords at a parameter of a piece, mm.
    #[inline]
    pub fn arc_on(&self, piece: usize, t: f64) -> f64 {
        let piece = &self.ring[self.slot(piece)];
        piece.arc + t * piece.cubic.length
    }

    /// Piece and parameter of a position, clamped to the pieces kept.
    #[inline]
    pub fn split(&self, position: f64) -> (usize, f64) {
        // Casts saturate: a position before the first piece is its start.
        let piece = (position as usize).clamp(self.first, self.end - 1);
        (piece, (position - piece as f64).clamp(0.0, 1.0))
    }

    /// Length along the chords at a position, mm.
    pub fn arc_at(&self, position: f64) -> f64 {
        let (piece, t) = self.split(position);
        self.arc_on(piece, t)
    }

    /// The nearest point to `p` on the pieces `low..high` (within those kept, not empty), to within
    /// [`TOLERANCE_MM`]. Among equally near points, the one that descent from `seed` (piece and
    /// parameter) reaches.
    #[inline]
    pub fn nearest(&self, low: usize, high: usize, seed: (usize, f64), p: &Vec3) -> PathPoint {
        let (piece, t) = if high - low > MANY { self.coarse(low, high, seed, p) } else { seed };
        let convex = self.cubic(piece).is_convex_to(p);
        let mut best = (piece, self.cubic(piece).nearest_from(p, t, convex));
        let (mut seen_low, mut seen_high) = (piece, piece + 1);
        // Whether the distance is certain to grow beyond the searched range.
        let (mut grows_low, mut grows_high) = (convex, convex);
        while best.1.t >= 1.0 && best.0 + 1 == seen_high && seen_high < high {
            grows_high = self.improve(seen_high, 0.0, p, &mut best);
            seen_high += 1;
        }
        while best.1.t <= 0.0 && best.0 == seen_low && seen_low > low {
            seen_low -= 1;
            grows_low = self.improve(seen_low, 1.0, p, &mut best);
        }
        let mut found = PathPoint { piece: best.0, t: best.1.t, distance: best.1.squared.sqrt() };
        self.beyond(seen_low - low, |i| seen_low - 1 - i, 0, grows_low, p, &mut found);
        self.beyond(high - seen_high, |i| seen_high + i, 1, grows_high, p, &mut found);
        found
    }

    /// The piece of `low..high` whose middle is nearest to `p`, or `seed` if no middle is nearer.
    /// Where a path hardly moves, many short pieces lie about one point: each would be searched if
    /// the first were not near the best.
    #[cold]
    fn coarse(&self, low: usize, high: usize, seed: (usize, f64), p: &Vec3) -> (usize, f64) {
        let mut best = (seed, (self.cubic(seed.0).point(seed.1) - p).norm_squared());
        let mut piece = low;
        while piece < high {
            let cubic = self.cubic(piece);
            let squared = (cubic.point(0.5) - p).norm_squared();
            if squared < best.1 {
                best = ((piece, 0.5), squared);
            }
            piece += 1;
            if cubic.is_point() && piece < high {
                let here = self.arc(piece);
                piece = first_where(piece..high, |piece| self.arc(piece + 1) > here);
            }
        }
        best.0
    }

    /// Searches `count` pieces, in order of distance from `found`, for a nearer point. The far end
    /// of piece `i` is the start of piece `i + far`.
    ///
    /// Away from a local minimum the distance grows from piece to piece as long as its square is
    /// convex along them. A nearer point is only possible from the first piece on where convexity
    /// is not certain. `grows`: the distance grows at the start.
    #[inline]
    fn beyond(&self, count: usize, at: impl Fn(usize) -> usize, far: usize, mut grows: bool, p: &Vec3, found: &mut PathPoint) {
        let mut i = 0;
        while i < count {
            let piece = at(i);
            let cubic = self.cubic(piece);
            grows = grows && cubic.is_convex_to(p);
            if !grows {
                self.compare(piece, p, found);
            }
            i += 1;
            // The samples of a standstill coincide: one evaluation is enough, except for the last
            // ones, whose slopes depend on the motion after it.
            if cubic.is_point() && i < count {
                let here = self.arc(piece);
                i = first_where(i..count, |i| self.arc(at(i) + far) != here).saturating_sub(SLOPE_REACH).max(i);
            }
        }
    }

    #[inline(never)]
    fn compare(&self, piece: usize, p: &Vec3, found: &mut PathPoint) {
        let cubic = self.cubic(piece);
        if !cubic.is_beyond(found.distance, p) && cubic.lower_bound(p) < found.distance - TOLERANCE_MM {
            let squared = found.distance * found.distance;
            if let Some(near) = cubic.nearer_than(p, 0.5, squared) {
                *found = PathPoint { piece, t: near.t, distance: near.squared.sqrt() };
            }
        }
    }

    /// Takes the nearest point of the next piece if it is nearer. Returns whether the squared
    /// distance is convex along it.
    #[inline(never)]
    fn improve(&self, piece: usize, start: f64, p: &Vec3, best: &mut (usize, Near)) -> bool {
        let cubic = self.cubic(piece);
        if let Some(near) = cubic.nearer_than(p, start, best.1.squared) {
            *best = (piece, near);
        }
        cubic.is_convex_to(p)
    }

    /// The contour error of `p` with its foot point at `found`. Segment and fraction are piece and
    /// parameter. `heading` is the last known direction of travel, used at standstill.
    #[inline]
    pub fn error_at(&self, found: &PathPoint, p: &Vec3, heading: &mut Vec3) -> ContourError {
        let PathPoint { piece, t, distance } = *found;
        let cubic = self.cubic(piece);
        let (foot, slope) = (cubic.point(t), cubic.slope(t));
        let speed_squared = slope.norm_squared();
        if speed_squared > 1e-24 {
            *heading = slope * (1.0 / speed_squared.sqrt());
        }
        let at_start = piece == 0 && t <= 0.0;
        ContourError {
            vector: p - foot,
            foot,
            tangent: *heading,
            magnitude_mm: distance,
            location: Location { segment: piece, fraction: t, arc_mm: self.arc_on(piece, t) },
            at_end: at_start || (t >= 1.0 && piece + 1 == self.end),
        }
    }
}

/// First number of `range` for which `holds` is true, or the end of the range. `holds` must be
/// monotonic. Steps double: near results are found at once, far ones in few steps.
pub(in crate::contour) fn first_where(range: std::ops::Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high, mut step) = (range.start, range.end, 1);
    while low + step <= range.end {
        let probe = low + step - 1;
        if holds(probe) {
            high = probe;
            break;
        }
        low = probe + 1;
        step *= 2;
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::first_where;

    #[test]
    fn the_first_number_is_found_wherever_it_lies() {
        for end in 0..40 {
            for first in 0..=end {
                assert_eq!(first_where(0..end, |i| i >= first), first);
            }
        }
    }
}
