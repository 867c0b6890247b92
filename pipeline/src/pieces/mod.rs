//! What is carried from piece to piece of a path that is not held.

mod approach;
mod heading;
mod rms_max;

use crate::error::Error;

pub(crate) use approach::Approach;
pub(crate) use heading::Heading;
pub(crate) use rms_max::RmsMax;

/// An error in a piece that begins `by_s` after the start of its path.
pub(crate) fn later(error: Error, by_s: f64) -> Error {
    match error {
        Error::TooFast { name, time_s, axis, speed, limit, times } => {
            Error::TooFast { name, time_s: time_s + by_s, axis, speed, limit, times }
        }
        Error::OffTravel { name, time_s, what } => Error::OffTravel { name, time_s: time_s + by_s, what },
        error => error,
    }
}
