//! Where a program's coordinates lie on the machine.

use std::collections::BTreeMap;

use gcode::{Toolpath, WorkOffset};
use machine::WORK_SYSTEMS;
use motion::Vec3;

/// A work offset: the coordinate system that it is of, if not of all, and machine minus program coordinates, mm.
pub type GivenOffset = (Option<&'static str>, [f64; 3]);

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
    /// Those that are `given` (with the name of a coordinate system, or for all), else those of the machine file; with the tool's length, mm.
    #[must_use]
    pub fn new(given: &[GivenOffset], in_file: &BTreeMap<String, [f64; 3]>, tool_length_mm: f64) -> Self {
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

    /// Where the coordinate systems that `toolpath` cuts in lie.
    #[must_use]
    pub fn placement(&self, toolpath: &Toolpath) -> Placement {
        let cuts = toolpath.moves.iter().filter(|step| step.is_feed());
        let systems: Vec<WorkOffset> = cuts.map(|step| toolpath.modal(step).work_offset).collect();
        let known = !systems.is_empty() && systems.iter().all(|system| self.of(*system).is_some());
        let mut placement = Placement { offsets: if known { self.clone() } else { Self::default() }, known, several: false };
        placement.several = systems.windows(2).any(|pair| placement.of(pair[0]) != placement.of(pair[1]));
        placement
    }

    /// The offset of a coordinate system with the tool's length, mm.
    fn of(&self, system: WorkOffset) -> Option<Vec3> {
        let own = match system {
            WorkOffset::Standard(number) => {
                usize::from(number).checked_sub(1).and_then(|index| self.systems.get(&index).copied())
            }
            WorkOffset::Extended(_) | WorkOffset::Unpredictable => None,
        };
        own.or(self.all).map(|offset| offset + Vec3::z() * self.tool_length_mm)
    }
}

/// Where the coordinate systems that a program cuts in lie on the machine: machine minus program coordinates, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    offsets: WorkOffsets,
    known: bool,
    several: bool,
}

impl Placement {
    /// The offset of a coordinate system, mm; zero for all of them while one that the program cuts in is not known.
    #[must_use]
    pub fn of(&self, system: WorkOffset) -> Vec3 {
        self.offsets.of(system).unwrap_or_default()
    }

    /// Whether the offset of every system that the program cuts in is known.
    #[must_use]
    pub fn known(&self) -> bool {
        self.known
    }

    /// Whether the program cuts in systems whose offsets differ.
    #[must_use]
    pub fn several(&self) -> bool {
        self.several
    }

    /// What says the same of another reading of the program.
    #[must_use]
    pub fn offsets(&self) -> &WorkOffsets {
        &self.offsets
    }

    /// All of it farther by `way`, mm, which a log of the program tells; `known` from then on unless said otherwise.
    #[must_use]
    pub fn moved(mut self, way: Vec3, known: bool) -> Self {
        if known {
            let all = if self.known { self.offsets.all } else { Some(Vec3::zeros()) };
            self.offsets.all = all.map(|offset| offset + way);
            self.offsets.systems.values_mut().for_each(|offset| *offset += way);
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
    fn the_system_that_a_program_cuts_in_says_its_offset() {
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
    fn two_systems_lie_each_at_its_own_place() {
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
