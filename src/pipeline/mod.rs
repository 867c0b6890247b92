//! From bytes to bytes: a program becomes a path, the path a plan, the learned reference a program again.

pub mod carry;
mod lines;
mod modes;
pub mod offsets;
pub mod part;
pub mod recorded;
pub mod refit;
pub mod replanned;
pub mod rows;
pub mod tool_path;
pub mod verify;
pub mod write;

pub use carry::{Carried, Written, write_out};
pub use offsets::{Placement, WorkOffsets};
pub use part::Part;
pub use recorded::as_recorded;
pub use refit::{Carrier, RefitSettings, Refitted, refit};
pub use replanned::Replanned;
pub use rows::{Rows, RowsWritten};
pub use verify::verify;
pub use write::write_program;
