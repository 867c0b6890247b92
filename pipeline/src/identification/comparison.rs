//! Comparison of structures of a control on runs.

use machine::MachineSpec;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::progress::Steps;

use super::besides::Addition;
use super::fidelity::Fidelity;
use super::observed::Observed;
use super::parameters::parameters;
use super::search::{Effort, HOPELESS, Search};
use super::structure::{Besides, CORNERS, Corners, FirstCorners, SHAPES, Shape, Structure};

/// Agreements that differ by less are equally good, and the one with fewer parameters is taken.
pub(super) const SAME: f64 = 1.05;
/// Largest number of rounds over corners and shapes.
const ROUNDS: usize = 4;
/// Share of the score on some run that may be left, and the least difference on all, at which an addition is kept. A score of 1 is what a
/// forecast just stands.
const LEFT: f64 = 0.5;
const GAIN: f64 = 0.1;
/// Share of the score up to which an addition that is not kept gets a thorough fit, as the structure itself does.
const HOPEFUL: f64 = 0.8;
/// Scores within this factor of the best one are looked at once more.
const NEAR: f64 = 1.1;
/// Score on fitted and held-out runs together below which no structure is looked at once more.
const GOOD: f64 = 0.8;

/// A structure with its parameters.
pub(super) struct Candidate {
    pub structure: Structure,
    pub machine: MachineSpec,
    /// Score on the runs of the fit.
    fit: f64,
    /// On the runs that were held out.
    pub fidelity: Fidelity,
}

impl Candidate {
    /// On held-out runs and on those of the fit: the former alone may hold too few corners to tell structures apart.
    pub fn score(&self) -> f64 {
        self.fidelity.score() + self.fit
    }
}

/// Structures fitted to some runs and judged on others.
pub(super) struct Comparison<'a> {
    fitted: &'a [&'a Observed],
    held_out: &'a [&'a Observed],
    first_corners: FirstCorners,
    steps: Steps<'a>,
    tried: Vec<Candidate>,
}

