//! How much of the programs of others is read and may be shifted.
//!
//! ```sh
//! cargo test --release --test oracle coverage -- --ignored --nocapture
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use gcode::Dialect;
use pipeline::refit::TimeEncoding;

use crate::compensate::{Way, lengths_mm, read};
use crate::rs274;

const WAY: Way = Way { controller: "linuxcnc", encoding: TimeEncoding::Keep, decimals: 6, block_delete: None };

/// Refusals of parameters, O-words and subprograms, which are counted apart.
fn is_flow(program: &[u8]) -> bool {
    let program = gcode::parse(program);
    let Err(gcode::GcodeError::Refused { diagnostics }) = gcode::interpret(&program, &Dialect::LinuxCnc.into()) else {
        return false;
    };
    let flow = ["parameter", "subprogram", "loop", "jump", "flow"];
    diagnostics.iter().find(|d| d.is_error()).is_some_and(|d| flow.iter().any(|word| d.message.contains(word)))
}

#[test]
#[ignore = "a measurement: prints how many programs of LinuxCNC are read"]
fn coverage_of_the_programs_of_linuxcnc() {
    if crate::is_skipped() {
        return;
    }
    let (mut accepted, mut fed, mut read_count, mut flow) = (0, 0, 0, 0);
    let mut lengths = [0.0, 0.0];
    let mut refusals: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in crate::programs(Path::new("/usr/share/linuxcnc/ncfiles")) {
        let program = std::fs::read(&file).unwrap();
        let Ok(calls) = rs274::run(&program, false) else { continue };
        accepted += 1;
        if !calls.iter().any(|call| ["STRAIGHT_FEED", "ARC_FEED"].contains(&call.name.as_str())) {
            continue;
        }
        fed += 1;
        match read(&program, &WAY) {
            Ok(part) => {
                read_count += 1;
                let [all, shiftable] = lengths_mm(&part);
                lengths = [lengths[0] + all, lengths[1] + shiftable];
                println!(
                    "read: {}: {shiftable:.0} of {all:.0} mm of feeds can be shifted; left alone: {:?}",
                    file.display(),
                    part.fixed_moves()
                );
            }
            Err(_) if is_flow(&program) => flow += 1,
            Err(error) => {
                let reason = error.to_string().lines().next().unwrap_or_default().to_owned();
                refusals.entry(reason).or_default().push(file.display().to_string());
            }
        }
    }
    for (reason, files) in &refusals {
        println!("refused: {}: {reason}: {}", files.len(), files.join(" "));
    }
    println!(
        "accepted by rs274: {accepted}; with feed moves: {fed}; read: {read_count}; refused for parameters, O-words or subprograms: {flow}; \
         refused otherwise: {}; feed length of the programs read: {:.0} mm, shiftable: {:.0} mm",
        refusals.values().map(Vec::len).sum::<usize>(),
        lengths[0],
        lengths[1]
    );
}
