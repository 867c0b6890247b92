//! Simulated fleets: random machines, each with logs of excitation on every day.

use std::path::Path;

use chrono::{Days, NaiveDate};
use machine::MachineSpec;
use pipeline::excitation::{TRAVEL_MM, record};

use crate::error::{FleetError, Result};
use crate::fault::Fault;
use crate::store::{DATE, MACHINE, MACHINE_FILE};

/// Sampling period of the logs, ms.
const PERIOD_MS: f64 = 2.0;
/// Seeds of a machine's days lie so far from those of the next machine.
const SEEDS: u64 = 1_000_003;

/// A fleet to be simulated.
#[derive(Debug, Clone)]
pub struct SimulatedFleet {
    /// Number of machines: the random machines with the seeds from `seed` on.
    pub machines: usize,
    /// Minutes of motion of a machine a day.
    pub minutes: f64,
    /// Number of days.
    pub days: usize,
    /// The first day.
    pub first: NaiveDate,
    /// Seed of the first machine; motion and noise differ from day to day.
    pub seed: u64,
    /// Faults.
    pub faults: Vec<Fault>,
}

/// Name of the random machine of a seed.
#[must_use]
pub fn machine_name(seed: u64) -> String {
    format!("random-{seed}")
}

impl SimulatedFleet {
    /// Checks that nothing in `root` would be overwritten and that every fault can be.
    ///
    /// # Errors
    /// When the folder of a machine is there, or a fault names a machine, axis or day that the fleet lacks.
    pub fn check(&self, root: &Path) -> Result<()> {
        for index in 0..self.machines {
            let path = root.join(format!("{MACHINE}{}", machine_name(self.seed_of(index))));
            if path.exists() {
                return Err(FleetError::Exists { path });
            }
        }
        for fault in &self.faults {
            if fault.machine > self.machines || fault.day > self.days {
                let reason = format!("the fleet has {} machines and {} days", self.machines, self.days);
                return Err(FleetError::Fault { fault: fault.to_string(), reason });
            }
            fault.apply(&mut self.description(fault.machine - 1)?)?;
        }
        Ok(())
    }

    fn seed_of(&self, index: usize) -> u64 {
        self.seed.wrapping_add(index as u64)
    }

    /// The healthy machine with this index, from 0: the random machine, logged at 500 Hz.
    ///
    /// # Errors
    /// When no stable machine has this seed; no such seed is known.
    pub fn description(&self, index: usize) -> Result<MachineSpec> {
        let spec = MachineSpec::random(self.seed_of(index)).map_err(|error| Box::new(pipeline::Error::from(error)))?;
        Ok(MachineSpec { sampling_period_ms: PERIOD_MS, ..spec })
    }

    /// Writes the machine file and the logs of all days of a machine into `root`, the day last that is last. `at` is told every day before it.
    ///
    /// # Errors
    /// When a day cannot be simulated or a file cannot be written.
    pub fn write_machine(&self, root: &Path, index: usize, at: &mut dyn FnMut(&str)) -> Result<()> {
        let healthy = self.description(index)?;
        let folder = root.join(format!("{MACHINE}{}", machine_name(self.seed_of(index))));
        let text = healthy.to_toml().map_err(|error| Box::new(pipeline::Error::from(error)))?;
        datasets::write_all(&[(folder.join(MACHINE_FILE), text.into_bytes())])?;
        for day in 0..self.days {
            let date = self.first.checked_add_days(Days::new(day as u64)).unwrap_or(self.first).to_string();
            at(&date);
            let mut spec = healthy.clone();
            for fault in self.faults.iter().filter(|fault| fault.machine == index + 1 && fault.day <= day + 1) {
                fault.apply(&mut spec)?;
            }
            let seed = self.seed_of(index).wrapping_mul(SEEDS).wrapping_add(day as u64);
            let folder = folder.join(format!("{DATE}{date}"));
            let mut files = Vec::new();
            for log in record(&spec, 60.0 * self.minutes, TRAVEL_MM, seed).map_err(Box::new)? {
                let path = folder.join(format!("{}.parquet", log.name));
                let content = datasets::log_content(&path, &log)?;
                files.push((path, content));
            }
            datasets::write_all(&files)?;
        }
        Ok(())
    }
}
