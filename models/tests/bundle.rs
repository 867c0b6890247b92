//! The same model gives the same bundle bytes, a bundle is read back unchanged, and any change is
//! refused.

use std::io::{Cursor, Read, Write};

use models::narx::{Dense, PAST_ERRORS};
use models::recurrent::{Head, Kind, LayerWeights, Recurrent};
use models::staged::{self, FeatureGroup, LagBasis, MotionFactor, Pass, Scales, ServoBase, StagedPredictor};
use models::{
    AxisManifest, AxisPredictor, AxisSignal, Bundle, FORMAT, FeatureSet, FeatureSpec, HeldOut, Manifest, ModelError,
    NarxPredictor, NetworkPredictor, OperatingRange, PredictionInterval, Scaler,
};
use servo::Servo;
use sha2::{Digest, Sha256};
use zip::write::SimpleFileOptions;

const PERIOD_S: f64 = 0.002;

fn positions() -> Vec<f64> {
    (0..1500).map(|k| 10.0 * (f64::from(k) * 0.01).sin()).collect()
}

/// Distinct numbers between −0.3 and 0.3.
fn numbers(count: usize, start: usize) -> Vec<f32> {
    (0..count).map(|i| 0.3 * (((start + i) * 7919) as f32).sin()).collect()
}

fn predictors() -> Vec<Box<dyn AxisPredictor>> {
    let spec = FeatureSpec { set: FeatureSet::Iii, backlash_window: 20, start_window: 30, acceleration_max: 800.0 };
    let x = positions();
    let rows = spec.rows(&AxisSignal::uncompensated(&x, PERIOD_S));
    let inputs = Scaler::fit(std::iter::once(rows.as_slice()), spec.width());
    let targets = Scaler::fit(std::iter::once([0.1_f32, -0.1].as_slice()), 1);
    let (width, hidden) = (spec.width(), 3);
    let layer = LayerWeights {
        kind: Kind::Lstm,
        input: width,
        hidden,
        weight_ih: numbers(4 * hidden * width, 1),
        weight_hh: numbers(4 * hidden * hidden, 500),
        bias: numbers(4 * hidden, 700),
    };
    let head = Head { outputs: 1, weight: numbers(hidden, 800), bias: vec![0.1] };
    let network = Recurrent::new(vec![layer], head).expect("sizes fit");
    let lstm = NetworkPredictor::new(spec, inputs.clone(), targets.clone(), network).expect("sizes fit");
    let layers = vec![
        Dense { weight: numbers((width + PAST_ERRORS) * 4, 900), bias: numbers(4, 40) },
        Dense { weight: numbers(4, 50), bias: vec![0.0] },
    ];
    let narx = NarxPredictor::new(spec, inputs, targets, 5.0, layers).expect("sizes fit");
    vec![Box::new(lstm), Box::new(narx)]
}

fn manifest() -> Manifest {
    let x = positions();
    let signal = AxisSignal::uncompensated(&x, PERIOD_S);
    let axis = |name: &str, rotary| AxisManifest {
        name: name.into(),
        rotary,
        predictor: String::new(),
        settings: serde_json::Value::Null,
        held_out: HeldOut { rms: 1e-4, max: 1e-3, linear_rms: 3e-4, raw_rms: 0.05, band_held: 0.95, folds: 1, worst_window: 1.5 },
        coverage: OperatingRange::of(std::iter::once(x.as_slice()), PERIOD_S),
        band: PredictionInterval::fit(&[(signal, numbers(1500, 3).into_iter().map(f64::from).collect())], 50.0),
    };
    Manifest {
        format: FORMAT,
        version: "0.1.0".into(),
        date: Some("2026-11-24".into()),
        period_s: PERIOD_S,
        seed: 4,
        data_sha256: "00".into(),
        common_delay_s: 0.001,
        machine_toml: "name = \"mill\"\n".into(),
        limits_from_log: true,
        control: None,
        axes: vec![axis("x", false), axis("a", true)],
    }
}

fn bytes() -> Vec<u8> {
    Bundle::new(manifest(), &predictors()).and_then(|bundle| bundle.to_bytes()).expect("a sound bundle")
}

