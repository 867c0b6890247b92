//! From a log to a compensated program, on bytes alone. The built-in simulated machine provides the logs.

use datasets::{Log, ReadOptions, log_content, log_from_bytes};
use machine::MachineSpec;
use pipeline::training::{TrainSettings, train};
use pipeline::{Input, OutputSettings, Part, ReadSettings, Result, SILENT, Setup, excitation, model_based_ilc};
use training::Recipe;

fn compensated(logs: &[Vec<u8>], program: &[u8], machine: &MachineSpec) -> Result<Vec<u8>> {
    let read = |bytes: &Vec<u8>| Ok(log_from_bytes("run.csv".as_ref(), bytes.clone(), &ReadOptions::default())?.0);
    let logs: Vec<Log> = logs.iter().map(read).collect::<Result<_>>()?;
    let model = train(&logs, Some(machine), &TrainSettings::of(Recipe::builtin("linear")?, 1), SILENT)?.bundle;
    let setup = Setup::new(machine, None)?;
    let input = Input::from(Part::read("part.nc", program, &setup, &ReadSettings::default())?);
    let format = OutputSettings::new(&setup, None, None, None);
    let settings = model_based_ilc::Settings { written: format.program(), ..Default::default() };
    let outcome = model_based_ilc(&input, &model, &settings, SILENT)?;
    println!("{:.2} → {:.2} µm RMS", outcome.before.tip.rms_mm * 1e3, outcome.after.tip.rms_mm * 1e3);
    Ok(outcome.write(&input, &format, "out.nc".as_ref())?.content)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = MachineSpec::builtin("ballscrew")?;
    let logs = excitation::record(&machine, 20.0, excitation::TRAVEL_MM, 1)?;
    let bytes: Vec<Vec<u8>> = logs.iter().map(|log| log_content("run.csv".as_ref(), log)).collect::<Result<_, _>>()?;
    let program = b"G21 G90 G94 G17\nG0 X0 Y0 Z0\nG1 X20 F2400\nG3 X20 Y20 J10\nG1 X0\nG1 Y0\nM30\n";
    println!("{}", String::from_utf8_lossy(&compensated(&bytes, program, &machine)?));
    Ok(())
}
