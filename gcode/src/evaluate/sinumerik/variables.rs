//! R parameters, global user data and local variables ("Variables").

use super::arithmetic::rounded;
use crate::evaluate::hash::Map;
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

impl Name {
    /// Whether an assignment that changes no frame acts on the control or on synchronized actions: system variables but timers.
    pub fn acts(&self) -> bool {
        self.base.starts_with('$') && !self.moves_frame() && !self.base.ends_with("_TIMER")
    }
}

/// Variables of one program level.
#[derive(Clone, Debug, Default)]
struct Level {
    kinds: Map<String, Kind>,
    values: Map<Name, Value>,
    /// Number of changes of these.
    changes: u64,
}

/// All variables. What no block assigned is unknown, because an earlier program, an operator or the machine may have set it; a variable that is
/// defined is 0 ("Definition of user variables").
#[derive(Clone, Debug)]
pub(super) struct Variables {
    /// R parameters and global user data.
    global: Map<Name, Value>,
    levels: Vec<Level>,
    /// Number of changes of global values.
    changes: u64,
}

impl Variables {
    pub fn new() -> Self {
        Self { global: Map::default(), levels: vec![Level::default()], changes: 0 }
    }

    /// Numbers of changes of global values, and of those of the present level.
    pub fn changes(&self) -> [u64; 2] {
        [self.changes, self.levels.last().map_or(0, |level| level.changes)]
    }

    pub fn get(&self, name: &Name) -> Value {
        let Some(level) = self.levels.last() else { return Value::Unknown };
        match level.kinds.get(&name.base) {
            _ if name.index.is_none() => Value::Unknown,
            Some(kind) => level.values.get(name).copied().unwrap_or_else(|| kind.of(Value::Number(0.0))),
            None => self.global.get(name).copied().unwrap_or(Value::Unknown),
        }
    }

    /// The value of a variable after the assignments `before`.
    pub fn get_after(&self, before: &[(Name, Value)], name: &Name) -> Value {
        let is_whole_r = |target: &Name| target.base == "R" && name.is_parameter();
        let covers =
            |target: &Name| target == name || (target.index.is_none() && (target.base == name.base || is_whole_r(target)));
        match before.iter().rfind(|(target, _)| covers(target)) {
            Some((target, _)) if target.index.is_none() => Value::Unknown,
            Some((_, value)) => match self.levels.last().and_then(|level| level.kinds.get(&name.base)) {
                Some(kind) => kind.of(*value),
                None => *value,
            },
            None => self.get(name),
        }
    }

    /// Whether the name is an R parameter or a variable that the program defines.
    pub fn is_defined(&self, name: &Name) -> bool {
        name.is_parameter() || self.levels.last().is_some_and(|level| level.kinds.contains_key(&name.base))
    }

    /// Defines a variable of the present level. Its elements are 0 until they are assigned.
    pub fn define(&mut self, base: &str, kind: Kind) {
        if let Some(level) = self.levels.last_mut() {
            level.changes += u64::from(level.kinds.insert(base.to_owned(), kind) != Some(kind));
        }
    }

    /// Assigns a value. An unknown index makes all elements unknown.
    pub fn set(&mut self, name: &Name, value: Value) {
        let Some(level) = self.levels.last_mut() else { return };
        if name.index.is_none() {
            self.changes += 1;
            level.kinds.insert(name.base.clone(), Kind::Other);
            level.values.retain(|known, _| known.base != name.base);
            let is_r = name.base == "R";
            self.global.retain(|known, _| known.base != name.base && !(is_r && known.is_parameter()));
            return;
        }
        let (values, value, changes) = match level.kinds.get(&name.base) {
            Some(kind) => (&mut level.values, kind.of(value), &mut level.changes),
            None => (&mut self.global, value, &mut self.changes),
        };
        match values.get_mut(name) {
            Some(known) if known.is_same(value) => return,
            Some(known) => *known = value,
            None => drop(values.insert(name.clone(), value)),
        }
        *changes += 1;
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
        self.changes += u64::from(!self.global.is_empty());
        self.global.clear();
    }

    /// The variables of the present level are unknown too.
    pub fn forget_all(&mut self) {
        self.forget_global();
        for level in &mut self.levels {
            let is_known = |kind: &Kind| *kind != Kind::Other;
            level.changes += u64::from(!level.values.is_empty() || level.kinds.values().any(is_known));
            level.values.clear();
            level.kinds.values_mut().for_each(|kind| *kind = Kind::Other);
        }
    }
}