/// The two parts of a bundle.
fn parts(bytes: &[u8]) -> (String, Vec<u8>) {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("an archive");
    let mut part = |name: &str| {
        let mut content = Vec::new();
        archive.by_name(name).expect("a part").read_to_end(&mut content).expect("readable");
        content
    };
    (String::from_utf8(part("manifest.json")).expect("text"), part("weights.safetensors"))
}

/// A bundle of any parts, with a valid checksum.
fn packed(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in parts {
        archive.start_file(*name, stored).expect("a part");
        archive.write_all(content).expect("written");
    }
    with_checksum(archive)
}

fn with_checksum(mut archive: zip::ZipWriter<Cursor<Vec<u8>>>) -> Vec<u8> {
    archive.set_comment("0".repeat(64)).expect("a short comment");
    let mut bytes = archive.finish().expect("an archive").into_inner();
    let body = bytes.len() - 64;
    let checksum: String = Sha256::digest(&bytes[..body]).iter().map(|byte| format!("{byte:02x}")).collect();
    bytes[body..].copy_from_slice(checksum.as_bytes());
    bytes
}

fn refusal(bytes: &[u8]) -> String {
    Bundle::from_bytes(bytes).expect_err("it has to be refused").to_string()
}

#[test]
fn the_same_model_is_the_same_bytes_and_comes_back_whole() {
    let first = bytes();
    assert!(first == bytes(), "the bytes differ");
    let bundle = Bundle::from_bytes(&first).expect("a sound bundle");
    assert_eq!(bundle.manifest.axes[0].predictor, "lstm");
    assert_eq!(bundle.manifest.axes[1].predictor, "narx");
    assert_eq!(bundle.manifest.machine_toml, manifest().machine_toml);
    assert_eq!(bundle.manifest.axes[0].band, manifest().axes[0].band);
    let x = positions();
    let signal = AxisSignal::uncompensated(&x, PERIOD_S);
    for (loaded, original) in bundle.predictors().expect("sound predictors").iter().zip(predictors()) {
        assert_eq!(loaded.predict(&signal), original.predict(&signal));
        assert!(loaded.predict(&signal).iter().any(|error| *error != 0.0));
    }
    assert_eq!(bundle.machine().expect("a machine").period_s(), PERIOD_S);
}

#[test]
fn any_flipped_byte_is_refused() {
    let sound = bytes();
    for position in 0..sound.len() {
        let mut flipped = sound.clone();
        flipped[position] ^= 1 << (position % 8);
        assert!(Bundle::from_bytes(&flipped).is_err(), "byte {position}");
    }
    assert!(
        refusal(&{
            let mut flipped = sound.clone();
            flipped[sound.len() / 2] ^= 1;
            flipped
        })
        .contains("checksum")
    );
}

#[test]
fn truncated_and_foreign_files_are_refused() {
    let sound = bytes();
    for length in [0, 1, 63, 64, 65, sound.len() / 2, sound.len() - 1] {
        assert!(matches!(Bundle::from_bytes(&sound[..length]), Err(ModelError::Damaged(_))), "{length} bytes");
    }
    assert!(refusal(&[b'x'; 500]).contains("not a model bundle"));
}

#[test]
fn another_format_is_refused_by_its_number() {
    let (manifest, weights) = parts(&bytes());
    let other = manifest.replacen(&format!("\"format\": {FORMAT}"), "\"format\": 99", 1);
    let other = packed(&[("manifest.json", other.as_bytes()), ("weights.safetensors", &weights)]);
    assert!(matches!(Bundle::from_bytes(&other), Err(ModelError::Format { found: 99, expected: FORMAT })));
}

#[test]
fn a_date_that_could_change_a_program_is_refused() {
    let (manifest, weights) = parts(&bytes());
    for date in ["2026-11-24)", "2026-1-24", ")G0 Z-9", "2026-11-2\\n", ""] {
        let other = manifest.replacen("\"2026-11-24\"", &format!("\"{date}\""), 1);
        let other = packed(&[("manifest.json", other.as_bytes()), ("weights.safetensors", &weights)]);
        assert!(refusal(&other).contains("date: expected YYYY-MM-DD"), "{date}: {}", refusal(&other));
    }
    let without = manifest.replacen("  \"date\": \"2026-11-24\",\n", "", 1);
    assert_ne!(without, manifest);
    let without = packed(&[("manifest.json", without.as_bytes()), ("weights.safetensors", &weights)]);
    assert_eq!(Bundle::from_bytes(&without).expect("an older model").manifest.date, None);
}

