//! How the allocator is to treat the long series that are made and dropped in every round.

use std::{hint::black_box, sync::Once};

/// Whether the allocator has seen a large block freed.
static TAUGHT: Once = Once::new();
/// Numbers in that block.
const LESSON: usize = 7 << 20;

/// Keeps the memory of dropped series for the next ones.
///
/// The GNU allocator fetches blocks larger than any that it has seen freed (up to 32 MiB) anew from the system every time, page by page;
/// having seen one this large, untouched, it keeps the memory: of a training step a quarter of the page faults remain. Other
/// allocators do not mind.
pub fn keep_memory() {
    TAUGHT.call_once(|| drop(black_box(Vec::<f32>::with_capacity(LESSON))));
}
