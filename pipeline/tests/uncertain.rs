//! A correction that saves less than the model's own error is none.

use machine::MachineSpec;
use models::Manifest;
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::model_based_ilc::{Outcome, Settings, Uncertain};
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
    assert!(sure.gained && sure.uncertain.is_none());
    let own = model.manifest.clone();
    // Errors as large as the one that is corrected: the forecast may be one of them.
    let doubtful = [3.0, 10.0, 30.0, 100.0].map(|times| {
        model.manifest = scaled(&own, times);
        learn(&model).1
    });
    let larger = |outcome: &Outcome| match outcome.uncertain {
        Some(Uncertain::Larger { own_mm, forecast_mm }) => {
            assert!(own_mm > forecast_mm && !outcome.gained && outcome.before == outcome.after);
            true
        }
        _ => false,
    };
    assert!(doubtful.iter().any(larger), "{:?}", doubtful.map(|outcome| outcome.uncertain));
    model.manifest = scaled(&own, 300.0);
    let (input, unsure) = learn(&model);
    assert!(!unsure.gained && unsure.reference == *input.trajectory(), "{:?}", unsure.uncertain);
    let Some(Uncertain::Grows { before_mm, after_mm }) = unsure.uncertain else { panic!("{:?}", unsure.uncertain) };
    assert!(after_mm > 0.99 * before_mm && before_mm > 0.01, "{before_mm} {after_mm}");
    assert_eq!(unsure.before, unsure.after);
}
