//! How much of LinuxCNC's sample programs is read and may be shifted.
//!
//! ```sh
//! cargo test --release --test oracle coverage -- --nocapture
//! ```
//!
//! `ORACLE_FOLDER=linuxcnc/tests/interp` counts the programs of another folder.

use std::collections::BTreeMap;
use std::path::Path;

use gcode::parse;
use pipeline::refit::TimeEncoding;

use crate::compensate::{Way, lengths_mm, read, read_with};
use crate::rs274;

const WAY: Way = Way { controller: "linuxcnc", encoding: TimeEncoding::Keep, decimals: 6, block_delete: None };
/// Lines, arcs and splines. Cycles make feed moves without them.
const FEED_CODES: [f64; 6] = [1.0, 2.0, 3.0, 5.0, 5.1, 5.2];
/// Least share of milling programs with feed moves of their own that is read, percent: with LinuxCNC 2.9, 14 of 14 are.
const LEAST_READ: usize = 90;

/// What became of the programs that the interpreter accepts.
#[derive(Default)]
struct Coverage {
    accepted: usize,
    read: usize,
    /// Those of the programs read that are read with `--expand` alone.
    expanded: usize,
    /// Feed length of the programs read, and that of their moves that may be shifted, mm.
    lengths_mm: [f64; 2],
    /// Programs by the reason why they are refused.
    refused: BTreeMap<String, Vec<String>>,
    /// Programs with feed moves that do not count.
    lathe: Vec<String>,
    cycles: Vec<String>,
}

impl Coverage {
    fn add(&mut self, file: &Path) {
        let program = std::fs::read(file).unwrap();
        let Ok(calls) = rs274::run(&program, false) else { return };
        self.accepted += 1;
        let name = file.display().to_string();
        if !calls.iter().any(|call| ["STRAIGHT_FEED", "ARC_FEED"].contains(&call.name.as_str())) {
            return;
        }
        if name.contains("lathe") {
            self.lathe.push(name);
        } else if !has_feed_code(&program) {
            self.cycles.push(name);
        } else {
            self.read(name, &program);
        }
    }

    fn read(&mut self, name: String, program: &[u8]) {
        let in_place = read(program, &WAY);
        let is_expanded = in_place.is_err();
        match in_place.or_else(|_| read_with(program, &WAY, true)) {
            Ok(part) => {
                self.read += 1;
                self.expanded += usize::from(is_expanded);
                let [all, shiftable] = lengths_mm(&part);
                self.lengths_mm = [self.lengths_mm[0] + all, self.lengths_mm[1] + shiftable];
                println!(
                    "read: {name}: {shiftable:.0} of {all:.0} mm of feeds can be shifted; left alone: {:?}",
                    part.fixed_moves()
                );
            }
            Err(error) => {
                let reason = error.to_string().lines().next().unwrap_or_default().to_owned();
                self.refused.entry(reason).or_default().push(name);
            }
        }
    }

    /// Prints the figures. Returns the number of programs that count.
    fn report(&self) -> usize {
        for (reason, files) in &self.refused {
            println!("refused: {}: {reason}: {}", files.len(), files.join(" "));
        }
        println!("not counted: for a lathe: {}; feeds of cycles alone: {}", self.lathe.join(" "), self.cycles.join(" "));
        let refused: usize = self.refused.values().map(Vec::len).sum();
        let counted = self.read + refused;
        println!(
            "accepted by rs274: {}; for milling, with feed moves of their own: {counted}; read: {}, of which {} with --expand; \
             refused: {refused}; feed length of the programs read: {:.0} mm, shiftable: {:.0} mm",
            self.accepted, self.read, self.expanded, self.lengths_mm[0], self.lengths_mm[1]
        );
        counted
    }
}

fn has_feed_code(program: &[u8]) -> bool {
    parse(program).words().iter().any(|word| word.is(b'G') && FEED_CODES.contains(&word.value))
}

#[test]
fn coverage_of_the_programs_of_linuxcnc() {
    let folder = std::env::var("ORACLE_FOLDER").unwrap_or(crate::SAMPLES.into());
    let files = crate::programs(Path::new(&folder));
    if crate::is_skipped() {
        return;
    }
    if files.is_empty() {
        println!("skipped: no programs in {folder}");
        return;
    }
    let mut coverage = Coverage::default();
    files.iter().for_each(|file| coverage.add(file));
    let counted = coverage.report();
    assert!(coverage.read * 100 >= counted * LEAST_READ, "{} of {counted} programs are read", coverage.read);
}
