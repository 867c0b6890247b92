//! Executions that repeat themselves: their program never ends.

use super::value::Fault;

/// State on which the blocks of one call depend beside the block that is executed: numbers of changes.
pub(super) type State = [u64; 3];

/// Blocks that were executed in one call since its state changed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    state: State,
    unchanged: usize,
}

impl Progress {
    /// Counts a block that is executed in this state, in a file of `blocks` blocks. If more are executed than the file has, one of them was executed
    /// twice in the same state: so will be all that follow.
    pub fn count(&mut self, state: State, blocks: usize) -> Result<(), Fault> {
        if self.state != state {
            *self = Self { state, unchanged: 0 };
        }
        self.unchanged += 1;
        if self.unchanged <= blocks {
            return Ok(());
        }
        let fault =
            Fault::new("the program does not end: this line runs again and again, and nothing that it depends on changes");
        Err(fault.help("check the condition of the loop"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_repeated_state_is_a_fault() {
        let mut progress = Progress::default();
        assert!((0..5).all(|_| progress.count([0; 3], 5).is_ok()));
        assert!((1..9).all(|change| progress.count([change, 0, 0], 5).is_ok()));
        assert!((0..4).all(|_| progress.count([8, 0, 0], 5).is_ok()));
        assert!(progress.count([8, 0, 0], 5).is_err());
    }
}
