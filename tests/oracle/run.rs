//! One program before and after compensation, and the tally of many.

use std::collections::BTreeMap;
use std::sync::Mutex;

use pipeline::Error;
use pipeline::refit::TimeEncoding;

use crate::compare::{Allowed, compare};
use crate::compensate::{Way, read, write};
use crate::events::events;
use crate::rs274;

const CONTROLLERS: [&str; 2] = ["linuxcnc", "generic"];
const ENCODINGS: [TimeEncoding; 3] = [TimeEncoding::Keep, TimeEncoding::G93, TimeEncoding::G94];

/// Outcomes of many programs, each with its reason: the count, and the first examples.
#[derive(Default)]
pub struct Tally(Mutex<Counts>);

type Counts = BTreeMap<(Outcome, String), (usize, Vec<String>)>;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Compared,
    Unchanged,
    Refused,
    NotAccepted,
    Fault,
}

impl Tally {
    fn add(&self, outcome: Outcome, reason: &str, example: String) {
        let mut all = self.0.lock().unwrap();
        let (count, examples) = all.entry((outcome, reason.to_owned())).or_default();
        *count += 1;
        if examples.len() < 3 {
            examples.push(example);
        }
    }

    /// Prints the counts, and panics where a program differs. Returns how many `rs274` accepted.
    pub fn report(&self, what: &str) -> usize {
        let all = self.0.lock().unwrap();
        let count = |outcome| all.iter().filter(|((of, _), _)| *of == outcome).map(|(_, (count, _))| count).sum::<usize>();
        let total: usize = all.values().map(|(count, _)| count).sum();
        println!(
            "{what}: {total}; not accepted by rs274: {}; refused by precomp: {}; unchanged: {}; compensated and compared: {}; faults: {}",
            count(Outcome::NotAccepted),
            count(Outcome::Refused),
            count(Outcome::Unchanged),
            count(Outcome::Compared),
            count(Outcome::Fault)
        );
        for ((outcome, reason), (count, examples)) in all.iter().filter(|((of, _), _)| *of > Outcome::Unchanged) {
            println!("{count:5} {outcome:?}: {reason}\n      {}", examples.join("\n      "));
        }
        assert_eq!(count(Outcome::Fault), 0, "{what} differ after compensation");
        total - count(Outcome::NotAccepted)
    }
}

/// The program with an N word in every block that takes one, by which calls are assigned to blocks.
pub fn numbered(program: &str) -> String {
    let takes_number = |line: &str| match line.strip_prefix('(') {
        // Words behind a comment.
        Some(comment) => comment.split_once(')').is_some_and(|(_, words)| !words.trim().is_empty()),
        None => line.starts_with(|c: char| c.is_ascii_alphabetic() && !"oOnN".contains(c)),
    };
    let lines = program.split_inclusive('\n').zip(1..=99_999_usize);
    let mut text: String =
        lines.map(|(line, number)| if takes_number(line) { format!("N{number} {line}") } else { line.to_owned() }).collect();
    text.extend(program.split_inclusive('\n').skip(99_999));
    text
}

/// Compares a program with its compensated version, for both positions of the block-delete switch.
pub fn check(name: &str, program: &[u8], seed: u64, tally: &Tally) {
    let block_delete = [None, None, Some(false), Some(true)][seed as usize / 7 % 4];
    let way = Way {
        controller: CONTROLLERS[seed as usize % 2],
        encoding: ENCODINGS[seed as usize / 2 % 3],
        decimals: [4, 5, 6][seed as usize / 6 % 3],
        block_delete,
    };
    let before = match rs274::run(program, block_delete == Some(true)) {
        Ok(calls) => calls,
        Err(said) => return tally.add(Outcome::NotAccepted, said.split(" | ").nth(1).unwrap_or(&said), name.to_owned()),
    };
    let part = match read(program, &way) {
        Ok(part) => part,
        Err(error) => return tally.add(Outcome::Refused, &reason(&error), name.to_owned()),
    };
    let written = match write(part, &way, seed) {
        Ok(written) => written,
        Err(error) => {
            return tally.add(
                Outcome::Fault,
                &format!("cannot be written: {}", error_kind(&error)),
                format!("{name}: {error}: {}", source(&error)),
            );
        }
    };
    if written.bytes == program {
        return tally.add(Outcome::Unchanged, "", name.to_owned());
    }
    let allowed = Allowed {
        off_mm: written.off_mm,
        spacing_s: written.spacing_s,
        corner_mm: written.corner_mm,
        shiftable: &|line| written.shiftable.contains(&line),
        keeps_feeds: way.encoding == TimeEncoding::Keep,
    };
    let other = (block_delete.is_none()).then_some(true);
    let mut runs = vec![(block_delete == Some(true), Ok(before))];
    runs.extend(other.map(|on| (on, rs274::run(program, on))));
    for (on, before) in runs {
        let Ok(before) = before else { continue };
        let compared = rs274::run(&written.bytes, on).and_then(|after| compare(&events(&before), &events(&after), &allowed));
        if let Err(fault) = compared {
            let folder = std::env::var("ORACLE_KEEP").ok();
            if let Some(folder) = folder {
                let stem = name.replace(|c: char| !c.is_ascii_alphanumeric(), "-");
                std::fs::write(format!("{folder}/{stem}.in.ngc"), program).unwrap();
                std::fs::write(format!("{folder}/{stem}.out.ngc"), &written.bytes).unwrap();
            }
            let head: String =
                fault.lines().next().unwrap_or_default().chars().filter(|c| !c.is_ascii_digit()).take(60).collect();
            return tally.add(Outcome::Fault, &head, format!("{name} {way:?}, switch {on}: {fault}"));
        }
    }
    tally.add(Outcome::Compared, "", name.to_owned());
}

fn error_kind(error: &Error) -> String {
    format!("{error:?}").chars().take_while(|c| !c.is_ascii_digit()).take(40).collect()
}

fn source(error: &Error) -> String {
    std::error::Error::source(error).map_or(String::new(), ToString::to_string)
}

/// First line of a refusal without its numbers.
fn reason(error: &Error) -> String {
    error.to_string().lines().next().unwrap_or_default().chars().filter(|c| !c.is_ascii_digit()).collect()
}
