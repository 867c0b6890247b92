//! Random SINUMERIK programs, whose moves a small evaluator of their syntax trees computes apart from the crate.

use std::fmt::Write;

use gcode::{Dialect, Options, evaluate, expand, interpret, parse};

/// Deterministic random numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }
}

enum Value {
    Number(f64),
    R(usize),
    Sum(Box<Value>, Box<Value>),
    Difference(Box<Value>, Box<Value>),
    Product(Box<Value>, Box<Value>),
    Truncated(Box<Value>),
    Size(Box<Value>),
}

struct Condition(Value, &'static str, Value);

enum Step {
    Assign(usize, Value),
    /// Axis, how its value is meant, value.
    Move(usize, &'static str, Value),
    Incremental(bool),
    /// Whether it adds, axis, value.
    Shift(bool, usize, Value),
    ClearShift,
    If(Condition, Vec<Step>, Vec<Step>),
    /// Counter, passes, body.
    For(usize, u32, Vec<Step>),
    While(usize, u32, Vec<Step>),
    Until(usize, u32, Vec<Step>),
    /// A conditional jump over blocks, or one backward.
    Skip(Condition, Vec<Step>),
    Back(usize, u32, Vec<Step>),
    /// A section, and how often it runs once more.
    Again(Vec<Step>, u32),
    Choose(Value, Vec<Step>, Vec<Step>),
    Call(Value, u32),
}

/// Makes steps. Counters and labels are unique.
struct Maker {
    random: Random,
    counter: usize,
}

impl Maker {
    fn value(&mut self, depth: u32) -> Value {
        let mut two = || (Box::new(self.value_below(depth)), Box::new(self.value_below(depth)));
        let (a, b) = if depth > 0 { two() } else { (Box::new(Value::Number(1.0)), Box::new(Value::Number(1.0))) };
        match self.random.below(if depth > 0 { 8 } else { 3 }) {
            0 => Value::Number(self.random.below(19) as f64 * 0.5 - 4.5),
            1 | 2 => Value::R(1 + self.random.below(5) as usize),
            3 => Value::Sum(a, b),
            4 => Value::Difference(a, b),
            5 => Value::Product(a, b),
            6 => Value::Truncated(a),
            _ => Value::Size(a),
        }
    }

    fn value_below(&mut self, depth: u32) -> Value {
        self.value(depth - 1)
    }

    fn condition(&mut self) -> Condition {
        let sign = ["==", "<>", "<", ">", "<=", ">="][self.random.below(6) as usize];
        Condition(self.value(1), sign, self.value(1))
    }

    fn steps(&mut self, depth: u32) -> Vec<Step> {
        (0..1 + self.random.below(4)).map(|_| self.step(depth)).collect()
    }

    fn step(&mut self, depth: u32) -> Step {
        self.counter += 1;
        let (own, axis, passes) = (10 + self.counter, self.random.below(3) as usize, self.random.below(3) as u32);
        match self.random.below(if depth > 0 { 20 } else { 10 }) {
            0..=2 => Step::Assign(1 + self.random.below(5) as usize, self.value(2)),
            3..=5 => Step::Move(axis, ["", "", "AC", "IC"][self.random.below(4) as usize], self.value(2)),
            6 => Step::Incremental(passes == 0),
            7 => Step::Shift(passes == 0, axis, self.value(1)),
            8 => Step::ClearShift,
            9 => Step::Call(self.value(1), passes),
            10 | 11 => Step::If(self.condition(), self.steps(depth - 1), self.steps(depth - 1)),
            12 => Step::For(own, passes, self.steps(depth - 1)),
            13 => Step::While(own, passes, self.steps(depth - 1)),
            14 => Step::Until(own, passes, self.steps(depth - 1)),
            15 => Step::Skip(self.condition(), self.steps(depth - 1)),
            16 => Step::Back(own, passes, self.steps(depth - 1)),
            17 => Step::Choose(self.value(1), self.steps(depth - 1), self.steps(depth - 1)),
            _ => Step::Again(self.steps(depth - 1), passes),
        }
    }
}

impl Value {
    fn text(&self) -> String {
        match self {
            Self::Number(number) => format!("{number}"),
            Self::R(number) => format!("R{number}"),
            Self::Sum(a, b) => format!("({} + {})", a.text(), b.text()),
            Self::Difference(a, b) => format!("({}-{})", a.text(), b.text()),
            Self::Product(a, b) => format!("({}*{})", a.text(), b.text()),
            Self::Truncated(a) => format!("TRUNC({})", a.text()),
            Self::Size(a) => format!("abs({})", a.text()),
        }
    }

    fn of(&self, r: &[f64]) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::R(number) => r[*number],
            Self::Sum(a, b) => a.of(r) + b.of(r),
            Self::Difference(a, b) => a.of(r) - b.of(r),
            Self::Product(a, b) => a.of(r) * b.of(r),
            Self::Truncated(a) => a.of(r).trunc(),
            Self::Size(a) => a.of(r).abs(),
        }
    }
}

