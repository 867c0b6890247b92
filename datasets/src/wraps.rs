//! Time stamps that begin anew: counters that overflow, and the ends of minutes, hours and days.

use crate::{Check, Finding, Severity};

/// What a stamp is short of after it began anew, s, and why.
const WRAPS: [(f64, &str); 9] = [
    (86_400.0, "the end of a day"),
    (3_600.0, "the end of an hour"),
    (60.0, "the end of a minute"),
    (1.0, "the end of a second"),
    (0.065_536, "16 bits of µs"),
    (65.536, "16 bits of ms"),
    (4_294.967_296, "32 bits of µs"),
    (4_294_967.296, "32 bits of ms"),
    (4.294_967_296, "32 bits of ns"),
];
/// Longest step over such a place, in usual ones.
const USUAL_STEPS: f64 = 3.0;

/// Adds what is missing behind every place at which stamps (s) begin anew. `None` where they go back nowhere, or anywhere else.
pub(crate) fn go_on(times: &mut [f64]) -> Option<Finding> {
    let mut forward: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    let usual_s = motion::quantile(&mut forward, 0.5)?;
    let (mut found, mut missing_s) = (None, Vec::with_capacity(times.len()));
    let mut ahead_s = 0.0;
    for k in 0..times.len() {
        let step_s = if k > 0 { times[k] - times[k - 1] } else { 0.0 };
        if step_s < 0.0 {
            // What overflows stays below its limit and begins at zero.
            let most_s = USUAL_STEPS * usual_s;
            let is_it = |wrap_s: f64| {
                (0.0..=most_s).contains(&(step_s + wrap_s)) && (0.0..=most_s).contains(&times[k]) && times[k - 1] <= wrap_s
            };
            let (wrap_s, why) = WRAPS.into_iter().find(|(wrap_s, _)| is_it(*wrap_s))?;
            if *found.get_or_insert(why) != why {
                return None;
            }
            ahead_s += wrap_s;
        }
        missing_s.push(ahead_s);
    }
    let why = found?;
    times.iter_mut().zip(&missing_s).for_each(|(time, missing_s)| *time += missing_s);
    let message = format!("the time stamps begin anew ({why}) and were taken as going on");
    Some(Finding::new(Severity::Note, Check::Mended, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_and_clocks_go_on_and_a_clock_that_was_set_back_does_not() {
        let whole: Vec<f64> = (0..100_000).map(|k| 86_390.0 + 0.002 * f64::from(k)).collect();
        for (wrap_s, why) in [(86_400.0, "a day"), (60.0, "a minute"), (65.536, "16 bits of ms"), (1.0, "a second")] {
            let mut times: Vec<f64> = whole.iter().map(|time| time % wrap_s).collect();
            let first_s = times[0];
            let finding = go_on(&mut times).unwrap();
            assert!(finding.message.contains(why), "{finding}");
            let off_s = |(time, wanted): (&f64, &f64)| ((time - first_s) - (wanted - 86_390.0)).abs();
            assert!(times.iter().zip(&whole).all(|pair| off_s(pair) < 1e-6), "{why}");
        }
        for times in [
            vec![],
            vec![1.0; 9],
            vec![0.0, 0.002, 0.004, 0.001, 0.003],
            vec![1.996, 1.998, 1.0, 1.002],
            whole.iter().map(|time| time % 7.0).collect(),
        ] {
            let mut same = times.clone();
            assert!(go_on(&mut same).is_none() && same == times);
        }
    }
}
