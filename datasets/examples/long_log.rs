//! Writes a log of some hours at 1 kHz, for `benches/long-logs.sh`: `long_log HOURS OUT.csv`, or `OUT.parquet`.
//!
//! Three axes on curves that never repeat, with a standstill of five seconds a minute. The actual positions lag by 20 ms, stick by 2 µm at
//! reversals and have noise of 0.2 µm at most.

use std::path::Path;

use datasets::{LogSpool, write_all_and};
use motion::Axis;

/// Samples that are made at once, a minute.
const PIECE: usize = 60_000;

/// State of the machine.
#[derive(Default)]
struct Machine {
    travelled: f64,
    last: Option<[f64; 3]>,
    actual: [f64; 3],
    friction: [f64; 3],
    noise: u32,
}

impl Machine {
    /// Commanded and actual position at sample `k`, mm.
    fn step(&mut self, k: usize) -> ([f64; 3], [f64; 3]) {
        let t = k as f64 * 1e-3;
        let minute = t % 60.0;
        let speed = (55.0 - minute).clamp(0.0, 1.0).min(minute);
        self.travelled += 1e-3 * speed * (0.6 + 0.4 * (t / 300.0).sin());
        let s = self.travelled;
        let command = [60.0 * (0.9 * s).sin() + 5.0 * (4.1 * s).sin(), 45.0 * (1.3 * s).sin(), 8.0 * (0.37 * s).sin()];
        let last = self.last.replace(command).unwrap_or(command);
        let mut actual = [0.0; 3];
        for axis in 0..3 {
            let step = command[axis] - last[axis];
            let side = if step.abs() > 1e-5 { step.signum() } else { self.friction[axis] };
            self.friction[axis] += 0.03 * (side - self.friction[axis]);
            self.actual[axis] += 0.05 * (command[axis] - self.actual[axis]);
            self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(self.noise >> 8) / f64::from(1 << 24) - 0.5;
            actual[axis] = self.actual[axis] - 0.002 * self.friction[axis] + 4e-4 * noise;
        }
        (command, actual)
    }
}

/// The columns of positions.
fn columns(of: &[[f64; 3]]) -> Vec<Vec<f64>> {
    (0..3).map(|axis| of.iter().map(|at| at[axis]).collect()).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (hours, out) = arguments.next().zip(arguments.next()).ok_or("usage: long_log HOURS OUT.csv")?;
    let samples = (hours.parse::<f64>()? * 3.6e6) as usize;
    let mut machine = Machine::default();
    let mut spool = LogSpool::new(Path::new(&out), &Axis::xyz(), 1e-3)?;
    for from in (0..samples).step_by(PIECE) {
        let (commands, actuals): (Vec<_>, Vec<_>) = (from..(from + PIECE).min(samples)).map(|k| machine.step(k)).unzip();
        let (commands, actuals) = (columns(&commands), columns(&actuals));
        let commands: Vec<&[f64]> = commands.iter().map(Vec::as_slice).collect();
        let actuals: Vec<&[f64]> = actuals.iter().map(Vec::as_slice).collect();
        spool.add(&commands, &actuals)?;
    }
    Ok(write_all_and(&[], &mut [spool.finish()?])?)
}
