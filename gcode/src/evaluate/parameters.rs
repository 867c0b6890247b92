//! Numbered and named parameters, and the levels of calls that own the local ones.

use super::hash::Map;
use super::value::{Fault, Value};
use crate::dialect::Dialect;

/// Name of a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Name {
    Number(u32),
    /// In upper case, without blanks.
    Named(Vec<u8>),
}

/// Largest number of local parameters of one level: Fanuc's #1 to #33. LinuxCNC has #1 to #30.
const LOCALS: usize = 33;
/// LinuxCNC's last parameter for users. Above it: probe results, offsets, positions, tool data.
const LAST_USER_LINUXCNC: u32 = 5000;
/// LinuxCNC's last position of G28 and G30. Those above are offsets.
const LAST_HOME_LINUXCNC: u32 = 5189;
/// LinuxCNC's last parameter ("Numbered parameters").
const LAST_LINUXCNC: u32 = 5602;
/// Fanuc's first common variable that is kept when the control is switched off (#500 to #999).
const FIRST_KEPT_FANUC: u32 = 500;
/// Fanuc's first system variable.
const FIRST_SYSTEM_FANUC: u32 = 1000;

/// Parameters of one level of calls.
#[derive(Clone, Debug)]
struct Level {
    numbered: [Value; LOCALS],
    named: Map<Vec<u8>, Value>,
    /// Number of changes of its values.
    changes: u64,
}

impl Level {
    /// Makes its values unknown.
    fn forget(&mut self) {
        let values = || self.numbered.iter().chain(self.named.values());
        if values().all(|value| *value == Value::Unknown) {
            return;
        }
        self.changes += 1;
        self.numbered = [Value::Unknown; LOCALS];
        self.named.values_mut().for_each(|value| *value = Value::Unknown);
    }
}

/// All parameters.
///
/// What no block assigned is unknown, because an earlier program, an operator or the machine may have set it. Local parameters of a called
/// subprogram are the exception: 0 on LinuxCNC, null on Fanuc. Those of a main program are cleared by a reset only if a parameter of the
/// control says so.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    dialect: Dialect,
    numbered: Map<u32, Value>,
    /// Global names, which begin with `_`.
    named: Map<Vec<u8>, Value>,
    levels: Vec<Level>,
    /// Set for good by a G66, whose macro runs after every move.
    opaque: bool,
    /// Number of changes of global values.
    changes: u64,
}

impl Parameters {
    pub fn new(dialect: Dialect) -> Self {
        let main = Level { numbered: [Value::Unknown; LOCALS], named: Map::default(), changes: 0 };
        let (numbered, named) = (Map::default(), Map::default());
        let mut parameters = Self { dialect, numbered, named, levels: vec![main], opaque: false, changes: 0 };
        if dialect == Dialect::LinuxCnc {
            parameters.returned(None);
        }
        parameters
    }

    fn last_local(&self) -> u32 {
        if self.dialect == Dialect::Fanuc { 33 } else { 30 }
    }

    fn local(&self) -> Option<&Level> {
        self.levels.last()
    }

    /// Numbers of changes of global values, and of those of the present level.
    pub fn changes(&self) -> [u64; 2] {
        [self.changes, self.local().map_or(0, |level| level.changes)]
    }

    /// The value of a parameter. `None`: LinuxCNC knows no such name.
    pub fn get(&self, name: &Name) -> Result<Option<Value>, Fault> {
        let value = match name {
            Name::Number(0) if self.dialect == Dialect::Fanuc => Some(Value::Null),
            Name::Number(number) if (1..=self.last_local()).contains(number) => {
                self.local().map(|level| level.numbered[*number as usize - 1])
            }
            Name::Number(number) => {
                self.check(*number)?;
                Some(self.numbered.get(number).copied().filter(|_| !self.opaque).unwrap_or(Value::Unknown))
            }
            // The control and its files define global names too.
            Name::Named(text) if text.starts_with(b"_") || self.dialect == Dialect::Fanuc => {
                Some(self.named.get(text).copied().filter(|_| !self.opaque).unwrap_or(Value::Unknown))
            }
            Name::Named(text) => self.local().and_then(|level| level.named.get(text).copied()),
        };
        Ok(value)
    }

    fn check(&self, number: u32) -> Result<(), Fault> {
        let exists = match self.dialect {
            Dialect::LinuxCnc => (1..=LAST_LINUXCNC).contains(&number),
            Dialect::Fanuc | Dialect::Sinumerik => number >= 100,
        };
        if exists { Ok(()) } else { Err(Fault::new(format!("there is no parameter #{number}"))) }
    }

    /// Whether the control itself writes this parameter or acts on it.
    pub fn is_system(&self, name: &Name) -> bool {
        match (name, self.dialect) {
            (Name::Number(number), Dialect::LinuxCnc) => *number > LAST_USER_LINUXCNC,
            (Name::Number(number), Dialect::Fanuc | Dialect::Sinumerik) => *number >= FIRST_SYSTEM_FANUC,
            (Name::Named(_), _) => false,
        }
    }

