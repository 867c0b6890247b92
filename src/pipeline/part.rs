//! A part program as a planned path.

use std::collections::BTreeMap;

use anyhow::{Result, anyhow, bail};
use gcode::{
    Diagnostic, FeedMode, Fixed, GcodeError, Move, MoveKind, Options, PathMode, Program, Severity, Shiftable, ToolLength,
    Toolpath,
};
use machine::ProgramWords;
use motion::{Limits, MotionError, Plan, PlanSettings, ToolPath, Trajectory, Vec6};

use super::tool_path::{offset_of, pieces, words_of};
use super::{Placement, WorkOffsets};
use crate::input::Frame;

/// A part program, read and planned.
#[derive(Debug)]
pub struct Part {
    /// File name, for messages.
    pub name: String,
    /// The program's bytes, blocks and words.
    pub program: Program,
    /// How it was read.
    pub options: Options,
    /// Its moves.
    pub toolpath: Toolpath,
    /// The path in machine coordinates; program coordinates plus the work offset.
    pub path: ToolPath,
    /// For every piece of the path the move that it stands for; `None` for a way that the program does not state (from a tool
    /// change, from a home position).
    pub owners: Vec<Option<usize>>,
    /// Where its coordinate systems lie on the machine.
    pub placement: Placement,
    /// What its words mean while it does not say so itself.
    pub words: ProgramWords,
    /// What the programmed feed of every move is multiplied by.
    pub feed_factors: Vec<f64>,
    /// How it is planned.
    pub settings: PlanSettings,
    /// Positions over time.
    pub plan: Plan,
    /// Whether compensated stretches state a path mode of their own, in which the control goes on through points that are put in.
    pub states_path: bool,
    /// What the control commanded when it ran the program, one sample each of the plan, where a recorded run says so.
    pub command: Option<Trajectory>,
}

/// Share of the time of all feed moves that may go without a stated time before the program counts as one whose time the control plans.
const UNTIMED: f64 = 0.05;

/// Why a program was not accepted: its faults, rendered with carets.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);

impl Part {
    /// Interprets and plans a program.
    ///
    /// # Errors
    /// [`Refused`] when the program holds a feed move that cannot be predicted, or none at all.
    pub fn read(
        name: &str,
        program: Program,
        options: Option<&Options>,
        offsets: &WorkOffsets,
        frame: &Frame,
        settings: &PlanSettings,
    ) -> Result<Self> {
        let options = options.copied().unwrap_or_else(|| gcode::Dialect::detect(&program).into());
        let toolpath = gcode::interpret(&program, &options).map_err(|error| match error {
            GcodeError::Refused { diagnostics } => anyhow!(Refused(render(&diagnostics, &program, name))),
            other => anyhow!(other),
        })?;
        let placement = offsets.placement(&toolpath);
        let feed_factors = vec![1.0; toolpath.moves.len()];
        let Frame { kinematics, words, limits, .. } = frame;
        let (path, owners) = pieces(&toolpath, &placement, &feed_factors, kinematics.as_ref(), *words)?;
        if !toolpath.moves.iter().any(Move::is_feed) {
            bail!(Refused(format!("{name}: the program has no feed move; there is nothing to plan or to compensate")));
        }
        if owners.is_empty() {
            let axes: Vec<&str> = kinematics.axes().iter().map(|axis| axis.name.as_str()).collect();
            bail!(Refused(format!(
                "{name}: no move of the program moves an axis of the machine ({}); describe the axes that it moves in the machine file",
                axes.join(", ")
            )));
        }
        let plan = motion::plan(&path, kinematics, limits, settings)
            .map_err(|error| on_line(error, &owners, &toolpath, &program, name))?;
        let (name, settings, words) = (name.to_owned(), settings.clone(), *words);
        let (states_path, command) = (false, None);
        Ok(Self {
            name,
            program,
            options,
            toolpath,
            path,
            owners,
            placement,
            words,
            feed_factors,
            settings,
            plan,
            states_path,
            command,
        })
    }

    /// The same program with its feeds multiplied by `factors`, one a move, and planned anew.
    ///
    /// # Errors
    /// When it cannot be planned.
    pub fn with_feeds(self, factors: Vec<f64>, limits: &Limits) -> Result<Self> {
        let kinematics = self.plan.desired.kinematics();
        let (path, owners) = pieces(&self.toolpath, &self.placement, &factors, kinematics.as_ref(), self.words)?;
        let plan = motion::plan(&path, kinematics, limits, &self.settings)
            .map_err(|error| on_line(error, &owners, &self.toolpath, &self.program, &self.name))?;
        Ok(Self { path, owners, plan, feed_factors: factors, command: None, ..self })
    }

    /// What the control commands when it is given `reference`: this, off by as much as in the recorded run, where there is one.
    ///
    /// # Errors
    /// When `reference` does not have the plan's samples.
    pub fn commanded(&self, reference: &Trajectory) -> Result<Trajectory, MotionError> {
        let Some(command) = &self.command else { return Ok(reference.clone()) };
        let shifts = reference.tracking_error(self.plan.desired.trajectory())?;
        let columns = command.columns().iter().zip(shifts);
        command.with_columns(columns.map(|(at, shift)| at.iter().zip(shift).map(|(at, shift)| at + shift).collect()).collect())
    }

