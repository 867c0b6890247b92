//! Instruction sets of the kernels.

use pulp::{Arch, Simd, WithSimd};

/// The instruction set of a kernel, selected at run time.
///
/// The same level, machine and input give the same bits. Two levels differ in the last bits.
#[derive(Debug, Clone, Copy)]
pub struct Level(Arch);

impl Level {
    /// The widest of this machine: AVX-512, AVX2 with FMA, NEON, or plain code.
    #[must_use]
    pub fn detect() -> Self {
        Self(Arch::new())
    }

    /// Plain code, available on every machine.
    #[must_use]
    pub fn portable() -> Self {
        Self(Arch::Scalar)
    }

    /// Number of lanes of a vector.
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

/// Queries the number of lanes.
struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}
