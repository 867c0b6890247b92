//! M codes that change neither path nor frame.

/// M codes declared by the user to change neither path nor frame, in addition to the known ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassiveCodes([u64; 16]);

impl PassiveCodes {
    /// Largest number of an M code.
    pub const LARGEST: u16 = 1023;

    /// Adds the code `M number`. Numbers above [`Self::LARGEST`] are no codes and are ignored.
    #[must_use]
    pub fn with(mut self, number: u16) -> Self {
        if let Some(bits) = self.0.get_mut(usize::from(number / 64)) {
            *bits |= 1 << (number % 64);
        }
        self
    }

    pub(crate) fn holds(self, number: u16) -> bool {
        self.0.get(usize::from(number / 64)).is_some_and(|bits| bits >> (number % 64) & 1 == 1)
    }
}

/// M codes without influence on path or frame: stops, spindle, coolant, tool change, clamps (ISO
/// 6983; NIST RS274NGC, 3.6), rigid tapping, gears, doors, chip conveyor, air, user relays and
/// subprogram calls (Haas Mill Operator's Manual, M codes; Fanuc 0i Operator's Manual, auxiliary
/// functions), inputs and outputs, overrides and saving of modal states (LinuxCNC, M codes).
/// Excluded: M21 to M23, which mirror axes on many machines, and M71 and M72, which restore saved
/// modal states.
const PASSIVE: &[std::ops::RangeInclusive<u16>] = &[
    0..=11,
    13..=14,
    17..=17,
    19..=19,
    29..=31,
    33..=36,
    39..=39,
    40..=44,
    48..=56,
    58..=59,
    60..=70,
    73..=73,
    75..=80,
    82..=89,
    95..=99,
    104..=105,
    109..=109,
    198..=199,
];

/// LinuxCNC's user-defined codes run an external program. The interpreter state does not change.
const USER_DEFINED: std::ops::RangeInclusive<u16> = 100..=199;

/// Whether the M code changes nothing on any control.
pub(crate) fn changes_nothing(number: u16) -> bool {
    PASSIVE.iter().any(|range| range.contains(&number))
}

/// Whether the M code is user-defined in LinuxCNC.
pub(crate) fn is_user_defined(number: u16) -> bool {
    USER_DEFINED.contains(&number)
}