    /// The move that a sample of the plan belongs to.
    #[must_use]
    pub fn move_at(&self, sample: usize) -> Option<usize> {
        self.owners.get(self.plan.samples.get(sample)?.piece).copied().flatten()
    }

    /// Whether a sample of the plan belongs to a move that may be compensated.
    #[must_use]
    pub fn shiftable_at(&self, sample: usize) -> bool {
        self.move_at(sample).is_some_and(|index| self.is_shiftable(&self.toolpath.moves[index]))
    }

    /// Whether a move may be compensated: a feed move whose geometry is known; one that turns axes only on a machine whose kinematics says
    /// what that does to the tool.
    #[must_use]
    pub fn is_shiftable(&self, of: &Move) -> bool {
        let turned = of.start.nominal_rotary_rad() != of.end.nominal_rotary_rad();
        // Tip control is about rotary axes: which, a machine without any does not say.
        let tip = self.toolpath.modal(of).tool_length == ToolLength::TipControl;
        let stops_within = self.stops_exactly(of) && matches!(of.kind, MoveKind::Arc(_));
        let known = of.shiftable == Shiftable::Yes && !stops_within;
        known && of.is_feed() && (!(turned || tip) || self.plan.desired.kinematics().turns())
    }

    /// Whether the control stops at the end of every line that stands for a move (G9, G61.1) or goes through it exactly (G61, G64 P0), so that points that are
    /// put in would stop it too.
    #[must_use]
    pub fn stops_exactly(&self, of: &Move) -> bool {
        match self.toolpath.modal(of).path {
            PathMode::ExactStop => true,
            PathMode::ExactPath => !self.states_path,
            PathMode::Continuous { tolerance_mm, .. } => tolerance_mm == Some(0.0) && !self.states_path,
            PathMode::Default => false,
        }
    }

    /// Why moves that cut may not be compensated, each reason with the number of its moves; rapids and dwells are not counted.
    #[must_use]
    pub fn fixed_moves(&self) -> BTreeMap<&'static str, usize> {
        let mut counts = BTreeMap::new();
        let fixed = self.toolpath.moves.iter().filter(|of| !self.is_shiftable(of));
        let why = |of: &Move| match (of.shiftable, of.kind) {
            (Shiftable::Yes, MoveKind::Arc(_)) if self.stops_exactly(of) => {
                Some("arcs at whose points the control would stop (G9, G61, G64 P0)")
            }
            _ => why_fixed(of),
        };
        for why in fixed.filter_map(why) {
            *counts.entry(why).or_default() += 1;
        }
        counts
    }

    /// Share of the length of all feed moves that may not be compensated; turning alone has no length.
    #[must_use]
    pub fn fixed_share(&self) -> f64 {
        let length = |of: &Move| of.length_mm().unwrap_or(0.0);
        let feeds = || self.toolpath.moves.iter().filter(|of| of.is_feed());
        let (all, fixed) =
            (feeds().map(length).sum::<f64>(), feeds().filter(|of| !self.is_shiftable(of)).map(length).sum::<f64>());
        if all > 0.0 { (fixed / all).max(0.0) } else { 0.0 }
    }

    /// Whether feed moves state their time (G93) but for a small share of it, such as an approach.
    #[must_use]
    pub fn states_times(&self) -> bool {
        let moves = (0..self.plan.samples.len()).filter_map(|k| self.move_at(k)).map(|index| &self.toolpath.moves[index]);
        let (mut stated, mut all) = (0, 0);
        for step in moves.filter(|step| step.is_feed()) {
            all += 1;
            stated += usize::from(self.toolpath.modal(step).feed_mode == FeedMode::InverseTime);
        }
        (all - stated) as f64 <= UNTIMED * all as f64
    }

    /// What the words of a move mean.
    #[must_use]
    pub fn words_of(&self, of: &Move) -> ProgramWords {
        words_of(&self.toolpath, of, self.words)
    }

    /// Whether a sample of the plan belongs to a feed move; the nearest one does for a place beyond the ends.
    #[must_use]
    pub fn feeds_at(&self, sample: usize) -> bool {
        let sample = sample.min(self.plan.samples.len().saturating_sub(1));
        self.move_at(sample).is_some_and(|index| self.toolpath.moves[index].is_feed())
    }

    /// Line of the program, from 1, that a sample of the plan belongs to.
    #[must_use]
    pub fn line_at(&self, sample: usize) -> Option<usize> {
        self.move_at(sample).map(|index| self.toolpath.moves[index].block as usize + 1)
    }

    /// Machine minus program coordinates of a move, mm and rad.
    #[must_use]
    pub fn offset_of(&self, of: &Move) -> Vec6 {
        offset_of(&self.placement, &self.toolpath, of)
    }

    /// A refusal of what the plan does at a sample, shown at its line.
    #[must_use]
    pub fn refused_at(&self, sample: usize, what: String) -> anyhow::Error {
        let owner = self.plan.samples.get(sample).and_then(|at| self.owners[at.piece..].iter().flatten().next().copied());
        let Some(owner) = owner else { return anyhow!(Refused(format!("{}: {what}", self.name))) };
        anyhow!(Refused(on_move(&self.toolpath, owner, &self.program, &self.name, what)))
    }

    /// How much of a correction every sample may take: 1 on moves that may be compensated, 0 elsewhere, with a fade over `fade_s` at
    /// both ends of each stretch so that it begins and ends exactly where the program says.
    #[must_use]
    pub fn weights(&self, fade_s: f64) -> Vec<f64> {
        let shiftable: Vec<bool> = (0..self.plan.samples.len()).map(|k| self.shiftable_at(k)).collect();
        eased(&shiftable, fade_s / self.plan.desired.trajectory().period_s())
    }
}

