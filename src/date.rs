//! The day on which something is written, for what states it.

use anyhow::{Context, Result};
use chrono::{DateTime, Utc};

/// Variable by which builds that have to give the same bytes on every day set the clock: s since 1970.
const CLOCK: &str = "SOURCE_DATE_EPOCH";

/// Today in UTC as `YYYY-MM-DD`, or the day that `SOURCE_DATE_EPOCH` names.
///
/// # Errors
/// When the variable is no number of seconds between the years 1970 and 9999.
pub fn today() -> Result<String> {
    let now = match std::env::var_os(CLOCK) {
        None => Utc::now(),
        Some(set) => set
            .to_str()
            .and_then(|seconds| seconds.parse().ok())
            .filter(|seconds| (0..253_402_300_800).contains(seconds))
            .and_then(|seconds| DateTime::from_timestamp(seconds, 0))
            .with_context(|| format!("{CLOCK} is `{}`: give whole seconds since 1970, or unset it", set.display()))?,
    };
    Ok(now.date_naive().to_string())
}
