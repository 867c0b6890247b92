//! Memory aligned for vector loads.

use std::ops::{Deref, DerefMut};

/// One cache line, in `f32`s.
const LINE: usize = 16;

/// A resizable array of `f32` that starts on a cache line and keeps its memory when it shrinks.
#[derive(Debug, Clone, Default)]
pub(crate) struct Buffer {
    memory: Vec<f32>,
    start: usize,
    len: usize,
}

impl Buffer {
    /// Sets the length. The values are unspecified: old values or zeros.
    pub fn resize(&mut self, len: usize) {
        if self.memory.len() < len + LINE {
            // A new allocation: the old content is not copied.
            self.memory = vec![0.0; len + LINE];
        }
        self.start = self.memory.as_ptr().align_offset(4 * LINE).min(LINE);
        self.len = len;
    }

    /// Sets the length and all values to zero.
    pub fn zeros(&mut self, len: usize) {
        self.resize(len);
        self.fill(0.0);
    }
}

impl Deref for Buffer {
    type Target = [f32];
    fn deref(&self) -> &[f32] {
        &self.memory[self.start..self.start + self.len]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.memory[self.start..self.start + self.len]
    }
}