/// A staged predictor of one pass: the velocity now.
fn staged() -> StagedPredictor {
    let group = FeatureGroup { basis: LagBasis::now(), channels: vec![MotionFactor::Velocity.into()] };
    let features = staged::FeatureSet { scales: Scales::linear(), groups: vec![group] };
    StagedPredictor::new(PERIOD_S, vec![Pass { features, weights: vec![0.01] }]).expect("sizes fit")
}

#[test]
fn a_servo_model_below_the_passes_is_stored_to_the_last_bit() {
    let servo = Servo { slips: true, ..Servo::usual(1e3 / 3.0, 0.7).with_places(-10.0, 1e2 / 7.0) };
    let on_servo = staged().on_servo(Some(ServoBase { servo, mm_per_unit: 1.0 })).expect("sound numbers");
    let mut of_one = manifest();
    of_one.axes.truncate(1);
    let one: Vec<Box<dyn AxisPredictor>> = vec![Box::new(on_servo.clone())];
    let bytes = Bundle::new(of_one, &one).and_then(|bundle| bundle.to_bytes()).expect("a sound bundle");
    let read = Bundle::from_bytes(&bytes).and_then(|bundle| bundle.predictors()).expect("it is read");
    assert_eq!(StagedPredictor::from_saved(&read[0].save()).expect("staged"), on_servo);

    // The passes predict what the model leaves.
    let wave: Vec<f64> = (0..2000).map(|k| 5.0 - 5.0 * (4.0 * PERIOD_S * f64::from(k)).cos()).collect();
    let signal = AxisSignal::uncompensated(&wave, PERIOD_S);
    let position = servo.follow(&wave, PERIOD_S);
    for (k, (with, passes)) in on_servo.predict(&signal).iter().zip(staged().predict(&signal)).enumerate() {
        assert!((with - (wave[k] - position[k] + passes)).abs() < 1e-12);
    }
    // A rotary axis on a lever of 100 mm; an unknown place on the machine.
    let lever = ServoBase { servo, mm_per_unit: 100.0 };
    let scaled: Vec<f64> = wave.iter().map(|x| x * 0.01).collect();
    let turned = lever.follow(&AxisSignal::uncompensated(&scaled, PERIOD_S));
    assert!(turned.iter().zip(&position).all(|(turned, x)| (100.0 * turned - x).abs() < 1e-9));
    let mut patchy = servo;
    patchy.levels[10] = 2.0;
    let somewhere = AxisSignal { placed: false, ..signal };
    assert_eq!(ServoBase { servo: patchy, mm_per_unit: 1.0 }.follow(&somewhere), position);
    assert!(staged().on_servo(Some(ServoBase { mm_per_unit: 0.0, ..lever })).is_err());

    let (manifest, weights) = parts(&bytes);
    // A model from before creep was known.
    let without = manifest.replacen("\"creep_mm_s\": 0.0,", "", 1);
    assert_ne!(without, manifest);
    let read = Bundle::from_bytes(&packed(&[("manifest.json", without.as_bytes()), ("weights.safetensors", &weights)]));
    assert!(read.and_then(|bundle| bundle.predictors()).is_ok());
    let mutated = manifest.replacen("\"bandwidth_1_s\": 2000.0", "\"bandwidth_1_s\": 1e300", 1);
    assert_ne!(mutated, manifest);
    let error = refusal(&packed(&[("manifest.json", mutated.as_bytes()), ("weights.safetensors", &weights)]));
    assert!(error.contains("servo model"), "{error}");
}

