//! Meaning of the columns of a table: axis, commanded or actual, unit.

mod map;
mod mapping;
mod names;
mod recognise;
mod unit;

pub use map::{AxisColumns, ColumnMap, Source};
pub(crate) use names::is_joint_pin;
pub(crate) use recognise::{implied_period_s, recognise_reference};
pub use unit::{Quantity, Unit};
