//! Where a program's coordinates lie on the machine.

use std::collections::BTreeMap;

use anyhow::Result;
use gcode::{Toolpath, WorkOffset};
use machine::WORK_SYSTEMS;
use motion::Vec3;

use crate::output::Usage;

/// Work offsets: machine minus program coordinates, mm, as far as they are given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WorkOffsets {
    /// Of every coordinate system that has none of its own.
    all: Option<Vec3>,
    /// By the index of the system's name in [`WORK_SYSTEMS`].
    systems: BTreeMap<usize, Vec3>,
    /// Added to Z of them all, mm.
    tool_length_mm: f64,
}

impl WorkOffsets {
    /// One known offset for every coordinate system, mm.
    #[must_use]
    pub fn at(offset: Vec3) -> Self {
        Self { all: Some(offset), ..Self::default() }
    }

    /// Those that are `given` (with the name of a coordinate system, or for all), else those of the machine file; with the tool's length, mm.
    #[must_use]
    pub fn new(given: &[(Option<&'static str>, [f64; 3])], in_file: &BTreeMap<String, [f64; 3]>, tool_length_mm: f64) -> Self {
        let index = |name: &str| WORK_SYSTEMS.iter().position(|known| *known == name);
        let all = given.iter().rev().find(|(system, _)| system.is_none()).map(|(_, offset)| Vec3::from(*offset));
        let mut systems: BTreeMap<usize, Vec3> = BTreeMap::new();
        // An offset for all on the command line stands above the file's.
        let in_file = in_file.iter().filter(|_| all.is_none()).map(|(name, offset)| (name.as_str(), *offset));
        let given = given.iter().filter_map(|(system, offset)| Some(((*system)?, *offset)));
        systems.extend(in_file.chain(given).filter_map(|(name, offset)| Some((index(name)?, Vec3::from(offset)))));
        Self { all, systems, tool_length_mm }
    }

    /// The same with 0,0,0 for coordinate systems that have none.
    #[must_use]
    pub fn or_zero(self) -> Self {
        Self { all: self.all.or(Some(Vec3::zeros())), ..self }
    }

    /// The offset of the coordinate systems that `toolpath` moves in, mm; `None` where one of them has none.
    ///
    /// # Errors
    /// When they have different ones: a program is planned with one offset.
    pub fn of(&self, toolpath: &Toolpath) -> Result<Option<Vec3>> {
        let mut used: BTreeMap<String, Option<Vec3>> = BTreeMap::new();
        for step in toolpath.moves.iter().filter(|step| step.is_feed()) {
            let system = toolpath.modal(step).work_offset;
            used.entry(name(system)).or_insert_with(|| self.of_system(system));
        }
        let mut known = used.iter().filter_map(|(name, offset)| Some((name, (*offset)?)));
        let first = known.next();
        if let (Some((one, offset)), Some((other, _))) = (first, known.find(|(_, offset)| Some(*offset) != first.map(|(_, o)| o)))
        {
            return Err(Usage(format!(
                "the program cuts in {one} and {other}, whose offsets differ (that of {one} is {} {} {} mm); a program is planned with one: \
                 split it by coordinate system, or give one --work-offset X,Y,Z for all of it",
                offset.x, offset.y, offset.z
            ))
            .into());
        }
        let all_known = used.values().all(Option::is_some);
        Ok(first.filter(|_| all_known).map(|(_, offset)| offset + Vec3::z() * self.tool_length_mm))
    }

    fn of_system(&self, system: WorkOffset) -> Option<Vec3> {
        let own = match system {
            WorkOffset::Standard(number) => self.systems.get(&usize::from(number).checked_sub(1)?).copied(),
            WorkOffset::Extended(_) | WorkOffset::Unpredictable => None,
        };
        own.or(self.all)
    }
}

/// A coordinate system as programs call it.
fn name(system: WorkOffset) -> String {
    match system {
        WorkOffset::Standard(number) => {
            let known = usize::from(number).checked_sub(1).and_then(|index| WORK_SYSTEMS.get(index));
            known.map_or_else(|| format!("coordinate system {number}"), |name| (*name).to_owned())
        }
        WorkOffset::Extended(number) => format!("G54.1 P{number}"),
        WorkOffset::Unpredictable => "G54.1".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use gcode::{Dialect, Options};

    use super::*;

    fn of(offsets: &WorkOffsets, program: &str) -> Result<Option<Vec3>> {
        offsets.of(&gcode::interpret(&gcode::parse(program), &Options::from(Dialect::Fanuc))?)
    }

    const ONE: &str = "G21 G90\nG55\nG0 X0 Y0 Z0\nG1 X10 F600\nM30\n";
    const TWO: &str = "G21 G90\nG54\nG0 X0 Y0 Z0\nG1 X10 F600\nG55\nG0 X0 Y0 Z0\nG1 X10\nM30\n";

    #[test]
    fn the_system_that_a_program_cuts_in_says_its_offset() {
        let file: BTreeMap<String, [f64; 3]> = [("G54".into(), [1.0, 2.0, 3.0]), ("G55".into(), [4.0, 5.0, 6.0])].into();
        let unknown = WorkOffsets::default();
        assert_eq!(of(&unknown, ONE).unwrap(), None);
        assert_eq!(of(&WorkOffsets::new(&[], &file, 0.0), ONE).unwrap(), Some(Vec3::new(4.0, 5.0, 6.0)));
        let given = WorkOffsets::new(&[(Some("G55"), [7.0, 0.0, 0.0])], &file, 2.5);
        assert_eq!(of(&given, ONE).unwrap(), Some(Vec3::new(7.0, 0.0, 2.5)));
        let all = WorkOffsets::new(&[(None, [9.0, 0.0, 0.0])], &file, 0.0);
        assert_eq!(of(&all, ONE).unwrap(), Some(Vec3::new(9.0, 0.0, 0.0)));
    }

    #[test]
    fn two_systems_with_offsets_of_their_own_are_refused() {
        let two = WorkOffsets::new(&[(Some("G54"), [1.0, 0.0, 0.0]), (Some("G55"), [2.0, 0.0, 0.0])], &BTreeMap::new(), 0.0);
        let error = of(&two, TWO).unwrap_err().to_string();
        assert!(error.contains("G54 and G55") && error.contains("split"), "{error}");
        let same = WorkOffsets::new(&[(None, [1.0, 0.0, 0.0])], &BTreeMap::new(), 0.0);
        assert_eq!(of(&same, TWO).unwrap(), Some(Vec3::new(1.0, 0.0, 0.0)));
        let half = WorkOffsets::new(&[(Some("G54"), [1.0, 0.0, 0.0])], &BTreeMap::new(), 0.0);
        assert_eq!(of(&half, TWO).unwrap(), None);
    }
}
