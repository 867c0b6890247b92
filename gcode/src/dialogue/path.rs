//! Positioning blocks: lines, circles, and moves to polar coordinates.

use super::block::Block;
use super::functions::{Effect, effect};
use super::sections::Cause;
use super::state::{FeedWord, Interpreter};
use super::words::{BlockFeed, PathWords, Per, functions_of};
use crate::arc::direction;
use crate::modal::{CutterCompensation, FeedMode};
use crate::position::Position;
use crate::split::is_splittable;
use crate::toolpath::{Feed, Fixed, Move, MoveKind, Shiftable};
use crate::word::Word;

/// Path function of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    /// L, LP.
    Line { polar: bool },
    /// C, CP: about the pole.
    Circle { polar: bool },
    /// CR: with a radius.
    Radius,
    /// CT, CTP: tangential.
    Tangent { polar: bool },
}

/// The path function that a block begins with.
pub(super) fn function_of(block: &Block<'_>) -> Option<Function> {
    let name = block.text(block.words.first()?);
    Some(match name.as_slice() {
        b"L" => Function::Line { polar: false },
        b"LP" => Function::Line { polar: true },
        b"C" => Function::Circle { polar: false },
        b"CP" => Function::Circle { polar: true },
        b"CR" => Function::Radius,
        b"CT" => Function::Tangent { polar: false },
        b"CTP" => Function::Tangent { polar: true },
        _ => return None,
    })
}

/// A move of a block before its kind is known.
pub(super) struct Step {
    pub words: PathWords,
    pub function: Function,
    pub end: Position,
    /// Target in polar coordinates.
    pub polar: Option<[f64; 2]>,
}

impl Function {
    fn is_polar(self) -> bool {
        matches!(self, Self::Line { polar: true } | Self::Circle { polar: true } | Self::Tangent { polar: true })
    }
}

