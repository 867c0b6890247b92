//! Mutated inputs of every kind: each is read or refused, without a panic, within seconds and a bounded memory.
//!
//! Seed inputs are mutated with a seeded generator. `read` takes them in the process, by the readers of the library alone;
//! `run` gives them to the command under limits of CPU time and memory. What failed once is kept in `corpus/` and in [`seeds`].
//! A long run, and one input again, of which the failure prints the number:
//!
//! ```sh
//! FUZZ_COUNT=10000000 cargo test --release --test fuzz read -- --nocapture
//! FUZZ_COUNT=100000 FUZZ_SEED=7 cargo test --release --test fuzz run -- --nocapture
//! FUZZ_COUNT=1 FUZZ_SEED=4711 cargo test --release --test fuzz run -- --nocapture
//! ```

mod archive;
mod mutate;
mod read;
#[cfg(unix)]
mod run;
mod seeds;

use std::time::{Duration, Instant};

use rayon::prelude::*;

/// Inputs of a run in the gate, half a minute on two cores.
const READ: u64 = 4_000;
#[cfg(unix)]
const RUN: u64 = 250;
/// Longest time that reading an input may take.
const LONGEST: Duration = Duration::from_secs(5);

fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Calls `test` with as many numbers as asked for, and lists what it finds.
fn for_each_number(count: u64, test: impl Fn(u64) -> Option<String> + Sync) {
    let first = setting("FUZZ_SEED").unwrap_or(1);
    let count = setting("FUZZ_COUNT").unwrap_or(count);
    let faults: Vec<String> = (first..first + count)
        .into_par_iter()
        .filter_map(|number| test(number).map(|fault| format!("FUZZ_SEED={number} FUZZ_COUNT=1: {fault}")))
        .collect();
    assert!(faults.is_empty(), "{} of {count} inputs failed:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn read_mutated_inputs() {
    let seeds = seeds::all();
    for_each_number(READ, |number| {
        let (kind, bytes) = mutate::input(&seeds, number);
        let started = Instant::now();
        let result = std::panic::catch_unwind(|| read::read(kind, &bytes));
        let fault = match result {
            Err(_) => "panicked",
            Ok(()) if started.elapsed() > LONGEST => "took too long",
            Ok(()) => return None,
        };
        Some(format!("{kind:?} {fault}: {}", String::from_utf8_lossy(&bytes).chars().take(2000).collect::<String>()))
    });
}

#[cfg(unix)]
#[test]
fn run_mutated_inputs() {
    let seeds = seeds::all();
    for_each_number(RUN, |number| {
        let (kind, bytes) = mutate::input(&seeds, number);
        run::run(kind, &bytes)
    });
}

#[cfg(unix)]
#[test]
fn inputs_that_failed_once_are_refused() {
    for (name, kind, bytes) in seeds::failed_once() {
        let faults: Vec<String> =
            run::outcomes(kind, &bytes).into_iter().filter_map(|outcome| outcome.not_refused(&bytes)).collect();
        assert!(faults.is_empty(), "{name}: {}", faults.join("\n"));
    }
}
