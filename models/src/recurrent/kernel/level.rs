//! Which instructions the kernels use.

use pulp::{Arch, Simd, WithSimd};

/// The instructions that a kernel is compiled for; picked when the program runs.
///
/// The same level, machine and input give the same bits; two levels differ in the last bits.
#[derive(Debug, Clone, Copy)]
pub struct Level(Arch);

impl Level {
    /// The widest that this machine has: AVX-512, AVX2 with FMA, NEON, or plain code.
    #[must_use]
    pub fn detect() -> Self {
        Self(Arch::new())
    }

    /// Plain code, which every machine runs.
    #[must_use]
    pub fn portable() -> Self {
        Self(Arch::Scalar)
    }

    /// Numbers in a vector.
    #[must_use]
    pub fn lanes(self) -> usize {
        self.run(Lanes)
    }

    /// Runs a kernel.
    pub(crate) fn run<K: WithSimd>(self, kernel: K) -> K::Output {
        self.0.dispatch(kernel)
    }
}

impl Default for Level {
    fn default() -> Self {
        Self::detect()
    }
}

/// Asks for the number of lanes.
struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}
