//! States in which the interpreter of LinuxCNC leaves its documentation.

/// Measured with `rs274` 2.9.0. Versions may differ, so what would follow from such a state is refused.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quirks {
    /// A `while` loop with a `break` ended since the end of the last `do` loop: the next `do` loop ends after its pass.
    pub broke_while: bool,
    /// A `do` loop was continued: the next `repeat` has twice its passes.
    pub continued_do: bool,
}
