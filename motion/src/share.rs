//! Work distributed over the cores.

use std::ops::Range;

use rayon::prelude::*;

/// Minimum samples per thread.
pub const SHARE: usize = 2048;

/// Results of `work` on the numbers up to `len`, part by part, in order.
pub(crate) fn in_parts<T: Send>(len: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let work = |part: usize| work(part * SHARE..((part + 1) * SHARE).min(len));
    match len.div_ceil(SHARE) {
        // Not worth a thread.
        0 | 1 => (0..len.min(1)).map(work).collect(),
        parts => (0..parts).into_par_iter().map(work).collect(),
    }
}