/// Why a move that is not compensated is not; `None` where it does not cut.
fn why_fixed(of: &Move) -> Option<&'static str> {
    Some(match (of.shiftable, of.kind) {
        (_, MoveKind::Rapid | MoveKind::Dwell { .. } | MoveKind::Home) => return None,
        (_, MoveKind::Cycle(_)) | (Shiftable::No(Fixed::Cycle), _) => "in canned cycles",
        (_, MoveKind::Thread | MoveKind::Probe) => "that follow the spindle or a probe",
        (Shiftable::Yes, _) => {
            "that turn axes, or are under tip control, whose effect on the tool the machine description does not state"
        }
        (Shiftable::No(fixed), _) => match fixed {
            Fixed::CutterCompensation => "under cutter compensation (G41, G42)",
            Fixed::MachineCoordinates => "in machine coordinates (G53)",
            Fixed::ToolChange => "in blocks that change the tool",
            Fixed::UnknownStart => "that start where the program does not say",
            Fixed::OptionalBlock => "in blocks that a switch may skip (/)",
            Fixed::Unsplittable => "in blocks with words that act before and words that act after the motion",
            Fixed::NotUnderstood => "after codes whose effect on path or frame is not known",
            Fixed::Rapid | Fixed::Cycle | Fixed::Home | Fixed::Threading | Fixed::Probing | Fixed::Dwell => "of another kind",
        },
    })
}

/// 1 where `open`, 0 elsewhere, with a fade over so many samples at both ends of each open stretch.
#[must_use]
pub(super) fn eased(open: &[bool], fade: f64) -> Vec<f64> {
    let fade = fade.round().max(1.0);
    let mut weights: Vec<f64> = open.iter().map(|open| f64::from(u8::from(*open))).collect();
    let ramp = |weights: &mut [f64], order: &mut dyn Iterator<Item = usize>| {
        let mut inside = 0.0_f64;
        for k in order {
            inside = if weights[k] > 0.0 { inside + 1.0 } else { 0.0 };
            // A raised cosine has no kink at either end; the sample at rest beside another move is not shifted at all.
            let share = 0.5 - 0.5 * (std::f64::consts::PI * ((inside - 1.0) / fade).clamp(0.0, 1.0)).cos();
            weights[k] = weights[k].min(share);
        }
    };
    let n = weights.len();
    ramp(&mut weights, &mut (0..n));
    ramp(&mut weights, &mut (0..n).rev());
    weights
}

/// A fault of the plan, shown at the line that the path's piece stands for.
fn on_line(error: MotionError, owners: &[Option<usize>], toolpath: &Toolpath, program: &Program, name: &str) -> anyhow::Error {
    // A way that the program does not state leads to the move after it.
    let owner = error.piece().and_then(|piece| owners[piece..].iter().flatten().next().copied());
    let Some(owner) = owner else { return error.into() };
    let what = match &error {
        MotionError::UnreachableOnPath { what, .. } => format!("this move cannot be run on the machine: {what}"),
        MotionError::Infeasible { what, .. } => format!("no feed holds the machine's limits in this move: {what}"),
        other => other.to_string(),
    };
    anyhow!(Refused(on_move(toolpath, owner, program, name, what)))
}

/// A fault of a move, with its line and a caret under its first word.
fn on_move(toolpath: &Toolpath, owner: usize, program: &Program, name: &str, what: String) -> String {
    let block = toolpath.moves[owner].block as usize;
    let span = program.block_words(block).first().map_or(program.blocks()[block].span, |word| word.span);
    render(&[Diagnostic::new(program, Severity::Error, span, what)], program, name)
}

/// The program's faults, those that refuse it first, each with its line and a caret under the word. The label of the first one is left to
/// whoever shows the text, as for every other error.
#[must_use]
pub fn render(diagnostics: &[Diagnostic], program: &Program, name: &str) -> String {
    let (errors, others): (Vec<&Diagnostic>, Vec<_>) = diagnostics.iter().partition(|diagnostic| diagnostic.is_error());
    let texts: Vec<String> = errors.into_iter().chain(others).map(|diagnostic| diagnostic.render(program, name)).collect();
    let text = texts.join("\n");
    text.strip_prefix("error: ").unwrap_or(&text).trim_end().to_owned()
}
