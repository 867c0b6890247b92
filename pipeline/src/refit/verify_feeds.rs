//! Verification of changed feeds: every move of the output has the feed that was chosen for it, slow lines before a stop apart.

use std::ops::Range;

use gcode::{Feed, Language, Move, Toolpath};

use super::refitted::Refitted;
use crate::error::VerifyError;
use crate::part::{POINT_MM, Part};

/// Largest difference of a written F by its rounding: half a unit of its last digit, in RS-274 and in dialogue.
const ROUNDING: f64 = 6e-5;
const DIALOGUE_ROUNDING: f64 = 6e-4;

/// Compares the F in force in every move of a compensated program, or of a section of it, as it is read again, with that of the original move
/// times its factor. Slow lines before a stop have a lower one. `moves` are the indices of the original moves.
///
/// # Errors
/// Names the line whose feed differs. Such output must not be written.
pub(super) fn verify_feeds(
    part: &Part,
    moves: &Range<usize>,
    refitted: &Refitted,
    toolpath: &Toolpath,
) -> Result<(), VerifyError> {
    let rounding = if part.program.language() == Language::Dialogue { DIALOGUE_ROUNDING } else { ROUNDING };
    let mut written = toolpath.moves.iter();
    let mut targets = refitted.targets.iter().peekable();
    for (index, original) in moves.clone().map(|index| (index, &part.toolpath.moves[index])) {
        let count = targets.next_if(|(owner, _)| *owner == index).map_or(1, |(_, elements)| elements.len());
        let slow = refitted.slow.get(&index).copied().unwrap_or_default();
        let wanted = original.feed_word.map(|word| word * part.feed_factors[index]);
        let differs = |(line, step): &(usize, &Move)| match (step.feed_word, wanted) {
            (Some(is), Some(wanted)) if line + slow >= count => is > wanted + rounding,
            (Some(is), Some(wanted)) => (is - wanted).abs() > rounding,
            (is, wanted) => is.is_some() != wanted.is_some(),
        };
        // Inverse time is shared by the lines of a move, a rapid has no feed, and a line to where the tool is needs none.
        let moves = original.length_mm().is_some_and(|length| length > POINT_MM) || turns(original);
        let counts = original.is_feed() && moves && !matches!(original.feed, Some(Feed::Duration { .. }));
        let lines = written.by_ref().take(count).enumerate();
        if let Some((_, step)) = lines.filter(|line| counts && differs(line)).last() {
            let line = original.block as usize + 1;
            return Err(VerifyError::Feed { line, is: step.feed_word.unwrap_or_default(), wanted: wanted.unwrap_or_default() });
        }
    }
    Ok(())
}

fn turns(step: &Move) -> bool {
    step.start.nominal_rotary_rad() != step.end.nominal_rotary_rad()
}
