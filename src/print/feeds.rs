//! Feeds chosen from the forecast.

use pipeline::feed_adjustment::{Adjusted, Bounds, ChipLoad, Goal, SAME_TIME, TradeOff};
use pipeline::units::um;
use serde_json::{Value, json};

use crate::output::{Printer, table};

/// Lines above the tolerance that are named one by one.
const NAMED: usize = 5;

/// What the feeds of a program came to.
pub fn show(printer: &Printer, adjusted: &Adjusted, goal: Goal) {
    let (before_s, after_s) = adjusted.cycle_s;
    let (slower, faster) = adjusted.moves;
    let tolerance = goal.tolerance_mm().map_or(String::new(), |tolerance_mm| format!(", tolerance {} µm", um(tolerance_mm)));
    printer.line(format!(
        "feeds: {slower} moves slower, {faster} faster; cycle time {before_s:.2} → {after_s:.2} s ({:+.1} %); predicted MAX on feed moves {} → {} µm{tolerance}",
        100.0 * (after_s / before_s - 1.0),
        um(adjusted.max_mm.0),
        um(adjusted.max_mm.1),
    ));
    if let Some(Bounds { allowed_s, machine_s }) = adjusted.bounds {
        printer.line(format!(
            "the program without a tolerance: {allowed_s:.2} s at the highest feeds allowed, {machine_s:.2} s at the limits of the machine alone"
        ));
    }
    show_missed(printer, adjusted, goal);
    for load in &adjusted.chip_loads {
        printer.line(format!("warning: {}; compare with the data of the tool", chip_load(load)));
    }
}

/// Where the goal is missed.
fn show_missed(printer: &Printer, adjusted: &Adjusted, goal: Goal) {
    let (before_s, after_s) = adjusted.cycle_s;
    match goal {
        Goal::Slower { keep_time: true, .. }
            if after_s > before_s * (1.0 + SAME_TIME) && adjusted.moves == (0, 0) && adjusted.above.is_empty() =>
        {
            printer.line("note: the programmed feeds keep the tolerance and stay; the cycle is longer by the correction alone");
        }
        Goal::Slower { keep_time: true, .. } if after_s > before_s * (1.0 + SAME_TIME) => {
            printer.line("warning: the other moves cannot win all of the time back within the tolerance and the axes' limits");
        }
        Goal::WithinTime { change } if after_s > before_s * (1.0 + change) => printer.line(format!(
            "warning: no feeds within the limits are fast enough for {:.2} s; --may-exceed-feed allows higher ones",
            before_s * (1.0 + change)
        )),
        Goal::Slower { .. } | Goal::Fastest { .. } | Goal::WithinTime { .. } => {}
    }
    let at = match goal {
        Goal::Fastest { .. } => "at the feeds that were tried",
        Goal::Slower { .. } | Goal::WithinTime { .. } => "at the slowest feed that helps",
    };
    for (line, error) in adjusted.above.iter().take(NAMED) {
        printer.line(format!("warning: line {line}: predicted contour error {} µm {at}", um(*error)));
    }
    if adjusted.above.len() > NAMED {
        printer.line(format!("warning: {} more moves stay above the tolerance", adjusted.above.len() - NAMED));
    }
}

/// A raised feed: `line 12, tool 3: feed 2400 → 4800 mm/min, 0.300 → 0.600 mm per revolution, chips 100 % thicker`.
fn chip_load(load: &ChipLoad) -> String {
    let (before, after) = load.feed_mm_s;
    let tool = load.tool.map_or(String::new(), |tool| format!(", tool {tool}"));
    let turn = match load.spindle_rpm {
        Some(rpm) if rpm > 0.0 => {
            format!(", {:.4} → {:.4} mm per revolution", 60.0 * before / rpm, 60.0 * after / rpm)
        }
        _ => String::new(),
    };
    format!(
        "line {}{tool}: feed {:.0} → {:.0} mm/min{turn}: chips {:.0} % thicker, the most with this tool",
        load.line,
        60.0 * before,
        60.0 * after,
        100.0 * (after / before - 1.0)
    )
}

/// The same as JSON, with the trade-off where it was asked for.
pub fn json(adjusted: &Adjusted, goal: Goal, pareto: &Value) -> Value {
    let (name, change) = match goal {
        Goal::Slower { keep_time: false, .. } => ("slower", None),
        Goal::Slower { keep_time: true, .. } => ("slower-in-the-same-time", None),
        Goal::Fastest { .. } => ("fastest", None),
        Goal::WithinTime { change } => ("within-time", Some(change)),
    };
    let bounds = adjusted.bounds.map(|bounds| json!({ "allowed": bounds.allowed_s, "machine": bounds.machine_s }));
    json!({
        "goal": name,
        "tolerance_um": goal.tolerance_mm().map(|tolerance_mm| tolerance_mm * 1e3),
        "keep_time": matches!(goal, Goal::Slower { keep_time: true, .. }),
        "max_time_change": change,
        "slower_moves": adjusted.moves.0,
        "faster_moves": adjusted.moves.1,
        "cycle_before_s": adjusted.cycle_s.0,
        "cycle_after_s": adjusted.cycle_s.1,
        "cycle_without_tolerance_s": bounds,
        "max_before_um": adjusted.max_mm.0 * 1e3,
        "max_after_um": adjusted.max_mm.1 * 1e3,
        "lines_above": adjusted.above.iter().map(|(line, error)| json!({ "line": line, "max_um": error * 1e3 })).collect::<Vec<_>>(),
        "chip_loads": adjusted.chip_loads.iter().map(chip_load_json).collect::<Vec<_>>(),
        "pareto": pareto,
    })
}

fn chip_load_json(load: &ChipLoad) -> Value {
    json!({
        "tool": load.tool,
        "spindle_rpm": load.spindle_rpm,
        "line": load.line,
        "feed_before_mm_min": 60.0 * load.feed_mm_s.0,
        "feed_after_mm_min": 60.0 * load.feed_mm_s.1,
    })
}

/// Cycle time against predicted error, beside the programmed feeds.
pub fn show_trade_off(printer: &Printer, programmed: &TradeOff, points: &[TradeOff]) {
    printer.line("cycle time against the predicted contour error of the compensated program");
    let row = |name: &str, point: &TradeOff| {
        vec![
            name.to_owned(),
            format!("{:.2}", point.cycle_s),
            format!("{:+.1}", 100.0 * (point.cycle_s / programmed.cycle_s - 1.0)),
            um(point.max_mm),
            um(point.rms_mm),
        ]
    };
    let own = std::iter::once(row("programmed feeds", programmed));
    let others = points.iter().enumerate().map(|(number, point)| row(&(number + 1).to_string(), point));
    printer.line(table(&["feeds", "cycle s", "%", "MAX µm", "RMS µm"], &own.chain(others).collect::<Vec<_>>()));
}

/// The same as JSON.
pub fn trade_off_json(programmed: &TradeOff, points: &[TradeOff]) -> Value {
    let one = |point: &TradeOff| json!({ "cycle_s": point.cycle_s, "max_um": point.max_mm * 1e3, "rms_um": point.rms_mm * 1e3 });
    json!({ "programmed": one(programmed), "points": points.iter().map(one).collect::<Vec<_>>() })
}
