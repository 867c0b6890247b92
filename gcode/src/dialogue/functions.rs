//! M functions and cycles by their effect on path and frame.
//!
//! Source: HEIDENHAIN TNC 640, User's Manual for Conversational Programming, overviews of the miscellaneous functions and of the cycles.

use super::sections::Cause;

/// Effect of an M function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// None on path and frame.
    None,
    /// The coordinates of the block are not in the work frame: M91, M92, M130.
    MachineFrame,
    /// Calls the cycle at the end of the block: M99.
    CycleCall,
    /// Changes the tool: M6.
    ToolChange,
    /// Ends the program: M2, M30.
    End,
    /// Retracts along the tool axis: M140.
    Retract,
    /// Changes the work frame: M143.
    Frame,
    /// Opens a section.
    Opens(Cause),
    /// Ends a section.
    Closes(Cause),
}

/// Effect of an M function; a lasting section for those that are not known.
pub(super) fn effect(number: u16) -> Effect {
    match number {
        2 | 30 => Effect::End,
        6 => Effect::ToolChange,
        91 | 92 | 130 => Effect::MachineFrame,
        99 => Effect::CycleCall,
        // Stops, spindle and coolant.
        0 | 1 | 3..=5 | 8 | 9 | 13 | 14 => Effect::None,
        // Contours with radius compensation only, which are left alone anyway.
        97 | 98 | 120 => Effect::None,
        // Which axes PLANE turns.
        138 => Effect::None,
        // Tool replacement off, its messages, probe monitoring, lift-off at a stop.
        102 | 107 | 108 | 141 | 148 | 149 => Effect::None,
        109 | 110 => Effect::Opens(Cause::EndedBy(111)),
        116 => Effect::Opens(Cause::EndedBy(117)),
        126 => Effect::Opens(Cause::EndedBy(127)),
        136 => Effect::Opens(Cause::EndedBy(137)),
        144 => Effect::Opens(Cause::EndedBy(145)),
        128 => Effect::Opens(Cause::ToolCentrePoint),
        129 => Effect::Closes(Cause::ToolCentrePoint),
        111 | 117 | 127 | 137 | 145 => Effect::Closes(Cause::EndedBy(number)),
        140 => Effect::Retract,
        143 => Effect::Frame,
        _ => Effect::Opens(Cause::Lasting),
    }
}

/// Whether the words behind the M function belong to it: `M103 F20`, `M120 LA5`, `M140 MB10`.
pub(super) fn has_words(number: u16) -> bool {
    matches!(number, 103 | 118 | 120 | 128 | 136 | 138 | 140 | 197)
}

/// Effect of the definition of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CycleEffect {
    /// None before it is called.
    OnCall,
    /// Waits.
    Dwell,
    /// Path tolerance.
    Tolerance,
    /// Datum shift.
    Shift,
    /// Mirror image, rotation or scaling, ended by a definition of the same cycle.
    Transform(Cause),
    /// Another preset.
    Preset,
    /// Not known, or not interpreted: other programs, patterns, the working plane, probing.
    Unknown,
}

/// Effect of `CYCL DEF` with this number.
pub(super) fn cycle_effect(number: u32) -> CycleEffect {
    match number {
        7 => CycleEffect::Shift,
        8 => CycleEffect::Transform(Cause::Mirror),
        9 => CycleEffect::Dwell,
        10 => CycleEffect::Transform(Cause::Rotation),
        11 => CycleEffect::Transform(Cause::Scaling),
        32 => CycleEffect::Tolerance,
        247 => CycleEffect::Preset,
        // Drilling, tapping, pockets, studs, slots, contour pockets and trains; orientation of the spindle.
        1..=6 | 13..=18 | 20..=25 | 27..=29 | 39 => CycleEffect::OnCall,
        200..=209 | 225 | 230..=233 | 240 | 241 | 251..=257 | 262..=265 | 267 | 270..=276 => CycleEffect::OnCall,
        _ => CycleEffect::Unknown,
    }
}
