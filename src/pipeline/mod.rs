//! From bytes to bytes: a program becomes a path, the path a plan, the learned reference a program again.

pub mod part;
pub mod recorded;
pub mod refit;
pub mod verify;
pub mod write;

pub use part::Part;
pub use recorded::as_recorded;
pub use refit::{Carrier, RefitSettings, Refitted, refit};
pub use verify::verify;
pub use write::{Written, write_program};
