//! Axes that a program moves and a machine lacks.

use gcode::{Diagnostic, Move, Program, Severity};
use motion::{Axis, Kinematics};

/// Travel of a move from which on it moves an axis, mm.
const STILL_MM: f64 = 1e-6;
/// Names of the linear axes.
const NAMES: [&str; 3] = ["X", "Y", "Z"];

/// Linear axes that are none of a machine's, with the first feed move along each.
pub(crate) struct MissingAxes {
    is_missing: [bool; 3],
    /// Block of the first feed move along the axis.
    first: [Option<usize>; 3],
}

impl MissingAxes {
    pub(crate) fn of(kinematics: &dyn Kinematics) -> Self {
        let has = |slot: usize| kinematics.axes().iter().filter_map(Axis::slot).any(|own| own == slot);
        Self { is_missing: std::array::from_fn(|slot| !has(slot)), first: [None; 3] }
    }

    pub(crate) fn note(&mut self, step: &Move) {
        let Some(block) = step.is_feed().then_some(step.block as usize) else { return };
        let (start, end) = (step.start.nominal_mm(), step.end.nominal_mm());
        for slot in (0..3).filter(|slot| self.is_missing[*slot]) {
            if (end[slot] - start[slot]).abs() > STILL_MM {
                self.first[slot] = self.first[slot].or(Some(block));
            }
        }
    }

    /// One warning for each of them that the program moves.
    pub(crate) fn warnings(&self, program: &Program) -> Vec<Diagnostic> {
        let moved = NAMES.iter().zip(self.first).filter_map(|(name, block)| Some((name, block?)));
        let warning = |(name, block): (&&str, usize)| {
            let words = program.block_words(block);
            let word = words.iter().find(|word| word.is(name.as_bytes()[0])).or(words.first());
            let span = word.map_or(program.blocks()[block].span, |word| word.span);
            let message = format!(
                "axis {name} moves here, and model or machine have no such axis: its errors are neither forecast nor corrected, and no figure \
                 counts them"
            );
            Diagnostic::new(program, Severity::Warning, span, message)
                .with_help(
                    "train with logs in which all axes of the program move, under their names in programs: --columns x_ref=NAME,x_act=NAME states them",
                )
        };
        moved.map(warning).collect()
    }
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use crate::{Part, ReadSettings, Setup};

    #[test]
    fn an_axis_that_the_program_moves_and_the_machine_lacks_is_named_once() {
        let mut spec = MachineSpec::builtin("ballscrew").unwrap();
        let read = |spec: &MachineSpec, text: &str| {
            let setup = Setup::new(spec, None).unwrap();
            let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
            Part::read("part.nc", text, &setup, &settings).unwrap().toolpath.warnings
        };
        let text = "G21 G90 G94\nG0 X0 Y0 Z5.\nG1 Z0 F600\nY9.\nG1 X4. Y1.\nX9.\nM30\n";
        assert_eq!(read(&spec, text), []);
        spec.axes.remove(0);
        let found = read(&spec, text);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].line, found[0].column), (5, 4), "{found:?}");
        assert!(found[0].message.starts_with("axis X moves here"), "{found:?}");
        assert_eq!(read(&spec, "G21 G90 G94\nG0 X5. Y0 Z5.\nG1 Z0 F600\nY9.\nM30\n"), [], "a rapid cuts nothing");
    }
}
