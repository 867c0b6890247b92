//! A machine of simulated drives.

use motion::{Axis, Trajectory};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::drive::{Drive, Readings, Start};
use crate::options::{Sensor, SimulationOptions};
use crate::spec::{DriveSpec, MachineSpec, Rates};
use crate::{Machine, MachineError};

/// One run, measured at both ends of the screws and gears.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Readings of the motor encoders.
    pub motor: Trajectory,
    /// Readings of the table scales, i.e. the tool position.
    pub table: Trajectory,
}

/// A machine of simulated drives, one per axis, linear or rotary.
///
/// Every run starts with an approach: each axis moves from 1 mm (or 1 mrad) below its first
/// position and stops there. This defines the state of friction, backlash and integrators. Noise is
/// drawn from `ChaCha8(seed)`, one stream per run and axis.
#[derive(Debug, Clone)]
pub struct SimulatedMachine {
    axes: Vec<SimulatedAxis>,
    period_s: f64,
    options: SimulationOptions,
    /// The sensor by the machine file.
    sensor: Sensor,
    seed: u64,
    runs: u64,
    /// Running time so far, s: friction changes while the machine warms up.
    elapsed_s: f64,
}

/// An axis and its drive.
#[derive(Debug, Clone)]
struct SimulatedAxis {
    axis: Axis,
    /// In mm, or mrad for a rotary axis.
    drive: DriveSpec,
    rates: Rates,
    /// Drive units (mm or mrad) per trajectory unit (mm or rad).
    per_unit: f64,
}

/// Approach before a run, mm or mrad, and its times, s.
const APPROACH: f64 = 1.0;
const APPROACH_S: f64 = 0.15;
const REST_S: f64 = 0.25;

impl SimulatedMachine {
    /// The machine described by `spec`, with its sensors and all noise. `seed` defines the noise of
    /// all runs.
    ///
    /// # Errors
    /// If the description is invalid or an axis has no drive.
    pub fn new(spec: &MachineSpec, seed: u64) -> Result<Self, MachineError> {
        spec.check()?;
        let axes = spec
            .axes
            .iter()
            .map(|axis| {
                let name = axis.name();
                let (drive, per_unit) = axis.simulated().ok_or_else(|| {
                    MachineError::BadDescription(format!(
                        "axis `{name}` has no `drive`; describe one in `[axes.drive]`, or simulate a machine that has drives"
                    ))
                })?;
                let rates = drive.rates(&format!("axes.{name}.drive"), spec.sampling_period_ms)?;
                Ok(SimulatedAxis { axis: axis.axis(), drive, rates, per_unit })
            })
            .collect::<Result<_, MachineError>>()?;
        let (period_s, sensor) = (spec.sampling_period_s(), spec.sensor);
        Ok(Self { axes, period_s, options: SimulationOptions::default(), sensor, seed, runs: 0, elapsed_s: 0.0 })
    }

    /// The same machine with other simulation options.
    ///
    /// # Errors
    /// If the noise scale is negative or not finite.
    pub fn with_options(mut self, options: SimulationOptions) -> Result<Self, MachineError> {
        if !(options.noise_scale.is_finite() && options.noise_scale >= 0.0) {
            return Err(MachineError::BadDescription(format!(
                "the noise's scale is {}; it must be zero or more, and finite",
                options.noise_scale
            )));
        }
        self.options = options;
        Ok(self)
    }

    /// Simulation options.
    #[must_use]
    pub fn options(&self) -> SimulationOptions {
        self.options
    }

    /// Position sensor of the position loop.
    #[must_use]
    pub fn sensor(&self) -> Sensor {
        self.options.sensor.unwrap_or(self.sensor)
    }

    /// Number of runs drawn from the sequence so far.
    #[must_use]
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// Runs `reference` with the next noise of the sequence and returns both views.
    ///
    /// # Errors
    /// If axes or period are not those of the machine, there is no sample, or a drive is unstable.
    pub fn run_full(&mut self, reference: &Trajectory) -> Result<Run, MachineError> {
        let run = self.simulate(reference, self.seed, self.runs)?;
        self.runs += 1;
        self.elapsed_s += APPROACH_S + REST_S + reference.duration_s();
        Ok(run)
    }

