//! How much of the programs of others is read and may be shifted.
//!
//! ```sh
//! cargo test --release --test oracle coverage -- --ignored --nocapture
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use pipeline::refit::TimeEncoding;

use crate::compensate::{Way, lengths_mm, read, read_with};
use crate::rs274;

const WAY: Way = Way { controller: "linuxcnc", encoding: TimeEncoding::Keep, decimals: 6, block_delete: None };

#[test]
#[ignore = "a measurement: prints how many programs of LinuxCNC are read"]
fn coverage_of_the_programs_of_linuxcnc() {
    if crate::is_skipped() {
        return;
    }
    let (mut accepted, mut fed, mut read_count, mut expanded) = (0, 0, 0, 0);
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
        let in_place = read(&program, &WAY);
        expanded += usize::from(in_place.is_err());
        match in_place.or_else(|_| read_with(&program, &WAY, true)) {
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
            Err(error) => {
                expanded -= 1;
                let reason = error.to_string().lines().next().unwrap_or_default().to_owned();
                refusals.entry(reason).or_default().push(file.display().to_string());
            }
        }
    }
    for (reason, files) in &refusals {
        println!("refused: {}: {reason}: {}", files.len(), files.join(" "));
    }
    println!(
        "accepted by rs274: {accepted}; with feed moves: {fed}; read: {read_count}, of which {expanded} with --expand; refused: {}; \
         feed length of the programs read: {:.0} mm, shiftable: {:.0} mm",
        refusals.values().map(Vec::len).sum::<usize>(),
        lengths[0],
        lengths[1]
    );
}
