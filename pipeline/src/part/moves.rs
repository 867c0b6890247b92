//! What the moves of a part are, and the samples of its plan: which may be compensated, and what their lines state.

use gcode::{Dialect, Distance, FeedMode, Language, Move, MoveKind, PathMode, Shiftable, ToolLength};
use machine::ProgramWords;
use motion::Vec6;

use super::faults::on_move;
use super::taper::taper;
use super::tool_path::{offset_of, words_of};
use super::{Part, TAPER_S, named_axes, turns_at_feed};
use crate::error::Error;

/// Largest share of the feed-move time without inverse time at which a program still counts as one that states its
/// times.
const UNTIMED_SHARE: f64 = 0.05;

impl Part {
    /// Whether moves that may be compensated are stated as increments (G91).
    #[must_use]
    pub fn shifts_increments(&self) -> bool {
        let is_increment = |of: &Move| self.toolpath.modal(of).distance == Distance::Incremental && self.is_shiftable(of);
        self.toolpath.moves.iter().any(is_increment)
    }

    /// Whether blocks that run several times or perhaps lie between two moves. Lines of one segment must not reach over them.
    #[must_use]
    pub fn is_interrupted(&self, before: usize, after: usize) -> bool {
        self.toolpath.moves.get(before + 1..=after).is_some_and(|moves| moves.iter().any(|of| of.after_shared))
    }

    /// Index of the move at a sample of the plan; `None` where the program states none.
    #[must_use]
    pub fn move_at(&self, sample: usize) -> Option<usize> {
        self.owners.get(self.plan.samples.get(sample)?.piece).copied().flatten()
    }

    /// Whether a sample of the plan belongs to a move that may be compensated.
    #[must_use]
    pub fn shiftable_at(&self, sample: usize) -> bool {
        self.move_at(sample).is_some_and(|index| self.is_shiftable(&self.toolpath.moves[index]))
    }

    /// Whether a move may be compensated: a feed move of known geometry. A move of rotary axes also needs a machine
    /// whose kinematics include them. A move whose feed is that of the rotary axes is none, unless its lines state their times: shifted by a
    /// micrometre along a linear axis, its feed would be that of the linear axes, and the rotary axes would turn as fast as they can.
    #[must_use]
    pub fn is_shiftable(&self, of: &Move) -> bool {
        let turned = of.start.nominal_rotary_rad() != of.end.nominal_rotary_rad();
        // Tip control concerns rotary axes. The description of a machine without rotary axes does not state their
        // effect.
        let tip = self.toolpath.modal(of).tool_length == ToolLength::TipControl;
        let stops_within = self.stops_exactly(of) && matches!(of.kind, MoveKind::Arc(_));
        let known = of.shiftable == Shiftable::Yes && !stops_within && (self.states_line_times || !turns_at_feed(of));
        let known = known && !self.has_time_of_radius(of);
        known && of.is_feed() && (!(turned || tip) || self.plan.desired.kinematics().has_rotary_axes())
    }

    /// Whether the F of a move is an inverse time that may be that of its radius: in an arc under G93, Fanuc's controls move at F times the radius
    /// (B-62764EN, inverse time feed), others take 1/F minutes.
    #[must_use]
    pub fn has_time_of_radius(&self, of: &Move) -> bool {
        self.counts_by_radius()
            && matches!(of.kind, MoveKind::Arc(_))
            && self.toolpath.modal(of).feed_mode == FeedMode::InverseTime
    }

    /// Whether the control may count the inverse time of arcs by their radius.
    #[must_use]
    pub fn counts_by_radius(&self) -> bool {
        self.options.dialect == Dialect::Fanuc && self.program.language() == Language::Rs274
    }