impl Condition {
    fn text(&self) -> String {
        format!("{} {} {}", self.0.text(), self.1, self.2.text())
    }

    fn holds(&self, r: &[f64]) -> bool {
        let (a, b) = (self.0.of(r), self.2.of(r));
        match self.1 {
            "==" => a == b,
            "<>" => a != b,
            "<" => a < b,
            ">" => a > b,
            "<=" => a <= b,
            _ => a >= b,
        }
    }
}

/// Writes steps; `label` is the last that was used.
fn write(steps: &[Step], label: &mut u32, out: &mut String) {
    for step in steps {
        *label += 1;
        let own = *label;
        let mut inner = |steps: &[Step]| {
            let mut text = String::new();
            write(steps, label, &mut text);
            text
        };
        let text = match step {
            Step::Assign(number, value) => format!("R{number}=BOUND(-50,50,{})\n", value.text()),
            Step::Move(axis, "", value) => format!("N{own} {}={}\n", ["X", "y", "Z"][*axis], value.text()),
            Step::Move(axis, form, value) => format!("{}={form}({})\n", ["X", "Y", "z"][*axis], value.text()),
            Step::Incremental(on) => (if *on { "G91\n" } else { "g90\n" }).to_owned(),
            Step::Shift(adds, axis, value) => {
                format!("{} {}={}\n", if *adds { "ATRANS" } else { "trans" }, ["X", "Y", "Z"][*axis], value.text())
            }
            Step::ClearShift => "TRANS\n".to_owned(),
            Step::If(of, yes, no) => format!("IF {}\n{}ELSE\n{}ENDIF\n", of.text(), inner(yes), inner(no)),
            Step::For(counter, passes, body) => format!("FOR R{counter}=1 TO {passes}\n{}ENDFOR\n", inner(body)),
            Step::While(counter, passes, body) => {
                format!("R{counter}=0\nWHILE R{counter}<{passes}\nR{counter}=R{counter}+1\n{}ENDWHILE\n", inner(body))
            }
            Step::Until(counter, passes, body) => {
                format!("R{counter}=0\nREPEAT\nR{counter}=R{counter}+1\n{}UNTIL R{counter}>{passes}\n", inner(body))
            }
            Step::Skip(of, body) => format!("IF {} GOTOF ZU_{own}\n{}ZU_{own}: ; Ziel\n", of.text(), inner(body)),
            Step::Back(counter, passes, body) => format!(
                "R{counter}=0\nAUF_{own}:\n{}R{counter}=R{counter}+1\nIF R{counter}<={passes} GOTOB AUF_{own}\n",
                inner(body)
            ),
            Step::Again(body, times) => format!("TEIL_{own}:\n{}REPEAT TEIL_{own} P={times}\n", inner(body)),
            Step::Choose(of, one, other) => format!(
                "CASE {} OF 1 GOTOF EINS_{own} DEFAULT GOTOF REST_{own}\nEINS_{own}:\n{}GOTOF WEITER_{own}\nREST_{own}:\n{}WEITER_{own}:\n",
                of.text(),
                inner(one),
                inner(other)
            ),
            Step::Call(value, times) => format!("UNTER({}) P{times}\n", value.text()),
        };
        out.push_str(&text);
    }
}

/// What the moves are.
struct Machine {
    r: Vec<f64>,
    at: [f64; 3],
    shift: [f64; 3],
    incremental: bool,
    ends: Vec<[f64; 3]>,
}

impl Machine {
    fn go(&mut self, axis: usize, form: &str, value: f64) {
        let incremental = form == "IC" || self.incremental && form.is_empty();
        self.at[axis] = if incremental { self.at[axis] + value } else { value + self.shift[axis] };
        self.ends.push(self.at);
    }

