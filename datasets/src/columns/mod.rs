//! Meaning of the columns of a table: axis, commanded or actual, unit.

mod clocks;
mod doubts;
mod entries;
mod map;
mod mapping;
mod meaning;
mod names;
mod numbered;
mod recognise;
mod unit;
mod vocabulary;

pub use map::{AxisColumns, Clock, ColumnMap, Side, Source};
pub(crate) use numbered::{edge_role, is_joint_pin};
pub(crate) use recognise::{
    CommandColumns, PROBED_ROWS, implied_period_s, is_known, is_own_clock, recognise_reference, table_encoders,
};
pub(crate) use unit::unit_name;
pub use unit::{Quantity, Unit};
