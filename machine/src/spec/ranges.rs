//! Ranges of all numbers of a machine file.
//!
//! Each range leaves a factor of a hundred or more around machines from watchmaking to
//! shipbuilding. It excludes typing errors, wrong units, and numbers with which planning or
//! simulation would take hours or gigabytes.

/// Lowest and highest value of every numeric key, by the end of its name. Integer keys with a check of
/// their own, such as `decimals`, are not included.
pub(super) const RANGES: [(&str, f64, f64); 86] = [
    ("sampling_period_ms", 1e-2, 1e3),
    ("path.velocity_mm_s", 1e-2, 1e5),
    ("path.acceleration_mm_s2", 1e-2, 1e7),
    ("path.jerk_mm_s3", 1e-2, 1e12),
    ("path.centripetal_mm_s2", 1e-2, 1e7),
    ("path.arc_acceleration_mm_s2", 1e-2, 1e7),
    ("path.smoothing_ms", 0.0, 1e3),
    ("control.corners.blend_mm", 0.0, 10.0),
    ("control.corners.speed_jump_mm_s", 0.0, 1e5),
    ("control.corners.junction_deviation_mm", 0.0, 10.0),
    ("filters_ms", 0.0, 1e3),
    ("time_constant_ms", 0.0, 300.0),
    ("control.line_time_ms", 0.0, 1e3),
    ("control.look_ahead_lines", 1.0, 1e6),
    ("controller.point_spacing_ms", 1e-2, 1e4),
    ("controller.path_tolerance_mm", 1e-6, 10.0),
    ("kinematics.tool_length_mm", 0.0, 1e4),
    ("direction", -1e6, 1e6),
    ("pivot_mm", -1e5, 1e5),
    ("velocity_mm_s", 1e-2, 1e5),
    ("acceleration_mm_s2", 1e-2, 1e7),
    ("jerk_mm_s3", 1e-2, 1e12),
    ("travel_mm", -1e6, 1e6),
    ("velocity_rad_s", 1e-4, 1e4),
    ("acceleration_rad_s2", 1e-4, 1e6),
    ("jerk_rad_s3", 1e-4, 1e11),
    ("travel_deg", -1e6, 1e6),
    ("loops.position_gain_1_s", 1e-2, 1e5),
    ("loops.feed_forward", 0.0, 10.0),
    ("loops.position_integral_ms", 1e-2, 1e6),
    ("loops.position_derivative", 0.0, 10.0),
    ("loops.acceleration_feed_forward", 0.0, 10.0),
    ("loops.command_average_ms", 0.0, 1e3),
    ("loops.command_lag_ms", 0.0, 1e3),
    ("warming.share", 0.0, 0.5),
    ("warming.time_s", 1e-3, 1e6),
    ("loops.velocity_gain_n_m_s_rad", 1e-6, 1e6),
    ("loops.integral_time_ms", 1e-2, 1e10),
    ("loops.current_lag_ms", 1e-4, 1e3),
    ("loops.position_period_ms", 1e-3, 1e2),
    ("loops.velocity_period_ms", 1e-3, 1e2),
    ("loops.integration_step_us", 0.5, 1e4),
    ("motor.inertia_kg_m2", 1e-9, 1e4),
    ("motor.viscous_n_m_s_rad", 0.0, 1e4),
    ("motor.torque_limit_n_m", 1e-4, 1e7),
    ("motor.counts_per_turn", 1.0, 1e10),
    ("motor.torque_noise_n_m", 0.0, 1e6),
    ("motor.noise_time_ms", 1e-3, 1e6),
    ("amplitude", -10.0, 10.0),
    ("amplitude_n_m", -1e6, 1e6),
    ("per_turn", 1e-3, 1e6),
    ("phase_rad", -1e4, 1e4),
    ("screw.lead_mm", 1e-2, 1e6),
    ("screw.stiffness_n_m", 1.0, 1e13),
    ("screw.damping_n_s_m", 0.0, 1e10),
    ("screw.backlash_half_width_um", 0.0, 1e5),
    ("gear.turns_per_turn", 1e-2, 1e5),
    ("gear.stiffness_n_m_rad", 1e-2, 1e13),
    ("gear.damping_n_m_s_rad", 0.0, 1e10),
    ("gear.backlash_half_width_urad", 0.0, 1e6),
    ("table.mass_kg", 1e-4, 1e7),
    ("table.viscous_n_s_m", 0.0, 1e8),
    ("table.force_noise_n", 0.0, 1e8),
    ("table.inertia_kg_m2", 1e-9, 1e7),
    ("table.viscous_n_m_s_rad", 0.0, 1e8),
    ("table.torque_noise_n_m", 0.0, 1e8),
    ("table.noise_time_ms", 1e-3, 1e6),
    ("table.scale_resolution_um", 1e-6, 1e5),
    ("table.scale_resolution_urad", 1e-6, 1e6),
    ("friction.coulomb_n", 0.0, 1e8),
    ("friction.static_n", 0.0, 1e8),
    ("friction.coulomb_n_m", 0.0, 1e8),
    ("friction.static_n_m", 0.0, 1e8),
    ("friction.stribeck_mm_s", 1e-3, 1e6),
    ("friction.stribeck_rad_s", 1e-6, 1e3),
    ("friction.drift_time_s", 1e-3, 1e6),
    ("presliding.stiffness_n_m", 1.0, 1e13),
    ("presliding.damping_n_s_m", 0.0, 1e10),
    ("presliding.stiffness_n_m_rad", 1e-2, 1e13),
    ("presliding.damping_n_m_s_rad", 0.0, 1e10),
    ("presliding.shares", 1e-9, 1.0),
    ("presliding.slip_um", 1e-4, 1e5),
    ("presliding.slip_urad", 1e-4, 1e6),
    ("period_mm", 1e-2, 1e7),
    ("period_rad", 1e-5, 1e4),
    ("centre_mm", -1e7, 1e7),
];

/// Ranges of friction positions along an axis, whose rotary form uses mrad for mm.
const PATCHES: [(&str, f64, f64); 3] = [("centre_rad", -1e4, 1e4), ("width_mm", 1e-2, 1e7), ("width_rad", 1e-5, 1e4)];

/// Lowest and highest value of `key`, with all its tables and indices: by the longest entry that it
/// ends in.
pub(super) fn range_of(key: &str) -> Option<(f64, f64)> {
    let plain: String = key.split('[').map(|part| part.split_once(']').map_or(part, |(_, after)| after)).collect();
    let fits = |name: &str| plain.strip_suffix(name).is_some_and(|before| before.is_empty() || before.ends_with('.'));
    let fitting = RANGES.iter().chain(&PATCHES).filter(|(name, ..)| fits(name));
    fitting.max_by_key(|(name, ..)| name.len()).map(|&(_, low, high)| (low, high))
}
