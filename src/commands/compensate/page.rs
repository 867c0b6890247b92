//! The report page of a compensation.

use anyhow::Result;
use models::Bundle;
use pipeline::Input;
use pipeline::model_based_ilc::Outcome;

use crate::report::{Forecasts, Group, Run, Track, asked, known, learning_curve, sections};

/// The forecasts of the program as it is, and compensated where that is better.
pub(super) fn before_and_after(track: &Track<'_>, outcome: &Outcome) -> Result<Vec<Run>> {
    let mut runs = vec![Run::of("before", track, None, &outcome.uncompensated)?];
    if outcome.gained {
        runs.push(Run::of("after", track, Some(&outcome.reference), &outcome.forecast)?);
    }
    Ok(runs)
}

/// The forecast before and after, how it was learned, and how well the model knows the machine there.
pub(crate) fn forecast(input: &Input, outcome: &Outcome, model: &Bundle, forecasts: &Forecasts) -> Result<Vec<Group>> {
    let track = Track::of(input);
    let mut all = sections(&track, &before_and_after(&track, outcome)?);
    all.extend(learning_curve(forecasts));
    all.extend([asked(model, input), known(model)]);
    Ok(vec![Group { name: input.name().to_owned(), sections: all }])
}
