//! Work offsets: position of the program's coordinate systems on the machine.

use std::collections::BTreeMap;

use gcode::{Toolpath, WorkOffset};
use machine::WORK_SYSTEMS;
use motion::Vec3;

/// A work offset: its coordinate system (`None` for all), and machine minus program coordinates, mm.
pub type GivenOffset = (Option<&'static str>, [f64; 3]);

/// Known work offsets, machine minus program coordinates, mm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WorkOffsets {
    /// Offset of every coordinate system without one of its own.
    all: Option<Vec3>,
    /// Offsets by index of the system's name in [`WORK_SYSTEMS`].
    systems: BTreeMap<usize, Vec3>,
    /// Tool length, added to Z of every offset, mm.
    tool_length_mm: f64,
}

impl WorkOffsets {
    /// Offsets that are `given`, else those of the machine file, plus the tool length, mm. A later entry replaces an
    /// earlier one.
    #[must_use]
    pub fn new(given: &[GivenOffset], in_file: &BTreeMap<String, [f64; 3]>, tool_length_mm: f64) -> Self {
        let index = |name: &str| WORK_SYSTEMS.iter().position(|known| *known == name);
        let all = given.iter().rev().find(|(system, _)| system.is_none()).map(|(_, offset)| Vec3::from(*offset));
        let mut systems: BTreeMap<usize, Vec3> = BTreeMap::new();
        // A given offset for all systems replaces those of the file.
        let in_file = in_file.iter().filter(|_| all.is_none()).map(|(name, offset)| (name.as_str(), *offset));
        let given = given.iter().filter_map(|(system, offset)| Some(((*system)?, *offset)));
        systems.extend(in_file.chain(given).filter_map(|(name, offset)| Some((index(name)?, Vec3::from(offset)))));
        Self { all, systems, tool_length_mm }
    }

    /// The same offsets, with 0,0,0 for systems without one.
    #[must_use]
    pub fn or_zero(self) -> Self {
        Self { all: self.all.or(Some(Vec3::zeros())), ..self }
    }

    /// Placement of the coordinate systems in which `toolpath` has feed moves.
    #[must_use]
    pub fn placement(&self, toolpath: &Toolpath) -> Placement {
        let cuts = toolpath.moves.iter().filter(|step| step.is_feed());
        self.placement_of(&cuts.map(|step| toolpath.modal(step).work_offset).collect::<Vec<WorkOffset>>())
    }

    /// The same for coordinate systems in which feed moves are.
    #[must_use]
    pub fn placement_of(&self, systems: &[WorkOffset]) -> Placement {
        let known = !systems.is_empty() && systems.iter().all(|system| self.of(*system).is_some());
        let mut placement = Placement { offsets: if known { self.clone() } else { Self::default() }, known, several: false };
        placement.several = systems.windows(2).any(|pair| placement.of(pair[0]) != placement.of(pair[1]));
        placement
    }

    /// Offset of a coordinate system including the tool length, mm.
    pub(super) fn of(&self, system: WorkOffset) -> Option<Vec3> {
        let own = match system {
            WorkOffset::Standard(number) => {
                usize::from(number).checked_sub(1).and_then(|index| self.systems.get(&index).copied())
            }
            WorkOffset::Extended(_) | WorkOffset::Unpredictable => None,
        };
        own.or(self.all).map(|offset| offset + Vec3::z() * self.tool_length_mm)
    }
}

/// Offsets of the coordinate systems in which a program cuts, machine minus program coordinates, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    offsets: WorkOffsets,
    known: bool,
    several: bool,
}

impl Placement {
    /// Offset of a coordinate system, mm. All offsets are zero while that of any system in which the program cuts is
    /// unknown.
    #[must_use]
    pub fn of(&self, system: WorkOffset) -> Vec3 {
        self.offsets.of(system).unwrap_or_default()
    }

    /// Whether the offsets of all systems in which the program cuts are known.
    #[must_use]
    pub fn known(&self) -> bool {
        self.known
    }