#[test]
fn numbers_that_overflow_or_take_gigabytes_are_refused_by_name() {
    let one: Vec<Box<dyn AxisPredictor>> = vec![Box::new(staged())];
    let mut of_one = manifest();
    of_one.axes.truncate(1);
    let of_one = Bundle::new(of_one, &one).and_then(|bundle| bundle.to_bytes()).expect("a sound bundle");
    for (sound, key, value) in [
        (bytes(), "start_window", "18446744073709551615"),
        (bytes(), "backlash_window", "9007199254740993"),
        (bytes(), "acceleration_max", "-1"),
        (bytes(), "period_s", "1e-300"),
        (bytes(), "common_delay_s", "1e300"),
        (bytes(), "raw_rms", "1e308"),
        (bytes(), "velocity", "-1"),
        (bytes(), "bound", "1e300"),
        (of_one.clone(), "first_lag", "-9223372036854775808"),
        (of_one.clone(), "first_lag", "100000000"),
        (of_one.clone(), "half_travel", "1e300"),
    ] {
        let (manifest, weights) = parts(&sound);
        let at = manifest.find(&format!("\"{key}\": ")).expect(key) + key.len() + 4;
        let end = at + manifest[at..].find([',', '\n']).expect("a value");
        let mutated = [&manifest[..at], value, &manifest[end..]].concat();
        let error = refusal(&packed(&[("manifest.json", mutated.as_bytes()), ("weights.safetensors", &weights)]));
        assert!(error.contains(key) && error.contains("train the model anew"), "{key} = {value}: {error}");
    }
}

#[test]
fn tensors_of_declared_sizes_are_refused() {
    let (manifest, weights) = parts(&bytes());
    // No value, and sizes whose product overflows.
    for shape in ["[0,4611686018427387904]", "[4611686018427387904,0]", "[144000000000,1]"] {
        let header_length = u64::from_le_bytes(*weights.first_chunk().expect("a length")) as usize;
        let mut header: serde_json::Value = serde_json::from_slice(&weights[8..8 + header_length]).expect("a header");
        let tensor = &mut header["x/layers.0.weight_hh"];
        tensor["shape"] = serde_json::from_str(shape).expect("a shape");
        let header = serde_json::to_vec(&header).expect("a header");
        let weights = [&(header.len() as u64).to_le_bytes()[..], &header, &weights[8 + header_length..]].concat();
        refusal(&packed(&[("manifest.json", manifest.as_bytes()), ("weights.safetensors", &weights)]));
    }
    let empty = LayerWeights {
        kind: Kind::Gru,
        input: usize::MAX / 2,
        hidden: usize::MAX / 3,
        weight_ih: Vec::new(),
        weight_hh: Vec::new(),
        bias: Vec::new(),
    };
    assert!(empty.check().is_err());
}

#[test]
fn compressed_parts_are_refused() {
    let (manifest, weights) = parts(&bytes());
    let deflated = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in [("manifest.json", manifest.as_bytes()), ("weights.safetensors", &weights)] {
        archive.start_file(name, deflated).expect("a part");
        archive.write_all(content).expect("written");
    }
    assert!(refusal(&with_checksum(archive)).contains("compressed"));
}

#[test]
fn missing_and_unknown_parts_are_refused_by_name() {
    let (manifest, weights) = parts(&bytes());
    let with = |manifest: &str| packed(&[("manifest.json", manifest.as_bytes()), ("weights.safetensors", &weights)]);
    assert!(Bundle::from_bytes(&with(&manifest)).is_ok(), "the packing itself is sound");
    assert!(refusal(&packed(&[("manifest.json", manifest.as_bytes())])).contains("weights.safetensors"));
    assert!(refusal(&packed(&[("weights.safetensors", &weights)])).contains("manifest.json"));
    assert!(refusal(&with(&manifest.replacen("\"seed\": 4,", "", 1))).contains("seed"));
    assert!(refusal(&with(&manifest.replacen("\"seed\": 4,", "\"seed\": 4, \"sead\": 4,", 1))).contains("sead"));
    assert!(refusal(&with(&manifest.replacen("\"lstm\"", "\"oracle\"", 1))).contains("oracle"));
    // An axis without weights, and weights without an axis.
    let renamed = manifest.replacen("\"name\": \"x\"", "\"name\": \"y\"", 1);
    assert!(refusal(&with(&renamed)).contains("belongs to no axis"));
    let dropped = safetensors::serialize(
        safetensors::SafeTensors::deserialize(&weights)
            .expect("tensors")
            .tensors()
            .into_iter()
            .filter(|(name, _)| name != "x/head.bias"),
        None,
    )
    .expect("tensors");
    let dropped = packed(&[("manifest.json", manifest.as_bytes()), ("weights.safetensors", &dropped)]);
    assert!(refusal(&dropped).contains("head.bias"));
}