    /// Runs `reference` with noise of a separate seed, outside the sequence, and returns both
    /// views.
    ///
    /// # Errors
    /// As [`SimulatedMachine::run_full`].
    pub fn run_with_seed(&self, reference: &Trajectory, seed: u64) -> Result<Run, MachineError> {
        self.simulate(reference, seed, 0)
    }

    fn simulate(&self, reference: &Trajectory, seed: u64, run: u64) -> Result<Run, MachineError> {
        self.check(reference)?;
        let mut readings = vec![Readings::default(); self.axes.len()];
        // Axes are independent, so the result does not depend on thread scheduling.
        std::thread::scope(|scope| {
            for (i, (out, column)) in readings.iter_mut().zip(reference.columns()).enumerate() {
                let axis = &self.axes[i];
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream((run << 8) | i as u64);
                scope.spawn(move || *out = self.follow(axis, column, rng));
            }
        });
        let (mut motor, mut table) = (Vec::new(), Vec::new());
        for (SimulatedAxis { axis, .. }, readings) in self.axes.iter().zip(readings) {
            let samples = readings.motor.iter().zip(&readings.table);
            if let Some(k) = samples.clone().position(|(m, t)| !(m.is_finite() && t.is_finite())) {
                return Err(MachineError::Unstable { axis: axis.name.clone(), time_s: k as f64 * self.period_s });
            }
            motor.push(readings.motor);
            table.push(readings.table);
        }
        Ok(Run { motor: reference.with_columns(motor)?, table: reference.with_columns(table)? })
    }

    /// Approach, standstill, and the reference. Only the last is kept.
    fn follow(&self, axis: &SimulatedAxis, reference: &[f64], rng: ChaCha8Rng) -> Readings {
        let per_unit = axis.per_unit;
        let first = per_unit * reference.first().copied().unwrap_or(0.0);
        let rise = (APPROACH_S / self.period_s).ceil() as usize;
        let lead_in = rise + (REST_S / self.period_s).ceil() as usize;
        let mut all: Vec<f64> = (0..lead_in)
            .map(|k| {
                let angle = std::f64::consts::PI * k.min(rise) as f64 / rise as f64;
                first - APPROACH * 0.5 * (1.0 + angle.cos())
            })
            .collect();
        all.extend(reference.iter().map(|position| per_unit * position));
        let start = Start { position_mm: first - APPROACH, elapsed_s: self.elapsed_s };
        let drive = Drive::at_rest(&axis.drive, axis.rates, self.options, self.sensor(), start, rng);
        let mut readings = drive.follow(&all, self.period_s);
        for view in [&mut readings.motor, &mut readings.table] {
            view.drain(..lead_in);
            view.iter_mut().for_each(|position| *position /= per_unit);
        }
        readings
    }

    fn check(&self, reference: &Trajectory) -> Result<(), MachineError> {
        let names = |axes: Vec<&Axis>| axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>().join(" ");
        let own: Vec<&Axis> = self.axes.iter().map(|axis| &axis.axis).collect();
        let given: Vec<&Axis> = reference.axes().iter().collect();
        if own != given {
            return Err(MachineError::Misfit(format!("its axes are `{}`, the machine's are `{}`", names(given), names(own))));
        }
        if (reference.period_s() - self.period_s).abs() > 1e-9 * self.period_s {
            return Err(MachineError::Misfit(format!(
                "its period is {} s, the machine's is {} s; resample it",
                reference.period_s(),
                self.period_s
            )));
        }
        if reference.is_empty() {
            return Err(MachineError::Misfit("it has no sample".into()));
        }
        Ok(())
    }
}

impl Machine for SimulatedMachine {
    /// Runs with the next noise of the sequence and returns the readings of the selected sensor.
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        let run = self.run_full(reference)?;
        Ok(match self.sensor() {
            Sensor::Motor => run.motor,
            Sensor::Table => run.table,
        })
    }
}
