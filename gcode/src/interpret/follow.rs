//! Flow control: decides whether a feed move runs exactly once and in the modal state that was
//! read.

use super::bodies::{Body, DEEPEST};
use super::codes::{Code, Motion, OneShot};
use super::flow::{Flow, classify};
use super::gather::Gathered;
use super::state::Interpreter;
use crate::position::AXIS_LETTERS;
use crate::word::Span;

impl Interpreter<'_> {
    /// Processes the flow statement in word `index`.
    pub fn follow_flow(&mut self, index: usize) {
        let span = self.span(index);
        let block = self.block;
        let open = |label: &[u8], is_do, is_subprogram| Body { label: label.to_vec(), block, is_do, is_subprogram };
        let statement = classify(self.program.text(span));
        if self.flow.bodies.len() >= DEEPEST
            && matches!(statement, Flow::Sub { .. } | Flow::Open { .. } | Flow::OpenDo { .. } | Flow::While { .. })
        {
            self.report.error(span, format!("more than {DEEPEST} bodies are open"), None);
            return;
        }
        match statement {
            Flow::Sub { label } => self.flow.bodies.push(open(label, false, true)),
            Flow::Open { label } => self.flow.bodies.push(open(label, false, false)),
            Flow::OpenDo { label } => self.flow.bodies.push(open(label, true, false)),
            Flow::While { label } => {
                if self.flow.bodies.last().is_some_and(|body| body.is_do && body.label.eq_ignore_ascii_case(label)) {
                    self.close_body(label);
                } else {
                    self.flow.bodies.push(open(label, false, false));
                }
            }
            Flow::Close { label } => self.close_body(label),
            Flow::Call if self.flow.in_subprogram() => {}
            Flow::Call => self.call(span),
            Flow::Jump => self.jump(span),
            Flow::Assign | Flow::Inside => {}
        }
    }

    fn close_body(&mut self, label: &[u8]) {
        let was_subprogram = self.flow.in_subprogram();
        if self.flow.close(label) && !was_subprogram {
            // The body may have run or not.
            self.forget_all();
            self.motion = None;
            self.cycle = None;
        }
    }

    /// A subprogram or macro call. The position afterwards is unknown.
    pub fn call(&mut self, span: Span) {
        self.forget_all();
        self.report.warning(
            span,
            "a subprogram is called: its moves are not read, and the modal state is taken to be the same afterwards",
            None,
        );
    }

    /// A jump. Earlier feed moves may run again, later ones may not run.
    pub fn jump(&mut self, span: Span) {
        if self.fed {
            self.report.error(
                span,
                "a jump or condition after feed moves: they may run again or not at all",
                Some("unroll the program before it is compensated"),
            );
        }
        self.flow.uncertain = self.flow.uncertain.or(Some(self.block));
        self.forget_all();
    }

    /// Modal codes in a body that may not run make the state after it uncertain.
    pub fn note_body(&mut self, words: &Gathered) {
        if self.flow.bodies.is_empty() {
            return;
        }
        let changes_state = words.g.iter().any(|g| {
            !matches!(
                g.code,
                Code::Motion(Motion::Rapid)
                    | Code::OneShot(OneShot::Dwell | OneShot::Home)
                    | Code::MachineCoordinates
                    | Code::Silent
            )
        });
        if changes_state || words.has(b'F') {
            self.flow.uncertain = self.flow.uncertain.or(Some(self.block));
        }
    }

    /// A subprogram body runs elsewhere and repeatedly. Only rapids are accepted in it.
    pub fn refuse_subprogram_motion(&mut self, words: &Gathered) {
        let harmless = words.g.iter().any(|g| {
            matches!(
                g.code,
                Code::Motion(Motion::Rapid) | Code::OneShot(_) | Code::MachineCoordinates | Code::TransformOn | Code::Cycle(_)
            )
        });
        let geometry = words.any(&AXIS_LETTERS).or_else(|| words.any(b"IJK"));
        if let (Some(index), false, Some((cause, _))) = (geometry, harmless, self.flow.fault()) {
            let message = format!("a feed move inside the subprogram that opens on line {}", cause + 1);
            self.report.error_from("flow", cause, self.span(index), message, "unroll the program before it is compensated");
        }
    }
}