impl<'a> Comparison<'a> {
    pub fn new(fitted: &'a [&'a Observed], held_out: &'a [&'a Observed], first_corners: FirstCorners, steps: Steps<'a>) -> Self {
        Self { fitted, held_out, first_corners, steps, tried: Vec::new() }
    }

    /// Compares shapes from the values of `start`, then corners and shapes in turn, then what a control may do besides, and with that both
    /// once more.
    ///
    /// # Errors
    /// When the progress cancels.
    pub fn run(&mut self, start: &MachineSpec) -> Result<()> {
        let structure = |shape: Shape| Structure { shape, corners: CORNERS[0], besides: Besides::default() };
        self.try_all(SHAPES.map(|shape| (structure(shape), start.clone())).to_vec(), Effort::FIRST)?;
        self.alternate()?;
        while self.add()? {
            self.alternate()?;
        }
        let best = self.best()?;
        if best.score() < GOOD {
            return Ok(());
        }
        let near = |candidate: &&Candidate| candidate.score() <= NEAR * best.score();
        let near = self.tried.iter().filter(near).map(|candidate| (candidate.structure, candidate.machine.clone())).collect();
        self.try_all(near, Effort::THOROUGH)
    }

    /// The candidates, best first.
    pub fn sorted(mut self) -> Vec<Candidate> {
        self.tried.sort_by(|a, b| a.score().total_cmp(&b.score()));
        self.tried
    }

    /// Compares corners and shapes in turn, and once more where the best structure comes out otherwise without hidden limits.
    fn alternate(&mut self) -> Result<()> {
        self.take_turns()?;
        if self.uncover()? {
            self.take_turns()?;
        }
        Ok(())
    }

    /// The best shape decides on the corners, and these once more on the shape, until neither changes.
    fn take_turns(&mut self) -> Result<()> {
        for round in 0..ROUNDS {
            let best = self.best()?;
            let (structure, from) = (best.structure, best.machine.clone());
            let others: Vec<Structure> = match round % 2 {
                0 => CORNERS.iter().map(|corners| Structure { corners: *corners, ..structure }).collect(),
                _ => SHAPES.iter().map(|shape| Structure { shape: *shape, ..structure }).collect(),
            };
            // The first round also fits the structure itself on, which may be known from a first look only.
            let others = others.into_iter().filter(|other| (round == 0 || *other != structure) && other.is_possible());
            let effort = if round == 0 { Effort::CORNERS } else { Effort::COMPARING };
            self.try_all(others.map(|other| (other, from.clone())).collect(), effort)?;
            if round > 0 && self.best()?.structure == structure {
                break;
            }
        }
        Ok(())
    }

    /// Looks for limits that others hide in the best structure with each rule of corners. Whether the best one is clearly better then.
    fn uncover(&mut self) -> Result<bool> {
        let score = self.best()?.score();
        if score < GOOD {
            return Ok(false);
        }
        let of = |corners: &Corners| best(self.tried.iter().filter(|candidate| candidate.structure.corners == *corners));
        let near = CORNERS.iter().filter_map(of).filter(|candidate| candidate.score() <= HOPELESS * score);
        let near = near.map(|candidate| (candidate.structure, candidate.machine.clone())).collect();
        self.try_all(near, Effort::THOROUGH)?;
        Ok(SAME * self.best()?.score() < score)
    }

    /// Adds what a control may do besides, the best of all additions, if it is clearly better: only some runs may show it. Whether it was.
    fn add(&mut self) -> Result<bool> {
        let best = simplest(&self.tried).ok_or(Error::NoLog)?;
        let structure = best.structure;
        let with = |addition: Addition| {
            let other = addition.to(structure)?;
            Some((other, addition.first(other, &best.machine, best.fit, self.fitted)?))
        };
        // The structure itself goes on as well: what more steps gain is no merit of an addition.
        let itself = std::iter::once((structure, best.machine.clone()));
        self.try_all(itself.chain(Addition::ALL.into_iter().filter_map(with)).collect(), Effort::COMPARING)?;
        if !self.is_kept(structure)? && self.best()?.score() < HOPEFUL * self.known(structure).map_or(0.0, Candidate::score) {
            let both = [structure, self.best()?.structure].into_iter().filter_map(|structure| self.known(structure));
            self.try_all(both.map(|candidate| (candidate.structure, candidate.machine.clone())).collect(), Effort::THOROUGH)?;
        }
        let is_better = self.is_kept(structure)?;
        if !is_better {
            self.tried.retain(|candidate| candidate.structure.besides == structure.besides);
        }
        Ok(is_better)
    }

    /// Whether what the best candidate adds to `structure` is worth a number more.
    fn is_kept(&self, structure: Structure) -> Result<bool> {
        let (itself, best) = (self.known(structure).ok_or(Error::NoLog)?, self.best()?);
        let shows = |run: &&Observed| {
            let [without, with] = [itself, best].map(|candidate| Fidelity::of(&candidate.machine, &[*run]).score());
            with < LEFT * without
        };
        Ok(best.score() < itself.score() - GAIN && self.fitted.iter().chain(self.held_out).any(shows))
    }

    fn best(&self) -> Result<&Candidate> {
        best(self.tried.iter()).ok_or(Error::NoLog)
    }

    fn known(&self, structure: Structure) -> Option<&Candidate> {
        self.tried.iter().find(|candidate| candidate.structure == structure)
    }

    /// Fits structures side by side, each from the values of another machine or from its own of before, whichever are better. A fit ends
    /// early where its score stays far above the best one known before.
    fn try_all(&mut self, structures: Vec<(Structure, MachineSpec)>, effort: Effort) -> Result<()> {
        let hopeless = effort.hopeless * self.tried.iter().map(|other| other.fit).fold(f64::INFINITY, f64::min);
        let fitted = |(structure, from): (Structure, MachineSpec)| {
            let (applied, known) = (structure.applied_from(&from, self.first_corners), self.known(structure));
            let is_known_better = known.is_some_and(|known| known.fit < Fidelity::of(&applied, self.fitted).score());
            let first = known.filter(|_| is_known_better).map_or(applied, |known| known.machine.clone());
            let parameters = parameters(structure, &first);
            let (fit, machine) = Search::new(self.fitted, &parameters).best(first, effort, hopeless);
            self.steps.step(&structure.to_string())?;
            Ok(Candidate { structure, fit, fidelity: Fidelity::of(&machine, self.held_out), machine })
        };
        let candidates: Vec<Candidate> = structures.into_par_iter().map(fitted).collect::<Result<_>>()?;
        for candidate in candidates {
            match self.tried.iter_mut().find(|known| known.structure == candidate.structure) {
                Some(known) if known.fit <= candidate.fit => {}
                Some(known) => *known = candidate,
                None => self.tried.push(candidate),
            }
        }
        Ok(())
    }
}

fn best<'a>(candidates: impl Iterator<Item = &'a Candidate>) -> Option<&'a Candidate> {
    candidates.min_by(|a, b| a.score().total_cmp(&b.score()))
}

/// The candidate with fewest parameters of those that are as good as the best one.
pub(super) fn simplest(tried: &[Candidate]) -> Option<&Candidate> {
    let least = tried.iter().map(Candidate::score).fold(f64::INFINITY, f64::min);
    let near = tried.iter().filter(|candidate| candidate.score() <= SAME * least);
    near.min_by_key(|candidate| parameters(candidate.structure, &candidate.machine).len())
}
