//! How a control turns a program into a command, as far as limits do not say it.
//!
//! The limits of axes and path, the shape of an acceleration along the path and the speed of rapids stand in
//! [`PathSpec`](super::PathSpec) and with the axes.

use motion::{AxisFilter, Corners, PlanSettings};
use serde::{Deserialize, Serialize};

use super::AxisSpec;
use super::check::{not_negative, positive};
use crate::MachineError;

/// How a control passes corners and filters its command: the table `[control]` of a machine file.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlSpec {
    /// Rule of corners.
    #[serde(default)]
    pub corners: CornerRule,
    /// Moving averages of every axis after interpolation, ms. They round corners and shrink arcs with the speed. 0 for none.
    #[serde(default)]
    pub filters_ms: [f64; 2],
    /// Time constant of a first-order lag of every axis after interpolation ("exponential" acceleration), ms. 0 for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub time_constant_ms: f64,
    /// Lines after the present one that the control knows: it never runs faster than it can stop at the end of the last of them. All if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_ahead_lines: Option<u32>,
    /// Shortest time for a line, ms: a shorter one is passed slower. 0 for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub line_time_ms: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Rule by which a control passes a corner where the program asks for no exact stop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CornerRule {
    /// It rounds corners within this tolerance, where the program does not state its own; 0 stops.
    BlendMm(f64),
    /// It passes the corner itself; no axis changes its speed by more than this.
    SpeedJumpMmS(f64),
    /// It passes the corner itself, at the speed of an arc that lies this far from it (junction deviation of Grbl).
    JunctionDeviationMm(f64),
}

/// Tolerance of corners that neither program nor control state, mm.
pub const UNSTATED_BLEND_MM: f64 = 0.002;

impl Default for CornerRule {
    fn default() -> Self {
        Self::BlendMm(UNSTATED_BLEND_MM)
    }
}

impl ControlSpec {
    /// Planner settings with the rule of corners and the limits of lines of this control.
    #[must_use]
    pub fn applied(&self, settings: PlanSettings) -> PlanSettings {
        let settings = PlanSettings {
            look_ahead: self.look_ahead_lines.map(|lines| lines as usize),
            piece_time_s: 1e-3 * self.line_time_ms,
            ..settings
        };
        match self.corners {
            CornerRule::BlendMm(corner_tolerance_mm) => PlanSettings { corners: Corners::Blend, corner_tolerance_mm, ..settings },
            CornerRule::SpeedJumpMmS(jump_mm_s) => PlanSettings { corners: Corners::SpeedJump(jump_mm_s), ..settings },
            CornerRule::JunctionDeviationMm(off_mm) => PlanSettings { corners: Corners::JunctionDeviation(off_mm), ..settings },
        }
    }

    /// The filter of an axis that states none of its own.
    pub(super) fn common_filter(&self) -> AxisFilter {
        AxisFilter {
            averages_s: self.filters_ms.map(|filter_ms| 1e-3 * filter_ms),
            time_constant_s: 1e-3 * self.time_constant_ms,
        }
    }

    /// The filter of an axis: its own where it states one.
    pub(super) fn filter(&self, axis: &AxisSpec) -> AxisFilter {
        let (filters_ms, time_constant_ms) = axis.filters();
        let filters_ms = filters_ms.unwrap_or(self.filters_ms);
        let time_constant_ms = time_constant_ms.unwrap_or(self.time_constant_ms);
        Self { filters_ms, time_constant_ms, ..*self }.common_filter()
    }

    /// Checks that every value is in range.
    pub(super) fn check(&self) -> Result<(), MachineError> {
        let (key, value) = match self.corners {
            CornerRule::BlendMm(value) => ("control.corners.blend_mm", value),
            CornerRule::SpeedJumpMmS(value) => ("control.corners.speed_jump_mm_s", value),
            CornerRule::JunctionDeviationMm(value) => ("control.corners.junction_deviation_mm", value),
        };
        not_negative(key, value)?;
        not_negative("control.time_constant_ms", self.time_constant_ms)?;
        not_negative("control.line_time_ms", self.line_time_ms)?;
        if let Some(lines) = self.look_ahead_lines {
            positive("control.look_ahead_lines", f64::from(lines))?;
        }
        self.filters_ms.iter().try_for_each(|filter_ms| not_negative("control.filters_ms", *filter_ms))
    }
}
