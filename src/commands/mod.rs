//! The commands, a file each.

pub mod check;
pub mod compare;
pub mod compensate;
pub mod completions;
pub mod demo;
pub mod diagnose;
pub mod excite;
#[cfg(feature = "fleet")]
pub mod fleet;
pub mod init;
pub mod measure;
pub mod predict;
pub mod refine;
pub mod reproduce;
pub mod simulate;
pub mod train;
