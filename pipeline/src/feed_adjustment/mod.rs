//! Feed adjustment from the forecast.
//!
//! [`adjust`] chooses the feeds of a program for one [`Goal`]; [`trade_off`] shows cycle time against predicted error.

mod adjusted;
mod adjustment;
mod fastest;
mod goal;
mod group;
mod limits;
mod search;
mod slower;
mod trade_off;
mod trial;

pub use adjusted::{Adjusted, Bounds, ChipLoad};
pub use goal::{Goal, adjust};
pub use limits::FeedLimits;
pub use slower::SAME_TIME;
pub use trade_off::{TradeOff, trade_off};
