//! Blocks without feed moves: modes, offsets, stops, comments.

use super::Writer;

impl Writer {
    pub fn modes_and_words(&mut self) {
        match self.random.below(26) {
            0 => self.distance(),
            1 => self.centres(),
            2 | 3 => self.select_plane(),
            4 => self.units(),
            5 => self.time(),
            6 | 7 => self.work_offset(),
            8..=10 => self.position_shift(),
            11 => self.data(),
            12 => self.tool_length(),
            13 => self.path_mode(),
            14 => {
                let words = ["G4".to_owned(), self.word('P', 0.25)];
                self.line(&words);
            }
            15 => self.raw("S700 M3"),
            16 => self.raw("M5"),
            17 => {
                let stop = self.random.pick(&["M0", "M1", "M60", "/ M1", "M9", "M8", "M7"]);
                self.raw(stop);
            }
            18 => {
                let change = self.random.pick(&["T1 M6", "T2", "T3 M6", "M6", "T0 M6", "M61 Q1"]);
                self.raw(change);
            }
            19 => {
                let text =
                    self.random.pick(&["(remark)", "; remark", "", "(MSG, turn the part)", "(DEBUG, #5420)", "  ", "(G1 X5)"]);
                self.raw(text);
            }
            20 => {
                let feed = 1500.0 / self.unit();
                let words = [self.word('F', feed)];
                if !self.inverse_time {
                    self.line(&words);
                }
            }
            21 => {
                let code = self.random.pick(&[
                    "M62 P1",
                    "M65 P2",
                    "M68 E0 Q0.5",
                    "M50 P0",
                    "M52 P1",
                    "M48",
                    "M53 P1",
                    "M66 P0 L0",
                    "M67 E1 Q2",
                ]);
                self.raw(code);
            }
            22 => {
                let assignment = self.random.pick(&["#100=5", "#<depth>=-3.5", "#1=[2+3] #2=4"]);
                self.raw(assignment);
            }
            23 => self.inverse(),
            24 => {
                let code = self.random.pick(&[
                    "G1",
                    "G0",
                    "G2",
                    "G80",
                    "G40",
                    "G49 G40",
                    "G94 G90.1\nG91.1",
                    "G97 S100",
                    "M70",
                    "G8",
                    "G98",
                    "G99",
                ]);
                self.raw(code);
                self.known &= !code.contains("G49");
                self.motion = "";
                self.absolute_centres &= !code.contains("G91.1");
                self.inverse_time &= !code.contains("G94");
            }
            _ => {
                let number = self.random.below(900);
                self.raw(&format!("N{number} (numbered)"));
            }
        }
    }

    /// Blocks that move the tool otherwise, or leave its position unknown.
    pub fn special(&mut self) {
        let block = self.random.pick(&[
            "G28",
            "G28 Z0",
            "G91 G28 Z0\nG90",
            "G30",
            "G28.1",
            "G30.1",
            "G53 G0 Z60",
            "G53 G1 X1 Y2 F900",
            "G38.2 Z-70 F300",
            "G38.3 Z-80 F300",
            "S100 M3\nG33 Z-4 K0.5\nG80",
            "G10 L2 P1 R10\nG1 X1 Y1 F900\nG10 L2 P1 R0",
            "M70\nG91\nM72",
            "M71\nG91.1\nG1 X2 F800",
            "G7\nG8",
            "G10 L1 P1 Z30",
            "G10 L10 P1 Z3\nG43",
            "G10 L11 P2 Z3",
            "/ G91",
            "/ G0 X1",
            "/ G1 Y2 F700",
            "G96 D500 S100\nG97",
            "G95\nS600 M3\nG1 X5 F0.3\nG94\nF1000",
            "G92 X0\n/ G92.1",
            "G43.2 H2",
            "#5220=2",
            "#5223=1.5",
            "M73\nG91\nM72",
        ]);
        if self.inverse_time && block.contains('F') {
            return;
        }
        self.raw(block);
        self.motion = "";
        self.known = false;
        self.incremental |= block.contains("G91\n") && !block.contains("G90") && !block.contains("M72");
        if self.random.chance(0.8) {
            let code = self.random.pick(&["G0", "G1"]);
            self.state_position(code);
        }
    }

