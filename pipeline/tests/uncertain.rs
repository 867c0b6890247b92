//! A correction that saves less than the model's own error is none.

use machine::MachineSpec;
use models::Manifest;
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::model_based_ilc::Settings;
use pipeline::training::{TrainSettings, train};
use pipeline::{Input, OutputFormat, OutputSettings, Part, ReadSettings, Recipe, SILENT, Setup, model_based_ilc};

/// The manifest with errors of every regime as many times as large.
fn scaled(manifest: &Manifest, times: f64) -> Manifest {
    let mut value = serde_json::to_value(manifest).unwrap();
    for axis in value["axes"].as_array_mut().unwrap() {
        for rms in axis["band"]["spread"]["rms"].as_array_mut().unwrap() {
            *rms = (times * rms.as_f64().unwrap()).into();
        }
    }
    serde_json::from_value(value).unwrap()
}

#[test]
fn what_saves_less_than_the_models_error_changes_nothing() {
    let spec = MachineSpec::builtin("ballscrew").unwrap();
    let settings = TrainSettings::of(Recipe::builtin("linear").unwrap(), 1);
    let mut model = train(&record(&spec, 20.0, TRAVEL_MM, 3).unwrap(), Some(&spec), &settings, SILENT).unwrap().bundle;
    let setup = Setup::new(&spec, None).unwrap();
    let program = "G21 G90 G94 G17\nG0 X0. Y0. Z0.\nG1 X5. Y7. F1500\nX-3. Y9.\nG2 X7. Y9. I5. J0.\nM2\n";
    let learn = |model: &_| {
        let input: Input =
            Part::read("p.nc", program, &setup, &ReadSettings { at_zero: true, ..Default::default() }).unwrap().into();
        let written = OutputSettings::new(&setup, None::<OutputFormat>, None, None).program();
        let outcome = model_based_ilc(&input, model, &Settings { written, ..Settings::default() }, SILENT).unwrap();
        (input, outcome)
    };
    let (_, sure) = learn(&model);
    assert!(sure.gained && sure.uncertain_mm.is_none());
    model.manifest = scaled(&model.manifest, 300.0);
    let (input, unsure) = learn(&model);
    assert!(!unsure.gained && unsure.reference == *input.trajectory(), "{:?}", unsure.uncertain_mm);
    let [before, after] = unsure.uncertain_mm.unwrap();
    assert!(after > 0.99 * before && before > 0.01, "{before} {after}");
    assert_eq!(unsure.before, unsure.after);
}
