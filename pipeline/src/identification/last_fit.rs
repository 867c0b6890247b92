//! The last fit: of the structure that was chosen, on all runs, without what explains nothing.

use machine::MachineSpec;

use super::besides::Addition;
use super::comparison::{Candidate, SAME};
use super::observed::Observed;
use super::parameters::{Parameter, parameters};
use super::search::{Effort, HOPELESS, Search};
use super::structure::Structure;

/// A control with everything that was found of it.
pub(super) struct Fitted<'a> {
    runs: &'a [&'a Observed],
    pub structure: Structure,
    pub parameters: Vec<Parameter>,
    /// Score of the fit before anything was dropped.
    score: f64,
    pub machine: MachineSpec,
}

impl<'a> Fitted<'a> {
    pub fn of(best: &Candidate, runs: &'a [&'a Observed]) -> Self {
        let mut fitted = Self::fit(best.structure, best.machine.clone(), runs);
        let (structure, machine) = best.structure.simplified(fitted.machine.clone());
        if structure != fitted.structure {
            fitted = Self::fit(structure, machine, runs);
        }
        // What explains nothing would still cost time or accuracy in other programs.
        fitted.drop_additions();
        fitted.drop_parameters();
        fitted
    }

    /// The machine of a structure as fitted to runs, with everything that it was compared with.
    pub fn as_compared(candidate: &Candidate, runs: &'a [&'a Observed]) -> MachineSpec {
        Self::fit(candidate.structure, candidate.machine.clone(), runs).machine
    }

    fn fit(structure: Structure, machine: MachineSpec, runs: &'a [&'a Observed]) -> Self {
        let parameters = parameters(structure, &machine);
        let (score, machine) = Search::new(runs, &parameters).best(machine, Effort::LAST, f64::INFINITY);
        Self { runs, structure, parameters, score, machine }
    }

    /// The best machine near another one if it is as good with these parameters.
    fn as_good(&self, machine: MachineSpec, parameters: &[Parameter]) -> Option<MachineSpec> {
        let (score, machine) = Search::new(self.runs, parameters).best(machine, Effort::LAST, HOPELESS * self.score);
        (score <= SAME * self.score).then_some(machine)
    }

    fn drop_additions(&mut self) {
        for addition in Addition::ALL {
            let Some(structure) = addition.from(self.structure) else { continue };
            let machine = structure.applied(&self.machine);
            let parameters = parameters(structure, &machine);
            if let Some(machine) = self.as_good(machine, &parameters) {
                (self.structure, self.parameters, self.machine) = (structure, parameters, machine);
            }
        }
    }

    fn drop_parameters(&mut self) {
        for at in (0..self.parameters.len()).rev() {
            let Some(neutral) = self.parameters[at].neutral() else { continue };
            let mut machine = self.machine.clone();
            self.parameters[at].set(&mut machine, neutral);
            let mut others = self.parameters.clone();
            others.remove(at);
            if let Some(machine) = self.as_good(machine, &others) {
                (self.machine, self.parameters) = (machine, others);
            }
        }
    }
}