    pub fn path_mode(&mut self) {
        let mode = self.random.pick(&["G61", "G61.1", "G64", "G64 P2", "G64 P5 Q1", "G64 P10 Q5", "G64 P0.1 Q0", "G64 Q2"]);
        // Hundredths of a millimetre.
        let length = |number: &str| number.parse::<f64>().map(|hundredths| format!("{:.5}", 0.01 * hundredths / self.unit()));
        let scaled = |word: &str| match word.split_at(1) {
            (letter @ ("P" | "Q"), number) => format!("{letter}{}", length(number).unwrap_or_default()),
            _ => word.to_owned(),
        };
        let mode: Vec<String> = mode.split(' ').map(scaled).collect();
        self.raw(&mode.join(" "));
    }

    fn distance(&mut self) {
        self.incremental = !self.incremental;
        self.raw(if self.incremental { "G91" } else { "G90" });
    }

    fn centres(&mut self) {
        self.absolute_centres = !self.absolute_centres;
        self.raw(if self.absolute_centres { "G90.1" } else { "G91.1" });
    }

    fn select_plane(&mut self) {
        self.plane = 17 + self.random.below(3);
        self.raw(&format!("G{}", self.plane));
    }

    fn units(&mut self) {
        if self.inverse_time {
            return;
        }
        let before = self.unit();
        self.inches = !self.inches;
        let scale = before / self.unit();
        self.at = self.at.map(|value| value * scale);
        // The feed in force is another in the new units.
        let feed = 1200.0 / self.unit();
        let words = [if self.inches { "G20" } else { "G21" }.to_owned(), self.word('F', feed)];
        self.line(&words);
    }

    /// Some blocks in inverse time.
    fn time(&mut self) {
        let was = self.inverse_time;
        self.inverse_time = true;
        self.raw("G93");
        for _ in 0..1 + self.random.below(3) {
            if self.random.chance(0.5) { self.feed_line() } else { self.arc() }
        }
        self.inverse_time = was;
        if !was {
            let feed = 1300.0 / self.unit();
            let words = ["G94".to_owned(), self.word('F', feed)];
            self.line(&words);
        }
    }

    fn inverse(&mut self) {
        self.inverse_time = !self.inverse_time;
        let feed = 1100.0 / self.unit();
        let words = ["G94".to_owned(), self.word('F', feed)];
        if self.inverse_time { self.raw("G93") } else { self.line(&words) }
    }

    fn work_offset(&mut self) {
        let code = self.random.pick(&["G54", "G55", "G56", "G59", "G59.1", "G59.3", "G54"]);
        self.raw(code);
        self.known = false;
        if self.random.chance(0.5) {
            self.state_position("G0");
        }
    }

    fn position_shift(&mut self) {
        let code = self.random.pick(&["G92", "G52", "G92.1", "G92.2", "G92.3", "G92", "G92 all"]);
        let value = self.random.between(-5.0, 5.0);
        match code {
            "G92 all" => {
                self.at = [value, 1.0, -2.0].map(|value| self.rounded(value));
                let at = self.at;
                let words = ["G92".to_owned(), self.word('X', at[0]), self.word('Y', at[1]), self.word('Z', at[2])];
                self.line(&words);
            }
            "G92" => {
                let axis = self.random.below(3);
                self.at[axis] = self.rounded(value);
                let at = self.at[axis];
                let words = ["G92".to_owned(), self.word(['X', 'Y', 'Z'][axis], at)];
                self.line(&words);
            }
            "G52" => {
                let words = ["G52".to_owned(), self.word('X', value)];
                self.line(&words);
                self.known = false;
            }
            other => {
                self.raw(other);
                self.known = false;
            }
        }
    }

    fn data(&mut self) {
        let level = self.random.pick(&["G10 L2", "G10 L20"]);
        let system = self.random.below(10);
        let value = self.random.between(-9.0, 9.0);
        let axis = self.random.pick(&['X', 'Y', 'Z']);
        let words = [format!("{level} P{system}"), self.word(axis, value)];
        self.line(&words);
        self.known = false;
    }

    fn tool_length(&mut self) {
        let code = self.random.pick(&["G43 H1", "G43 H2", "G49", "G43.1 Z5", "G43", "G43.1 X1 Z-2"]);
        self.raw(code);
        self.known = false;
    }
}
