//! Every table, sentence and JSON figure that the commands show.

pub mod check;
pub mod comparison;
pub mod compensation;
pub mod control;
pub mod diagnosis;
pub mod feeds;
pub mod figures;
#[cfg(feature = "fleet")]
pub mod fleet;
pub mod identification;
pub mod measurement;
pub mod program;
pub mod training;
pub mod written;
