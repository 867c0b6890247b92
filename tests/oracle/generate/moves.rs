//! Feed moves, rapids, cycles and contours with cutter compensation.

use std::f64::consts::TAU;

use super::Writer;

/// Axes of a plane: first, second, normal.
fn axes(plane: usize) -> [usize; 3] {
    [[0, 1, 2], [2, 0, 1], [1, 2, 0]][plane - 17]
}

const LETTERS: [char; 3] = ['X', 'Y', 'Z'];
const CENTRES: [char; 3] = ['I', 'J', 'K'];

impl Writer {
    /// A coordinate near the origin, program units.
    fn coordinate(&mut self) -> f64 {
        let wide = self.random.between(-30.0, 30.0);
        let value = if self.random.chance(0.2) { wide.round() } else { wide };
        self.rounded(value / self.unit())
    }

    /// Words to `end` on the named axes; moves there.
    fn to(&mut self, end: [Option<f64>; 3]) -> Vec<String> {
        let mut words = Vec::new();
        for (axis, value) in end.iter().enumerate() {
            let Some(value) = value else { continue };
            let stated = if self.incremental { self.rounded(value - self.at[axis]) } else { self.rounded(*value) };
            self.at[axis] = if self.incremental { self.at[axis] + stated } else { stated };
            words.push(self.word(LETTERS[axis], stated));
        }
        words
    }

    /// A move to absolute coordinates on all axes.
    pub fn state_position(&mut self, code: &'static str) {
        if self.incremental {
            self.raw("G90");
            self.incremental = false;
        }
        let end = [(); 3].map(|()| Some(self.coordinate()));
        let mut words = vec![code.to_owned()];
        words.extend(self.to(end));
        if code == "G1" {
            words.extend(self.feed(30.0));
        }
        self.motion = code;
        self.known = true;
        self.line(&words);
    }

    /// F for a move of this length, mm.
    fn feed(&mut self, length_mm: f64) -> Option<String> {
        let rate = self.random.between(600.0, 4000.0).round();
        if self.inverse_time {
            return Some(self.word('F', (rate / length_mm.max(0.1)).max(0.5)));
        }
        let feed = rate / self.unit();
        (self.random.chance(0.3)).then(|| self.word('F', feed))
    }

    fn code(&mut self, code: &'static str) -> Option<String> {
        let stated = self.motion != code || self.random.chance(0.5);
        self.motion = code;
        let spelled = if self.random.chance(0.1) { code.replace('G', "G0") } else { code.to_owned() };
        stated.then_some(spelled)
    }

    /// Words beside a motion, of different modal groups.
    fn beside(&mut self, words: &mut Vec<String>) {
        for (share, of) in [
            (0.04, &["M8", "M7", "M9"][..]),
            (0.04, &["M5", "S500 M3", "S900"]),
            (0.03, &["M0", "M1", "M0"]),
            (0.02, &["T1", "T2"]),
            (0.02, &["M62 P1", "M63 P0", "M48", "M49"]),
            (0.02, &["G61", "G64", "G61.1"]),
            (0.01, &["G43 H1", "G49"]),
        ] {
            if self.random.chance(share) {
                let extra = self.random.pick(of);
                words.extend(extra.split(' ').map(str::to_owned));
                self.known &= !extra.contains("G4");
            }
        }
    }

    pub fn feed_line(&mut self) {
        let mut end = [None; 3];
        for value in &mut end {
            if self.random.chance(0.6) {
                *value = Some(self.coordinate());
            }
        }
        if end.iter().all(Option::is_none) {
            end[self.random.below(3)] = Some(self.coordinate());
        }
        let from = self.at;
        let code = self.code("G1");
        let to = self.to(end);
        let length = (0..3).map(|k| (self.at[k] - from[k]).powi(2)).sum::<f64>().sqrt() * self.unit();
        let feed = self.feed(length);
        let mut words: Vec<String> = code.into_iter().chain(to).chain(feed).collect();
        self.beside(&mut words);
        if self.random.chance(0.03) {
            words.insert(0, "/".to_owned());
            self.known = false;
            self.line(&words);
        } else {
            self.shuffled(words);
        }
    }

    pub fn rapid(&mut self) {
        let code = self.code("G0");
        let mut end = [None; 3];
        let axis = self.random.below(3);
        end[axis] = Some(self.coordinate());
        let to = self.to(end);
        let words: Vec<String> = code.into_iter().chain(to).collect();
        self.shuffled(words);
    }

