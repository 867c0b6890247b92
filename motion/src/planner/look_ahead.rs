//! What a control knows of the path ahead, and the time that it needs for a piece.

use std::ops::Range;

use super::geometry::{Node, Segment};
use crate::share::in_parts;

/// Lowest planned speed between stops, mm/s. Bounds the time at a cusp.
pub(super) const MIN_SPEED_MM_S: f64 = 1e-3;

/// The nodes of every piece of the whole path, in order. Each half of a blend counts to its own piece.
pub(super) fn pieces(segment: &Segment) -> Vec<Range<usize>> {
    let of_piece = segment.nodes.chunk_by(|a, b| segment.index_of(a.piece) == segment.index_of(b.piece));
    let ranges = of_piece.scan(0, |end, nodes| {
        let start = *end;
        *end += nodes.len();
        Some(start..*end)
    });
    ranges.collect()
}

/// Lowers the caps on the squared speed where a piece would take less than `least_s`.
pub(super) fn keep_piece_time(cap: &mut [f64], nodes: &[Node], pieces: &[Range<usize>], least_s: f64) {
    if least_s <= 0.0 {
        return;
    }
    for piece in pieces {
        let most_mm_s = ((nodes[piece.end - 1].s - nodes[piece.start].s) / least_s).max(MIN_SPEED_MM_S);
        cap[piece.clone()].iter_mut().for_each(|cap| *cap = cap.min(most_mm_s * most_mm_s));
    }
}

/// Caps from which a control that knows `ahead` pieces after the present one can stop at the end of the last of them.
///
/// `reach` is the squared speed at the node before `k` from which that at `k` is reached by braking. The whole segment ends with a stop, so
/// that its last pieces need no further cap.
pub(super) fn caps(cap: &[f64], pieces: &[Range<usize>], ahead: usize, reach: impl Fn(usize, f64) -> f64 + Sync) -> Vec<f64> {
    let of_piece = |piece: usize| {
        let own = pieces[piece].clone();
        let mut out = cap[own.clone()].to_vec();
        let Some(last) = piece.checked_add(ahead).and_then(|last| pieces.get(last)).filter(|last| last.end < cap.len()) else {
            return out;
        };
        let mut squared = 0.0;
        for k in (own.start + 1..last.end).rev() {
            squared = reach(k, squared);
            // From here on the caps themselves bound the braking, in every profile.
            if squared >= cap[k - 1] {
                break;
            }
            if k <= own.end {
                out[k - 1 - own.start] = squared.max(MIN_SPEED_MM_S * MIN_SPEED_MM_S);
            }
        }
        out
    };
    in_parts(pieces.len(), |part| part.flat_map(of_piece).collect::<Vec<f64>>()).concat()
}