    fn run(&mut self, steps: &[Step]) {
        for step in steps {
            // Long programs are not compared.
            if self.ends.len() > 3000 {
                return;
            }
            match step {
                Step::Assign(number, value) => self.r[*number] = value.of(&self.r).clamp(-50.0, 50.0),
                Step::Move(axis, form, value) => self.go(*axis, form, value.of(&self.r)),
                Step::Incremental(on) => self.incremental = *on,
                Step::Shift(adds, axis, value) => {
                    let value = value.of(&self.r);
                    if !adds {
                        self.shift = [0.0; 3];
                    }
                    self.shift[*axis] += value;
                }
                Step::ClearShift => self.shift = [0.0; 3],
                Step::If(of, yes, no) => self.run(if of.holds(&self.r) { yes } else { no }),
                Step::For(_, passes, body) | Step::While(_, passes, body) => (0..*passes).for_each(|_| self.run(body)),
                Step::Until(_, passes, body) | Step::Back(_, passes, body) | Step::Again(body, passes) => {
                    (0..=*passes).for_each(|_| self.run(body));
                }
                Step::Skip(of, body) => {
                    if !of.holds(&self.r) {
                        self.run(body);
                    }
                }
                Step::Choose(of, one, other) => self.run(if of.of(&self.r) == 1.0 { one } else { other }),
                Step::Call(value, times) => {
                    let argument = value.of(&self.r);
                    for _ in 0..*times {
                        self.r[5] = (self.r[5] + argument).clamp(-50.0, 50.0);
                        self.go(0, "AC", argument);
                    }
                }
            }
        }
    }
}

const SUBPROGRAM: &str = "proc unter(real a)\nR5=BOUND(-50,50,R5+A)\nX=AC(A)\nret\n";

fn files(name: &str) -> Option<Vec<u8>> {
    (name == "UNTER.SPF").then(|| SUBPROGRAM.into())
}

#[test]
fn random_programs_move_as_their_syntax_trees_say() {
    let options = Options::from(Dialect::Sinumerik);
    let (mut programs, mut moves) = (0, 0);
    for seed in 0..3000 {
        let mut maker = Maker { random: Random(seed * 7919 + 1), counter: 0 };
        let steps: Vec<Step> = (0..3).flat_map(|_| maker.steps(3)).collect();
        let mut text = String::from("G54 G90 G71\nG0 X0 Y0 Z0\n");
        for number in 1..=5 {
            let _ = writeln!(text, "R{number}={}", f64::from(number) - 2.5);
        }
        write(&steps, &mut 0, &mut text);
        text.push_str("M30\n");
        let r = (0..1000).map(|number| if (1..=5).contains(&number) { f64::from(number) - 2.5 } else { 0.0 }).collect();
        let mut machine = Machine { r, at: [0.0; 3], shift: [0.0; 3], incremental: false, ends: vec![[0.0; 3]] };
        machine.run(&steps);
        if machine.ends.len() > 3000 || machine.ends.iter().flatten().any(|value| value.abs() > 1e8) {
            continue;
        }
        let mut program = Dialect::Sinumerik.read(parse(text.as_str()));
        let flat = expand(&program, &options, &files).unwrap_or_else(|error| panic!("{seed}: {error}\n{text}"));
        evaluate(&mut program, &options, &files).unwrap_or_else(|error| panic!("{seed}: {error}\n{text}"));
        let flat = Dialect::Sinumerik.read(parse(flat));
        for read in [&program, &flat] {
            let path = interpret(read, &options).unwrap_or_else(|error| panic!("{seed}: {error}\n{text}"));
            let ends: Vec<[f64; 3]> = path.moves.iter().map(|step| step.end.nominal_mm()).collect();
            assert_eq!(ends.len(), machine.ends.len(), "{seed}\n{text}");
            let near = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
            let wrong = ends.iter().zip(&machine.ends).position(|(is, wanted)| !near(is, wanted));
            assert_eq!(wrong, None, "{seed}: {:?} {:?}\n{text}", wrong.map(|k| ends[k]), wrong.map(|k| machine.ends[k]));
        }
        programs += 1;
        moves += machine.ends.len();
    }
    println!("{programs} programs with {moves} moves agree");
    assert!(programs > 2000 && moves > 20_000, "{programs} {moves}");
}
