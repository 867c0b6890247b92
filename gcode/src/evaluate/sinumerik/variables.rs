//! R parameters, global user data and local variables ("Variables").

use std::collections::HashMap;

use super::arithmetic::rounded;
use crate::evaluate::value::Value;

/// Type of a variable, as far as an assignment depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Int,
    Real,
    Bool,
    /// Strings, axes, frames: their values are unknown.
    Other,
}

impl Kind {
    /// The type with this name in upper case.
    pub fn read(name: &str) -> Option<Self> {
        Some(match name {
            "INT" => Self::Int,
            "REAL" => Self::Real,
            "BOOL" => Self::Bool,
            "CHAR" | "STRING" | "AXIS" | "FRAME" => Self::Other,
            _ => return None,
        })
    }

    /// The value that a variable of this type takes.
    fn of(self, value: Value) -> Value {
        match (self, value.number()) {
            (Self::Other, _) | (_, None) => Value::Unknown,
            (Self::Int, Some(number)) => rounded(number),
            (Self::Bool, Some(number)) => Value::Number(f64::from(u8::from(number != 0.0))),
            (Self::Real, Some(number)) => Value::Number(number),
        }
    }
}

/// Largest R number: controls have 100 to 32,535 of them.
const LAST_R: f64 = 99_999.0;

/// A variable with its indices, in upper case: `R1`, `DEPTH`, `LIST[2]`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Name {
    pub base: String,
    /// `None`: an element whose index is unknown.
    pub index: Option<Vec<i64>>,
}

impl Name {
    pub fn plain(base: impl Into<String>) -> Self {
        Self { base: base.into(), index: Some(Vec::new()) }
    }

    /// `R1` and `R[1]` are the same.
    pub fn of(base: String, index: Option<Vec<f64>>) -> Self {
        let whole = |index: &Vec<f64>| index.iter().all(|n| n.fract() == 0.0 && (0.0..=LAST_R).contains(n));
        let index = index.filter(whole).map(|index| index.iter().map(|n| *n as i64).collect::<Vec<_>>());
        match index.as_deref() {
            Some([number]) if base == "R" => Self::plain(format!("R{number}")),
            _ => Self { base, index },
        }
    }

    fn is_parameter(&self) -> bool {
        self.base == "R" || self.base.strip_prefix('R').is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()))
    }

    /// Whether an assignment may change frames, tools or settings of the control: system variables but markers, timers, parameters of
    /// synchronized actions, and outputs.
    pub fn moves_frame(&self) -> bool {
        let harmless = ["$A_OUT", "$A_DB", "$AC_MARKER", "$AC_PARAM", "$AC_TIMER", "$AN_TIMER", "$AC_MEA"];
        self.base.starts_with('$') && !harmless.iter().any(|name| self.base.starts_with(name))
    }
}

/// Variables of one program level.
#[derive(Clone, Debug, Default)]
struct Level {
    kinds: HashMap<String, Kind>,
    values: HashMap<Name, Value>,
}

/// All variables. What no block assigned is unknown, because an earlier program, an operator or the machine may have set it; a variable that is
/// defined is 0 ("Definition of user variables").
#[derive(Clone, Debug)]
pub(super) struct Variables {
    /// R parameters and global user data.
    global: HashMap<Name, Value>,
    levels: Vec<Level>,
}

impl Variables {
    pub fn new() -> Self {
        Self { global: HashMap::new(), levels: vec![Level::default()] }
    }

    pub fn get(&self, name: &Name) -> Value {
        let Some(level) = self.levels.last() else { return Value::Unknown };
        match level.kinds.get(&name.base) {
            _ if name.index.is_none() => Value::Unknown,
            Some(kind) => level.values.get(name).copied().unwrap_or_else(|| kind.of(Value::Number(0.0))),
            None => self.global.get(name).copied().unwrap_or(Value::Unknown),
        }
    }

    /// Whether the name is an R parameter or a variable that the program defines.
    pub fn is_defined(&self, name: &Name) -> bool {
        name.is_parameter() || self.levels.last().is_some_and(|level| level.kinds.contains_key(&name.base))
    }

    /// Defines a variable of the present level. Its elements are 0 until they are assigned.
    pub fn define(&mut self, base: &str, kind: Kind) {
        if let Some(level) = self.levels.last_mut() {
            level.kinds.insert(base.to_owned(), kind);
        }
    }

    /// Assigns a value. An unknown index makes all elements unknown.
    pub fn set(&mut self, name: &Name, value: Value) {
        let Some(level) = self.levels.last_mut() else { return };
        if name.index.is_none() {
            level.kinds.insert(name.base.clone(), Kind::Other);
            level.values.retain(|known, _| known.base != name.base);
            let is_r = name.base == "R";
            self.global.retain(|known, _| known.base != name.base && !(is_r && known.is_parameter()));
            return;
        }
        match level.kinds.get(&name.base) {
            Some(kind) => level.values.insert(name.clone(), kind.of(value)),
            None => self.global.insert(name.clone(), value),
        };
    }

    /// Opens the level of a subprogram.
    pub fn enter(&mut self) {
        self.levels.push(Level::default());
    }

    /// Closes the level of a subprogram.
    pub fn leave(&mut self) {
        if self.levels.len() > 1 {
            self.levels.pop();
        }
    }

    /// Code that is not read ran.
    pub fn forget_global(&mut self) {
        self.global.clear();
    }

    /// The variables of the present level are unknown too.
    pub fn forget_all(&mut self) {
        self.forget_global();
        for level in &mut self.levels {
            level.values.clear();
            level.kinds.values_mut().for_each(|kind| *kind = Kind::Other);
        }
    }
}
