//! Spatial ILC on a machine of your own: any type that turns a commanded motion into an actual one.

use compensation::{CorrectionLimits, StopRule, laws::Gain, laws::SpatialIlc, learn};
use machine::{Machine, MachineError, MachineSpec};
use motion::Trajectory;
use pipeline::{Input, Setup};

/// A machine whose axes follow their commands through a first-order lag.
struct Lagging {
    time_s: f64,
}

impl Machine for Lagging {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        let share = 1.0 - (-reference.period_s() / self.time_s).exp();
        let follow = |column: &Vec<f64>| {
            let mut at = column.first().copied().unwrap_or_default();
            column
                .iter()
                .map(|wanted| {
                    at += share * (wanted - at);
                    at
                })
                .collect()
        };
        Ok(reference.with_columns(reference.columns().iter().map(follow).collect())?)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let setup = Setup::new(&MachineSpec::builtin("ballscrew")?, None)?;
    let input = Input::curve("flower", 40.0, &setup)?;
    let mut law = SpatialIlc::new(Gain::Constant(0.8), None)?;
    let (mut machine, correction_limits, stop) = (Lagging { time_s: 0.005 }, CorrectionLimits::default(), StopRule::after(6));
    let learned = learn(&mut machine, &mut law, input.desired(), None, &correction_limits, &stop, &mut |_, _| 0.0)?;
    for (run, iteration) in learned.iterations.iter().enumerate() {
        println!("run {run}: {:.3} µm RMS", input.figures(&iteration.actual)?.tip.rms_mm * 1e3);
    }
    Ok(())
}