    /// Whether the control stops at the end of every line of a move (G9, G61.1) or passes it exactly (G61, G64 P0).
    /// Added points would then become stops too.
    #[must_use]
    pub fn stops_exactly(&self, of: &Move) -> bool {
        match self.toolpath.modal(of).path {
            PathMode::ExactStop => true,
            PathMode::ExactPath => !self.states_path,
            PathMode::Continuous { tolerance_mm, .. } => tolerance_mm == Some(0.0) && !self.states_path,
            PathMode::Default => false,
        }
    }

    /// Whether a segment can state a path tolerance of its own (LinuxCNC: `G64 P… Q…`).
    #[must_use]
    pub fn has_path_tolerance(&self) -> bool {
        self.options.dialect == Dialect::LinuxCnc && self.program.language() == Language::Rs274
    }

    /// Whether feed moves state their times (G93), except for a small share such as an approach.
    #[must_use]
    pub fn states_times(&self) -> bool {
        let moves = (0..self.plan.samples.len()).filter_map(|k| self.move_at(k)).map(|index| &self.toolpath.moves[index]);
        let (mut stated, mut all) = (0, 0);
        for step in moves.filter(|step| step.is_feed()) {
            all += 1;
            stated += usize::from(self.toolpath.modal(step).feed_mode == FeedMode::InverseTime);
        }
        (all - stated) as f64 <= UNTIMED_SHARE * all as f64
    }

    /// Meaning of the words of a move.
    #[must_use]
    pub fn words_of(&self, of: &Move) -> ProgramWords {
        words_of(&self.toolpath, of, self.words)
    }

    /// Which of X, Y, Z, A, B, C the program names anywhere. The position of the others is not known in program coordinates, so that no
    /// block may state them.
    #[must_use]
    pub fn named_axes(&self) -> [bool; 6] {
        self.section.as_ref().map_or_else(|| named_axes(&self.program), |section| section.whole.named_axes)
    }

    /// Whether a sample of the plan belongs to a feed move. A sample index beyond the end counts as the last sample.
    #[must_use]
    pub fn feeds_at(&self, sample: usize) -> bool {
        let sample = sample.min(self.plan.samples.len().saturating_sub(1));
        self.move_at(sample).is_some_and(|index| self.toolpath.moves[index].is_feed())
    }

    /// Program line, from 1, of a sample of the plan.
    #[must_use]
    pub fn line_at(&self, sample: usize) -> Option<usize> {
        self.move_at(sample).map(|index| self.toolpath.moves[index].block as usize + 1)
    }

    /// Work offset of a move, machine minus program coordinates, mm and rad.
    #[must_use]
    pub fn offset_of(&self, of: &Move) -> Vec6 {
        offset_of(&self.placement, &self.toolpath, of)
    }

    /// Error for a sample of the plan, reported at its program line.
    #[must_use]
    pub fn refused_at(&self, sample: usize, what: String) -> Error {
        let owner = self.plan.samples.get(sample).and_then(|at| self.owners[at.piece..].iter().flatten().next().copied());
        match owner {
            Some(owner) => on_move(&self.toolpath, owner, &self.program, &self.name, what),
            None => Error::Program { diagnostics: Vec::new(), text: format!("{}: {what}", self.name) },
        }
    }

    /// Taper of the correction, one weight a sample: 1 on moves that may be compensated, 0 elsewhere. Each segment
    /// fades in and out over [`TAPER_S`], so that its ends are those of the program. Segments end at every
    /// [border](Self::borders).
    #[must_use]
    pub fn taper(&self) -> Vec<f64> {
        let segments: Vec<usize> = self
            .borders()
            .iter()
            .scan(0, |count, border| Some(std::mem::replace(count, *count + usize::from(*border))))
            .collect();
        let segment = |k: usize| self.shiftable_at(k).then(|| segments[self.plan.samples[k].piece]);
        let segments: Vec<Option<usize>> = (0..self.plan.samples.len()).map(segment).collect();
        taper(&segments, TAPER_S / self.plan.desired.trajectory().period_s())
    }
}
