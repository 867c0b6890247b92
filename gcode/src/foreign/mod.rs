//! Files that are given as part programs and are none: what they are, and what to give instead.

mod kind;
mod signature;
mod text;
mod words;

pub use kind::Foreign;

use crate::program::{Language, Program};

/// Recognises content that is no milling program. `None` also for content that is only unusual: its faults are found by
/// [`interpret`](crate::interpret).
pub fn recognise(program: &Program) -> Option<Foreign> {
    let by_bytes = signature::recognise(program.bytes());
    match program.language() {
        Language::Dialogue => by_bytes,
        Language::Rs274 | Language::Sinumerik => {
            by_bytes.or_else(|| text::recognise(program)).or_else(|| words::recognise(program))
        }
    }
}