impl Interpreter<'_> {
    /// Executes a positioning block.
    pub fn position(&mut self, block: &Block<'_>, function: Function) {
        let is_circle = !matches!(function, Function::Line { .. });
        let words = PathWords::of(block, self, is_circle);
        let optional = block.is_optional && self.options.block_delete.is_none();
        let effects = self.effects_of(&words.functions);
        self.open_sections(&words.functions, &effects);
        if let Some(stray) = words.stray {
            self.report.warning(stray.span, "not understood in a positioning block; the block is left alone", None);
            self.lose_place();
        }
        let cutter_before = self.modal.cutter;
        self.modal.cutter = words.cutter.unwrap_or(cutter_before);
        self.read_feed(words.feed);
        let compensated = cutter_before != CutterCompensation::Off || self.modal.cutter != CutterCompensation::Off;
        if optional && (words.cutter.is_some() || words.feed.is_some_and(|feed| feed != BlockFeed::Rapid)) {
            let help = "state whether it runs: --block-delete on or off";
            self.open(Cause::Lasting, self.span_of_block(), "modal words in a block that a switch may skip", Some(help));
        }
        if words.moves() || matches!(function, Function::Circle { polar: false }) {
            let mut end = self.target(&words);
            let polar = if function.is_polar() {
                self.polar_target(&words, is_circle && function == Function::Circle { polar: true })
            } else {
                None
            };
            if function.is_polar() {
                self.place_polar(&mut end, polar);
            }
            let why = self.why_fixed(&words, &effects, compensated, optional);
            let step = Step { words, function, end, polar };
            self.move_to(&step, why, &effects);
            if optional {
                self.lose_place();
            }
        }
        self.end_block(&effects);
    }

    /// The M functions of a block that is no positioning block.
    pub fn execute_functions(&mut self, block: &Block<'_>) {
        let functions = functions_of(block);
        let effects = self.effects_of(&functions);
        self.open_sections(&functions, &effects);
        self.end_block(&effects);
    }

    fn effects_of(&self, functions: &[(Word, Option<u16>)]) -> Vec<Effect> {
        let of = |number: Option<u16>| number.map_or(Effect::Opens(Cause::Lasting), |number| self.effect_of(number));
        functions.iter().map(|(_, number)| of(*number)).collect()
    }

    fn effect_of(&self, number: u16) -> Effect {
        match effect(number) {
            Effect::Opens(Cause::Lasting) if self.options.passive.holds(number) => Effect::None,
            // Speed and way of rotary axes alone.
            Effect::Opens(_) if matches!(number, 116 | 126) && !self.names_rotary => Effect::None,
            other => other,
        }
    }

    fn open_sections(&mut self, functions: &[(Word, Option<u16>)], effects: &[Effect]) {
        for ((word, number), effect) in functions.iter().zip(effects) {
            if let Effect::Opens(cause) = effect {
                let (what, help) = match number {
                    Some(number) if *cause == Cause::Lasting => (
                        format!("M{number}: what it changes is not known"),
                        Some(format!("give --passive M{number} if the machine does nothing with path or frame by it")),
                    ),
                    Some(number) => (format!("M{number} changes path or speed in a way that is not interpreted"), None),
                    None => ("this M function is not known".to_owned(), None),
                };
                self.open(*cause, word.span, &what, help.as_deref());
            }
        }
    }

    /// What M functions do at the end of their block.
    fn end_block(&mut self, effects: &[Effect]) {
        for effect in effects {
            match effect {
                Effect::End => self.ended = true,
                Effect::CycleCall => self.call_cycle(),
                Effect::Closes(cause) => self.close(*cause),
                Effect::Frame => {
                    self.lose_rotation("M143");
                    self.lose_place();
                }
                // The length of the tool changes; the axes may have moved.
                Effect::Retract | Effect::ToolChange => self.lose_place(),
                _ => {}
            }
        }
    }

    fn read_feed(&mut self, feed: Option<BlockFeed>) {
        self.feed = match feed {
            None | Some(BlockFeed::Rapid) => return,
            Some(BlockFeed::OfTool) => self.tool_feed,
            Some(BlockFeed::Feed { per: Per::Minute, value: Some(value) }) => FeedWord::PerMinute(value),
            Some(BlockFeed::Feed { per: Per::Revolution, value: Some(value) }) => FeedWord::PerRevolution(value),
            Some(BlockFeed::Feed { .. }) => FeedWord::Unknown,
        };
        self.modal.feed_mode =
            if matches!(self.feed, FeedWord::PerRevolution(_)) { FeedMode::PerRevolution } else { FeedMode::PerMinute };
    }

    /// Reason why the block must not be changed, whatever its geometry.
    fn why_fixed(&self, words: &PathWords, effects: &[Effect], compensated: bool, optional: bool) -> Option<Fixed> {
        let has = |wanted: Effect| effects.contains(&wanted);
        if has(Effect::MachineFrame) {
            Some(Fixed::MachineCoordinates)
        } else if self.sections.is_open()
            || words.stray.is_some()
            || !words.is_known()
            || has(Effect::Frame)
            || has(Effect::Retract)
        {
            Some(Fixed::NotUnderstood)
        } else if compensated {
            Some(Fixed::CutterCompensation)
        } else if self.start_is_computed {
            Some(Fixed::Adjoining)
        } else if has(Effect::ToolChange) {
            Some(Fixed::ToolChange)
        } else if !is_splittable(self.program, self.block, self.options.dialect) || self.named_blocks.hold(self.block) {
            Some(Fixed::Unsplittable)
        } else if optional {
            Some(Fixed::OptionalBlock)
        } else {
            None
        }
    }

    fn move_to(&mut self, step: &Step, why: Option<Fixed>, effects: &[Effect]) {
        let start = self.position;
        let is_rapid = step.words.feed == Some(BlockFeed::Rapid);
        let needs = self.needs_of(step);
        let kind = if is_rapid { Some(MoveKind::Rapid) } else { self.kind_of(step) };
        let feed = if is_rapid { None } else { self.feed_of(&step.words) };
        let mut end = step.end;
        if effects.contains(&Effect::MachineFrame) {
            for axis in (0..6).filter(|axis| step.words.axes[*axis].is_some()) {
                end.nominal[axis] = start.nominal[axis];
                end.forget(axis);
            }
        }
        self.position = end;
        self.start_is_computed = false;
        let turned_known = (3..6).all(|axis| step.words.axes[axis].is_none() || (start.knows(axis) && end.knows(axis)));
        let placed = start.xyz_mm().is_some() && end.xyz_mm().is_some() && turned_known;
        let shiftable = match why {
            Some(Fixed::MachineCoordinates) => Shiftable::No(Fixed::MachineCoordinates),
            _ if is_rapid => Shiftable::No(Fixed::Rapid),
            Some(why) => Shiftable::No(why),
            None if matches!(self.feed, FeedWord::PerRevolution(_)) => Shiftable::No(Fixed::Threading),
            None if start.xyz_mm().is_none() => Shiftable::No(Fixed::UnknownStart),
            None if feed.is_none() || kind.is_none() => Shiftable::No(Fixed::NotUnderstood),
            None if !placed => Shiftable::No(Fixed::UnknownStart),
            None => Shiftable::Yes,
        };
        let kind = kind.unwrap_or(MoveKind::Line);
        self.follow(step, &kind, &start);
        let modal = self.modal_index();
        let feed_word = match self.feed {
            FeedWord::PerMinute(value) | FeedWord::PerRevolution(value) => Some(value),
            FeedWord::Unset | FeedWord::Unknown => None,
        };
        let block = self.block as u32;
        self.push(
            Move {
                block,
                modal,
                kind,
                start,
                end,
                feed,
                feed_word,
                motion_code: None,
                explicit_motion: true,
                shiftable,
                after_shared: false,
                after_stop: false,
            },
            needs,
        );
    }

    /// Direction and polar coordinates behind a move.
    fn follow(&mut self, step: &Step, kind: &MoveKind, start: &Position) {
        self.polar = step.polar;
        self.tangent = match (kind, self.in_plane(start), self.in_plane(&step.end)) {
            (MoveKind::Arc(arc), ..) => Some(arc.end_direction()),
            (MoveKind::Line, Some(from), Some(to)) if step.words.is_known() && step.words.stray.is_none() => direction(from, to),
            _ => None,
        };
    }

    /// Feed of a feed move; `None` where it is not known. A program without any is refused.
    pub fn feed_of(&mut self, words: &PathWords) -> Option<Feed> {
        let rotary_only = words.axes[..3].iter().all(Option::is_none) && words.axes[3..].iter().any(Option::is_some);
        // Under M136, up to M137, F is one a turn.
        let turns = self.sections.any(|cause| *cause == Cause::EndedBy(137));
        let per_turn = matches!(self.feed, FeedWord::PerRevolution(_)) || turns;
        let linear_mm = if per_turn { self.modal.units.mm() } else { self.modal.feed_unit_mm };
        let unit = if rotary_only { 1.0_f64.to_radians() } else { linear_mm };
        let per_second = match self.feed {
            FeedWord::PerMinute(feed) if !turns => feed / 60.0,
            FeedWord::PerMinute(feed) | FeedWord::PerRevolution(feed) => {
                feed * self.modal.spindle_rpm.filter(|rpm| *rpm > 0.0)? / 60.0
            }
            FeedWord::Unknown => return None,
            FeedWord::Unset => {
                let help = "write an F word, or F in TOOL CALL";
                self.report.error_from("feed", usize::MAX, self.span_of_block(), "no feed was given before this feed move", help);
                return None;
            }
        };
        if per_second <= 0.0 {
            self.report.error_from("feed", usize::MAX, self.span_of_block(), "the feed is not positive", "F must be above zero");
            return None;
        }
        Some(if rotary_only { Feed::Angular { rad_s: unit * per_second } } else { Feed::Linear { mm_s: unit * per_second } })
    }
}