    /// Whether the program cuts in systems with different offsets.
    #[must_use]
    pub fn several(&self) -> bool {
        self.several
    }

    /// The offsets, for another version of the program.
    #[must_use]
    pub fn offsets(&self) -> &WorkOffsets {
        &self.offsets
    }

    /// Adds `by`, mm, an offset found in a log of the program. With `known` the placement counts as known afterwards;
    /// without it nothing changes.
    #[must_use]
    pub fn moved(mut self, by: Vec3, known: bool) -> Self {
        if known {
            let all = if self.known { self.offsets.all } else { Some(Vec3::zeros()) };
            self.offsets.all = all.map(|offset| offset + by);
            self.offsets.systems.values_mut().for_each(|offset| *offset += by);
            self.known = true;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use gcode::{Dialect, Options};

    use super::*;

    fn placed(offsets: &WorkOffsets, program: &str) -> Placement {
        offsets.placement(&gcode::interpret(&gcode::parse(program), &Options::from(Dialect::Fanuc)).unwrap())
    }

    fn known(offsets: &WorkOffsets, program: &str) -> Option<Vec3> {
        let placement = placed(offsets, program);
        placement.known().then(|| placement.of(G55))
    }

    const G54: WorkOffset = WorkOffset::Standard(1);
    const G55: WorkOffset = WorkOffset::Standard(2);
    const ONE: &str = "G21 G90\nG55\nG0 X0 Y0 Z0\nG1 X10 F600\nM30\n";
    const TWO: &str = "G21 G90\nG54\nG0 X0 Y0 Z0\nG1 X10 F600\nG55\nG0 X0 Y0 Z0\nG1 X10\nM30\n";

    #[test]
    fn the_offset_is_that_of_the_system_in_which_the_program_cuts() {
        let file: BTreeMap<String, [f64; 3]> = [("G54".into(), [1.0, 2.0, 3.0]), ("G55".into(), [4.0, 5.0, 6.0])].into();
        let unknown = WorkOffsets::default();
        assert_eq!(known(&unknown, ONE), None);
        assert_eq!(known(&WorkOffsets::new(&[], &file, 0.0), ONE), Some(Vec3::new(4.0, 5.0, 6.0)));
        let given = WorkOffsets::new(&[(Some("G55"), [7.0, 0.0, 0.0])], &file, 2.5);
        assert_eq!(known(&given, ONE), Some(Vec3::new(7.0, 0.0, 2.5)));
        let all = WorkOffsets::new(&[(None, [9.0, 0.0, 0.0])], &file, 0.0);
        assert_eq!(known(&all, ONE), Some(Vec3::new(9.0, 0.0, 0.0)));
    }

    #[test]
    fn two_systems_have_offsets_of_their_own() {
        let two = WorkOffsets::new(&[(Some("G54"), [1.0, 0.0, 0.0]), (Some("G55"), [2.0, 0.0, 0.0])], &BTreeMap::new(), 0.0);
        let placement = placed(&two, TWO);
        assert!(placement.known() && placement.several());
        assert_eq!([G54, G55].map(|system| placement.of(system).x), [1.0, 2.0]);
        let moved = placement.moved(Vec3::new(0.5, 0.0, 0.0), true);
        assert_eq!([G54, G55].map(|system| moved.of(system).x), [1.5, 2.5]);
        let same = WorkOffsets::new(&[(None, [1.0, 0.0, 0.0])], &BTreeMap::new(), 0.0);
        assert!(placed(&same, TWO).known() && !placed(&same, TWO).several());
        let half = WorkOffsets::new(&[(Some("G54"), [1.0, 0.0, 0.0])], &BTreeMap::new(), 0.0);
        let placement = placed(&half, TWO);
        assert!(!placement.known() && placement.of(G54) == Vec3::zeros());
        assert_eq!(placement.moved(Vec3::x(), true).of(G55), Vec3::x());
    }
}
