//! Position gain, lag at constant speed, delay of the channels.

use crate::context::{AxisContext, SPREAD};
use crate::finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use servo::index;

/// Relative deviation above which a gain counts as not shown by the logs.
const TOO_WIDE: f64 = 0.5;
/// Relative standard deviation of the gain for what the structure of the loops gets wrong: on machines of the blind test that nothing had been
/// set on (seeds 200 to 279) it came out 1 % too large at the median, 2 to 9 % where it missed its interval.
pub const STRUCTURAL: f64 = 0.05;
/// Points of a picture.
const POINTS: usize = 800;

/// Gain, lag and delay of an axis.
pub fn findings(axis: &AxisContext<'_>) -> Vec<Finding> {
    vec![gain(axis), lag(axis), delay(axis)]
}

fn gain(axis: &AxisContext<'_>) -> Finding {
    let servo = &axis.fit.servo;
    let relative = axis.fit.coordinate_deviation(index::GAIN).unwrap_or(f64::INFINITY);
    if relative > TOO_WIDE {
        let why = "the error follows speed and acceleration alike for many gains";
        return Finding::not_observable(
            Quantity::VelocityGain,
            axis.name(),
            "1/s",
            why,
            "record reversals and stops at full acceleration (precomp excite)",
        );
    }
    let relative = relative.hypot(STRUCTURAL);
    let value = servo.position_gain_1_s;
    let estimate = Estimate { value, low: value * (-SPREAD * relative).exp(), high: value * (SPREAD * relative).exp() };
    let structure = match (servo.integral > 0.0, servo.position_integral_1_s > 0.0) {
        (_, true) => "PID position loop",
        (true, false) => "position loop P, velocity loop PI",
        (false, false) => "position loop P, velocity loop P",
    };
    let per_min = value * 60.0 / 1000.0;
    Finding {
        quantity: Quantity::VelocityGain,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "1/s",
        effect_um: None,
        verdict: Verdict::Figure,
        details: vec![
            ("gain, (m/min)/mm", per_min),
            ("bandwidth of the velocity loop, 1/s", servo.bandwidth_1_s),
            ("delay in the loop, ms", 1e3 * servo.loop_delay_s),
        ],
        meaning: format!(
            "{structure}; Kv {per_min:.2} (m/min)/mm. SINUMERIK MD32200 POSCTRL_GAIN, Fanuc No. 1825, LinuxCNC P of the position loop"
        ),
        remedy: String::new(),
        picture: None,
    }
}

fn lag(axis: &AxisContext<'_>) -> Finding {
    let deviation = axis.fit.deviation(servo::Servo::lag_s);
    let estimate = Estimate::within(axis.fit.servo.lag_s(), SPREAD * deviation).times(1e3);
    Finding {
        quantity: Quantity::FollowingLag,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "ms",
        effect_um: None,
        verdict: Verdict::Figure,
        details: vec![("tracking error at the test feed, µm", estimate.value * axis.circle.feed_mm_s)],
        meaning: "time by which the axis follows its command at constant speed; only differences between axes deform a contour"
            .to_owned(),
        remedy: String::new(),
        picture: Some(error_over_speed(axis)),
    }
}

/// Tracking error against commanded speed.
fn error_over_speed(axis: &AxisContext<'_>) -> Picture {
    let record = axis.record;
    let first = record.first_scored();
    let total: usize = record.runs.iter().map(|run| run.len().saturating_sub(first)).sum();
    let every = (total / POINTS).max(1);
    let points = record.runs.iter().flat_map(|run| {
        (first..run.len()).step_by(every).map(|k| (run.velocity(k, record.period_s), 1e3 * (run.reference[k] - run.actual[k])))
    });
    let top = record.top_speed_mm_s();
    let line = [-top, top].map(|speed| (speed, 1e3 * speed * axis.fit.servo.lag_s()));
    Picture {
        title: format!("{}: tracking error over speed", axis.name()),
        x: Label::new("commanded speed", "mm/s"),
        y: Label::new("tracking error", "µm"),
        series: vec![Series::new("logged", Mark::Points, points), Series::new("lag", Mark::Line, line)],
    }
}

fn delay(axis: &AxisContext<'_>) -> Finding {
    let servo = &axis.fit.servo;
    let whole = |servo: &servo::Servo| servo.channel_delay_s + 0.5 * servo.command_average_s;
    let fitted = [index::CHANNEL_DELAY, index::AVERAGE].iter().any(|parameter| axis.fit.free.0.contains(parameter));
    // Where no structure with a delay follows the log better, there is none above what a sample would show.
    let half = if fitted { SPREAD * axis.fit.deviation(whole) } else { 0.25 * axis.record.period_s };
    let estimate = Estimate::within(whole(servo), half).times(1e3);
    let meaning = match (servo.command_average_s > 0.0, fitted) {
        (true, _) => format!(
            "the command is averaged over {:.1} ms before the loop (SINUMERIK MD32400 AX_JERK_ENABLE, MD32410), which rounds corners and shrinks circles",
            1e3 * servo.command_average_s
        ),
        (false, true) => "delay of the actual channel behind the command channel, or of the command before the loop".to_owned(),
        (false, false) => "command and actual position belong to the same instants".to_owned(),
    };
    Finding {
        quantity: Quantity::ChannelDelay,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "ms",
        effect_um: None,
        verdict: Verdict::Figure,
        details: vec![("window of the average, ms", 1e3 * servo.command_average_s)],
        meaning,
        remedy: String::new(),
        picture: None,
    }
}