    /// Whether a parameter has the value that was assigned to it.
    pub fn holds(&self, name: &Name) -> bool {
        let is_local = matches!(name, Name::Number(number) if *number <= self.last_local());
        is_local || !(self.is_system(name) || self.opaque)
    }

    /// Whether an assignment may move the coordinate system: offsets of work and tool, and what the control alone writes.
    pub fn moves_frame(&self, name: &Name) -> bool {
        match (name, self.dialect) {
            (Name::Number(number), Dialect::LinuxCnc) => *number > LAST_HOME_LINUXCNC,
            (Name::Number(number), Dialect::Fanuc | Dialect::Sinumerik) => *number >= 1200 && !(3000..=3006).contains(number),
            (Name::Named(_), _) => false,
        }
    }

    /// Whether an assignment that leaves the coordinate system is more than a value for the program itself: outputs, alarms, messages and modes
    /// of the control, values that are kept when it is switched off, and LinuxCNC's positions of G28 and G30. Clocks and timers are not.
    pub fn outlives(&self, name: &Name) -> bool {
        match (name, self.dialect) {
            (Name::Number(number), Dialect::LinuxCnc) => *number > LAST_USER_LINUXCNC && !self.moves_frame(name),
            (Name::Number(number), Dialect::Fanuc | Dialect::Sinumerik) => {
                *number >= FIRST_KEPT_FANUC && !(3001..=3002).contains(number) && !self.moves_frame(name)
            }
            (Name::Named(_), _) => false,
        }
    }

    /// Assigns a value. The values of system parameters stay unknown.
    pub fn set(&mut self, name: Name, value: Value) -> Result<(), Fault> {
        let last_local = self.last_local();
        let system = self.is_system(&name);
        match name {
            Name::Number(0) => return Err(Fault::new("#0 cannot be assigned")),
            Name::Number(number) if number <= last_local => {
                if let Some(level) = self.levels.last_mut() {
                    let before = std::mem::replace(&mut level.numbered[number as usize - 1], value);
                    level.changes += u64::from(!before.is_same(value));
                }
            }
            Name::Number(number) => {
                self.check(number)?;
                if !system {
                    let before = self.numbered.insert(number, value);
                    self.changes += u64::from(before.is_none_or(|before| !before.is_same(value)));
                }
            }
            Name::Named(text) if text.starts_with(b"_") || self.dialect == Dialect::Fanuc => {
                self.set_global(text, value);
            }
            Name::Named(text) => {
                if let Some(level) = self.levels.last_mut() {
                    let before = level.named.insert(text, value);
                    level.changes += u64::from(before.is_none_or(|before| !before.is_same(value)));
                }
            }
        }
        Ok(())
    }

    fn set_global(&mut self, name: Vec<u8>, value: Value) {
        let before = self.named.insert(name, value);
        self.changes += u64::from(before.is_none_or(|before| !before.is_same(value)));
    }

    /// Opens a level for a subprogram with these values of its first local parameters.
    pub fn enter(&mut self, arguments: &[(u32, Value)]) {
        let vacant = if self.dialect == Dialect::Fanuc { Value::Null } else { Value::Number(0.0) };
        let mut numbered = [vacant; LOCALS];
        for (number, value) in arguments {
            if let Some(slot) = (*number as usize).checked_sub(1).and_then(|index| numbered.get_mut(index)) {
                *slot = *value;
            }
        }
        self.levels.push(Level { numbered, named: Map::default(), changes: 0 });
    }

    /// Closes the level of a subprogram.
    pub fn leave(&mut self) {
        if self.levels.len() > 1 {
            self.levels.pop();
        }
    }

    /// LinuxCNC's value of a call, `#<_value>` and `#<_value_returned>`.
    pub fn returned(&mut self, value: Option<Value>) {
        let has = Value::Number(f64::from(u8::from(value.is_some())));
        self.set_global(b"_VALUE_RETURNED".to_vec(), has);
        self.set_global(b"_VALUE".to_vec(), value.unwrap_or(Value::Number(0.0)));
    }

    /// The value of a call is not known.
    pub fn returned_unknown(&mut self) {
        self.set_global(b"_VALUE_RETURNED".to_vec(), Value::Unknown);
        self.set_global(b"_VALUE".to_vec(), Value::Unknown);
    }

    /// The local parameters of the present level are unknown.
    pub fn forget_local(&mut self) {
        if let Some(level) = self.levels.last_mut() {
            level.forget();
        }
    }

    /// Code that is not read ran: what it can assign is unknown. Parameters of the open levels are its callers' own.
    pub fn forget_global(&mut self) {
        self.changes += u64::from(!(self.numbered.is_empty() && self.named.is_empty()));
        self.numbered.clear();
        self.named.clear();
    }

    /// The target of an assignment is not known.
    pub fn forget_all(&mut self) {
        self.forget_global();
        self.levels.iter_mut().for_each(Level::forget);
    }

    /// From here on global parameters stay unknown.
    pub fn close_global(&mut self) {
        self.changes += u64::from(!self.opaque);
        self.opaque = true;
    }
}
