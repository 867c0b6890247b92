//! Verification of changed feeds: every move of the output has the feed that was chosen for it.

use gcode::{Feed, Language, Move, Toolpath};

use super::refitted::Refitted;
use crate::error::VerifyError;
use crate::part::{POINT_MM, Part};

/// Largest difference of a written F by its rounding: half a unit of its last digit, in RS-274 and in dialogue.
const ROUNDING: f64 = 6e-5;
const DIALOGUE_ROUNDING: f64 = 6e-4;

/// Compares the F in force in every move of a compensated program, as it is read again, with that of the original move times its factor.
///
/// # Errors
/// Names the line whose feed differs. Such output must not be written.
pub(super) fn verify_feeds(part: &Part, refitted: &Refitted, toolpath: &Toolpath) -> Result<(), VerifyError> {
    let rounding = if part.program.language() == Language::Dialogue { DIALOGUE_ROUNDING } else { ROUNDING };
    let mut written = toolpath.moves.iter();
    let mut targets = refitted.targets.iter().peekable();
    for (index, original) in part.toolpath.moves.iter().enumerate() {
        let count = targets.next_if(|(owner, _)| *owner == index).map_or(1, |(_, elements)| elements.len());
        let wanted = original.feed_word.map(|word| word * part.feed_factors[index]);
        let differs = |step: &Move| match (step.feed_word, wanted) {
            (Some(is), Some(wanted)) => (is - wanted).abs() > rounding,
            (is, wanted) => is.is_some() != wanted.is_some(),
        };
        // Inverse time is shared by the lines of a move, a rapid has no feed, and a line to where the tool is needs none.
        let moves = original.length_mm().is_some_and(|length| length > POINT_MM) || turns(original);
        let counts = original.is_feed() && moves && !matches!(original.feed, Some(Feed::Duration { .. }));
        if let Some(step) = written.by_ref().take(count).filter(|step| counts && differs(step)).last() {
            let line = original.block as usize + 1;
            return Err(VerifyError::Feed { line, is: step.feed_word.unwrap_or_default(), wanted: wanted.unwrap_or_default() });
        }
    }
    Ok(())
}

fn turns(step: &Move) -> bool {
    step.start.nominal_rotary_rad() != step.end.nominal_rotary_rad()
}
