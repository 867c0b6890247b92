//! Allocator settings for the long series that are allocated and freed in every iteration.

use std::{hint::black_box, sync::Once};

/// Whether a large block was freed before.
static PRIMED: Once = Once::new();
/// Length of that block, in `f32`s.
const BLOCK_LEN: usize = 7 << 20;

/// Keeps the memory of freed series for the next ones.
///
/// The GNU allocator requests blocks larger than any freed one (up to 32 MiB) from the system every
/// time, page by page. Once a block of this size was freed, untouched, it keeps the memory: a
/// quarter of the page faults of a training step remain. Other allocators are not affected.
pub fn keep_memory() {
    PRIMED.call_once(|| drop(black_box(Vec::<f32>::with_capacity(BLOCK_LEN))));
}