    pub fn arc(&mut self) {
        if !self.known {
            return self.state_position("G1");
        }
        let [first, second, normal] = axes(self.plane);
        let radius = self.random.between(2.0, 15.0) / self.unit();
        let from = self.random.between(0.0, TAU);
        let left = self.random.chance(0.5);
        let full = self.random.chance(0.1);
        let sweep = if full { TAU } else { self.random.between(0.2, 5.5) } * if left { 1.0 } else { -1.0 };
        let centre = [self.at[first] - radius * from.cos(), self.at[second] - radius * from.sin()];
        let offset = [self.rounded(centre[0] - self.at[first]), self.rounded(centre[1] - self.at[second])];
        let start = self.at;
        let mut end = [None; 3];
        if !full {
            end[first] = Some(centre[0] + radius * (from + sweep).cos());
            end[second] = Some(centre[1] + radius * (from + sweep).sin());
        }
        if self.random.chance(0.2) {
            end[normal] = Some(self.at[normal] + self.random.between(-4.0, 4.0) / self.unit());
        }
        let code = self.code(if left { "G3" } else { "G2" });
        let to = self.to(end);
        let mut words: Vec<String> = code.into_iter().chain(to).collect();
        if !full && sweep.abs() < 3.0 && self.random.chance(0.3) {
            words.push(self.word('R', radius));
        } else {
            let from_zero = if self.absolute_centres { [start[first], start[second]] } else { [0.0; 2] };
            words.push(self.word(CENTRES[first], from_zero[0] + offset[0]));
            words.push(self.word(CENTRES[second], from_zero[1] + offset[1]));
        }
        if self.random.chance(0.1) {
            words.push(format!("P{}", 1 + self.random.below(3)));
        }
        words.extend(self.feed(radius * sweep.abs() * self.unit()));
        if !words.iter().any(|word| word.starts_with('P')) {
            self.beside(&mut words);
        }
        self.shuffled(words);
    }

    /// A series of canned cycles in G17.
    pub fn cycles(&mut self) {
        if self.inverse_time {
            return;
        }
        if self.plane != 17 {
            self.raw("G17");
            self.plane = 17;
        }
        self.state_position("G0");
        let unit = self.unit();
        let level = self.random.pick(&["G98", "G99"]);
        let cycle = self.random.pick(&["G81", "G82 P0.1", "G83 Q1.5", "G85", "G89 P0.05", "G73 Q1", "G86 P0.1", "G81", "G81 L2"]);
        if cycle.contains("G86") {
            self.raw("M3 S300");
        }
        let (top, bottom) = (self.random.between(1.0, 5.0) / unit, -self.random.between(1.0, 9.0) / unit);
        let mut words = vec![level.to_owned(), cycle.to_owned()];
        words.extend([self.word('X', 3.0 / unit), self.word('Z', bottom), self.word('R', top), self.word('F', 900.0 / unit)]);
        self.line(&words);
        for _ in 0..self.random.below(3) {
            let words = [self.word('X', 9.0 / unit), self.word('Y', -3.5 / unit)];
            self.line(&words);
        }
        self.raw("G80");
        (self.known, self.motion) = (false, "");
        let code = self.random.pick(&["G0", "G1"]);
        self.state_position(code);
    }

    /// A square with cutter compensation.
    pub fn contour(&mut self) {
        if self.inverse_time || self.plane != 17 || self.incremental {
            return;
        }
        let unit = self.unit();
        let side = self.random.pick(&["G41 D3", "G42 D3", "G41.1 D0.01"]);
        self.state_position("G1");
        self.line(&["G1".to_owned(), format!("X{}", self.rounded(-60.0 / unit)), format!("Y{}", self.rounded(-60.0 / unit))]);
        self.raw(side);
        for (x, y) in [(-40.0, -40.0), (40.0, -40.0), (40.0, 40.0), (-40.0, 40.0), (-40.0, -20.0)] {
            let words = [self.word('X', x / unit), self.word('Y', y / unit)];
            self.line(&words);
        }
        let off = self.random.pick(&["G40", "G40 G1 X0 Y0", "G40\nG0 X1"]);
        self.raw(off);
        self.motion = "";
        self.known = false;
        self.state_position("G1");
    }

    pub fn rotary(&mut self) {
        let words = ["G1".to_owned(), self.word('A', 33.0), self.word('F', 500.0)];
        if !self.inverse_time {
            self.motion = "G1";
            self.line(&words);
        }
    }
}
