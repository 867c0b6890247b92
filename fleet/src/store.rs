//! The logs of a fleet on disk: `DIR/machine=NAME/date=YYYY-MM-DD/*.parquet`.

use std::path::{Path, PathBuf};

use chrono::NaiveDate;
use diagnosis::Sensor;
use machine::{AxisSpec, MachineSpec};

use crate::error::{FleetError, Result};

/// Beginning of the folder names of machines and of days.
pub(crate) const MACHINE: &str = "machine=";
pub(crate) const DATE: &str = "date=";
/// Name of the machine file that may lie in the folder of a machine.
pub(crate) const MACHINE_FILE: &str = "machine.toml";

/// The folder of a fleet.
#[derive(Debug, Clone)]
pub struct Store {
    root: PathBuf,
}

/// The folder of one machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MachineFolder {
    /// Name of the machine.
    pub name: String,
    /// Its folder.
    pub path: PathBuf,
}

/// The logs of one machine on one day.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Day {
    /// The day as `YYYY-MM-DD`.
    pub date: String,
    /// Its files, by name.
    pub files: Vec<PathBuf>,
}

impl Store {
    /// The fleet in the folder `root`.
    #[must_use]
    pub fn new(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// The machines, by name; only those in `only` where it is not empty.
    ///
    /// # Errors
    /// When the folder cannot be read, holds no machine or lacks one of `only`, or a name cannot be that of a model.
    pub fn machines(&self, only: &[String]) -> Result<Vec<MachineFolder>> {
        let mut all = Vec::new();
        for (name, path) in folders(&self.root, MACHINE)? {
            if !is_name(&name) {
                return Err(FleetError::BadName { path });
            }
            all.push(MachineFolder { name, path });
        }
        if all.is_empty() {
            return Err(FleetError::NoMachine { path: self.root.clone() });
        }
        if let Some(name) = only.iter().find(|name| !all.iter().any(|machine| machine.name == **name)) {
            let known = all.into_iter().map(|machine| machine.name).collect();
            return Err(FleetError::UnknownMachine { path: self.root.clone(), name: name.clone(), known });
        }
        all.retain(|machine| only.is_empty() || only.contains(&machine.name));
        Ok(all)
    }
}

impl MachineFolder {
    /// The days with logs, the oldest first.
    ///
    /// # Errors
    /// When the folder cannot be read, has a day that is no date, or holds no log.
    pub fn days(&self) -> Result<Vec<Day>> {
        let mut days = Vec::new();
        for (date, path) in folders(&self.path, DATE)? {
            if date.len() != 10 || NaiveDate::parse_from_str(&date, "%Y-%m-%d").is_err() {
                return Err(FleetError::BadDate { path, date });
            }
            let mut files = Vec::new();
            for entry in std::fs::read_dir(&path).map_err(FleetError::io(&path))? {
                let file = entry.map_err(FleetError::io(&path))?.path();
                let hidden = file.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
                if !hidden && file.extension().is_some_and(|ending| ending == "parquet") {
                    files.push(file);
                }
            }
            files.sort();
            if !files.is_empty() {
                days.push(Day { date, files });
            }
        }
        if days.is_empty() { Err(FleetError::NoLog { path: self.path.clone() }) } else { Ok(days) }
    }

    /// The machine file in the folder; `None` where there is none.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn description(&self) -> Result<Option<MachineSpec>> {
        let path = self.path.join(MACHINE_FILE);
        let text = match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            read => read.map_err(FleetError::io(&path))?,
        };
        let spec = MachineSpec::from_toml(&text);
        spec.map(Some).map_err(|source| FleetError::MachineFile { path, source: Box::new(source) })
    }
}

/// Where the positions of a machine are measured: as its file says, which leaves it open unless it names a scale or has simulated drives.
pub(crate) fn sensor_of(spec: Option<&MachineSpec>) -> Sensor {
    let is_simulated =
        |spec: &MachineSpec| spec.axes.iter().any(|axis| matches!(axis, AxisSpec::Linear(axis) if axis.drive.is_some()));
    match spec {
        Some(spec) if spec.sensor == machine::Sensor::Table => Sensor::Table,
        Some(spec) if is_simulated(spec) => Sensor::Motor,
        _ => Sensor::Unknown,
    }
}

/// The folders in `path` whose names begin with `key`: what follows it, and the folder, in order.
fn folders(path: &Path, key: &str) -> Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(path).map_err(FleetError::io(path))? {
        let folder = entry.map_err(FleetError::io(path))?.path();
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if let Some(value) = name.strip_prefix(key).filter(|_| folder.is_dir()) {
            found.push((value.to_owned(), folder));
        }
    }
    found.sort();
    Ok(found)
}

/// Whether a file may have this name on every system.
fn is_name(name: &str) -> bool {
    let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.chars().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn machines_and_days_are_found_in_order_and_faults_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| folder.path().join(path);
        let store = Store::new(folder.path());
        assert!(store.machines(&[]).unwrap_err().to_string().contains("machine=NAME"));
        for day in ["machine=b/date=2026-02-01", "machine=b/date=2026-01-31", "machine=a/date=2026-01-01", "other"] {
            std::fs::create_dir_all(at(day)).unwrap();
        }
        for file in ["2026-02-01/2.parquet", "2026-02-01/1.parquet", "2026-01-31/x.parquet", "2026-01-31/.precomp-1.parquet"] {
            std::fs::write(at("machine=b").join(format!("date={file}")), b"").unwrap();
        }
        let machines = store.machines(&[]).unwrap();
        assert_eq!(machines.iter().map(|machine| machine.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        let days = machines[1].days().unwrap();
        assert_eq!(
            days.iter().map(|day| (day.date.as_str(), day.files.len())).collect::<Vec<_>>(),
            [("2026-01-31", 1), ("2026-02-01", 2)]
        );
        assert!(machines[0].days().unwrap_err().to_string().contains("holds no log"));
        assert!(store.machines(&["c".to_owned()]).unwrap_err().to_string().ends_with("its machines are a b"));
        std::fs::create_dir_all(at("machine=a/date=2026-02-30")).unwrap();
        assert!(machines[0].days().unwrap_err().to_string().contains("`2026-02-30` is no date"));
    }
}
