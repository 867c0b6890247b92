//! Axes without motion, and axes without reversals.

use motion::AxisKind;

use super::purpose::Purpose;
use super::signals::{Signals, range};
use crate::{Check, Finding, Report, Severity};

/// A change of direction counts as a reversal if the axis continues for this share of its range,
/// and at least for 5 µm or 0.05 mrad.
const REVERSAL_SHARE: f64 = 1e-3;

pub(super) fn check(signals: &[Signals], purpose: Purpose, report: &mut Report) {
    if !signals.iter().any(Signals::moves) {
        report.push(Finding::new(
            Severity::Refuse,
            Check::Motion,
            "no axis's command moves in this log; record a run with motion",
        ));
        return;
    }
    for axis in signals {
        let shake = range(axis.actual);
        let still = axis.of_kind(1e-3, 1e-5);
        if !axis.moves() && shake > 100.0 * still {
            report.push(
                Finding::new(
                    Severity::Warn,
                    Check::Motion,
                    format!(
                        "the command never moves but the axis travels {shake:.3} {}; is the command the right column?",
                        axis.unit()
                    ),
                )
                .in_column(axis.reference_name()),
            );
        } else if !axis.moves() {
            let moved = range(axis.reference);
            let text = if moved > still {
                format!("the axis moves by {moved:.4} {} only", axis.unit())
            } else {
                "the axis never moves".to_owned()
            };
            let text = if purpose == Purpose::Training { format!("{text} and is left out of training") } else { text };
            report.push(Finding::new(Severity::Note, Check::Motion, text).in_column(axis.reference_name()));
        } else if is_dead(axis) {
            report.push(
                Finding::new(
                    Severity::Refuse,
                    Check::Motion,
                    format!(
                        "the command travels {:.3} {} but the actual position never changes; log the encoder's position",
                        range(axis.reference),
                        axis.unit()
                    ),
                )
                .in_column(axis.actual_name()),
            );
        } else if purpose == Purpose::Training && reversals(axis) == 0 {
            report.push(
                Finding::new(
                    Severity::Warn,
                    Check::Motion,
                    "the axis moves in one direction only: this run teaches nothing about its friction the other way, and its backlash; \
                     at least one reversal is needed",
                )
                .in_column(axis.reference_name()),
            );
        }
    }
}

/// Whether the actual position is constant while the command moves.
pub(super) fn is_dead(axis: &Signals) -> bool {
    is_stuck(axis.axis.kind, range(axis.reference), range(axis.actual))
}

/// Whether an actual position that travels this far, mm or rad, stands still while its command moves.
pub(crate) fn is_stuck(kind: AxisKind, command: f64, actual: f64) -> bool {
    let still = match kind {
        AxisKind::Linear => 1e-3,
        AxisKind::Rotary => 1e-5,
    };
    actual < still && command > 10.0 * still
}

/// Number of reversals of the command.
pub(super) fn reversals(axis: &Signals) -> usize {
    let least = (REVERSAL_SHARE * range(axis.reference)).max(axis.of_kind(5e-3, 5e-5));
    let Some(&first) = axis.reference.first() else {
        return 0;
    };
    let (mut low, mut high) = (first, first);
    let mut direction = 0;
    let mut count = 0;
    for &position in axis.reference {
        low = low.min(position);
        high = high.max(position);
        let turned = if direction <= 0 && position > low + least {
            1
        } else if direction >= 0 && position < high - least {
            -1
        } else {
            continue;
        };
        if direction != 0 {
            count += 1;
        }
        direction = turned;
        (low, high) = (position, position);
    }
    count
}
