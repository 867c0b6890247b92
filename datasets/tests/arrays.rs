//! Logs as arrays of NumPy and MATLAB.

mod common;

use std::io::{Cursor, Write};

use common::assert_found;
use datasets::{Check, Log, ReadOptions, Report, Severity, log_from_bytes};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const SAMPLES: usize = 600;

/// Time in s, and commanded and actual X and Y in mm.
fn signals() -> [Vec<f64>; 5] {
    let column = |of: &dyn Fn(f64) -> f64| (0..SAMPLES).map(|k| of(k as f64 * 0.002)).collect::<Vec<f64>>();
    let (x, y) = (|t: f64| 20.0 * (6.0 * t).sin(), |t: f64| 5.0 * (9.0 * t).cos());
    [column(&|t| t), column(&x), column(&|t| x(t - 0.003)), column(&y), column(&|t| y(t - 0.003))]
}

/// An array file of NumPy, of doubles.
fn npy(values: &[f64], shape: &str, by_columns: bool) -> Vec<u8> {
    let order = if by_columns { "True" } else { "False" };
    let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    file
}

fn npz(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// An element of a MAT file, filled up to eight bytes.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), u32::try_from(data.len()).unwrap().to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// A matrix of doubles; its data column by column.
fn matrix(name: &str, rows: usize, values: &[f64]) -> Vec<u8> {
    let sizes = [rows, values.len() / rows].map(|size| u32::try_from(size).unwrap().to_le_bytes()).concat();
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let flags = [6_u32.to_le_bytes(), [0; 4]].concat();
    element(14, &[element(6, &flags), element(5, &sizes), element(1, name.as_bytes()), element(9, &data)].concat())
}

fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let flags = [2_u32.to_le_bytes(), [0; 4]].concat();
    let sizes = [1_u32.to_le_bytes(), 1_u32.to_le_bytes()].concat();
    let names: Vec<u8> = fields
        .iter()
        .flat_map(|(name, _)| {
            let mut name = name.as_bytes().to_vec();
            name.resize(8, 0);
            name
        })
        .collect();
    // The length of names is a short element: type and size in one word.
    let length = [0x0004_0005_u32.to_le_bytes(), 8_u32.to_le_bytes()].concat();
    let mut parts = [element(6, &flags), element(5, &sizes), element(1, name.as_bytes()), length, element(1, &names)].concat();
    parts.extend(fields.iter().flat_map(|(_, array)| array.clone()));
    element(14, &parts)
}

fn mat(elements: &[u8]) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file, Platform: PCWIN64".to_vec();
    file.resize(124, b' ');
    file.extend([0x00, 0x01, b'I', b'M']);
    file.extend(elements);
    file
}

fn packed(element: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(element).unwrap();
    let data = encoder.finish().unwrap();
    [&15_u32.to_le_bytes()[..], &u32::try_from(data.len()).unwrap().to_le_bytes(), &data].concat()
}

fn log(name: &str, bytes: Vec<u8>, columns: Option<&str>) -> (Log, Report) {
    log_from_bytes(name.as_ref(), bytes, &ReadOptions { columns: columns.map(str::to_owned), period_s: None }).unwrap()
}

fn assert_signals(log: &Log) {
    let [_, x_ref, x_act, y_ref, y_act] = signals();
    assert!((log.period_s() - 0.002).abs() < 1e-9);
    let (reference, actual) = (log.reference.columns(), log.actual.columns());
    for (found, wanted) in [(&reference[0], x_ref), (&actual[0], x_act), (&reference[1], y_ref), (&actual[1], y_act)] {
        assert_eq!(found.len(), SAMPLES);
        assert!(found.iter().zip(&wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-9));
    }
}

#[test]
fn vectors_of_numpy_are_columns() {
    let names = ["t", "x_ref", "x_act", "y_ref", "y_act"];
    let shape = format!("({SAMPLES},)");
    let mut arrays: Vec<(&str, Vec<u8>)> = names.into_iter().zip(signals().map(|signal| npy(&signal, &shape, false))).collect();
    arrays.push(("seed", npy(&[7.0], "()", false)));
    arrays.push(("gains", npy(&[1.0, 2.0, 3.0], "(3,)", false)));
    let (log, report) = log("run.npz", npz(&arrays), None);
    assert_signals(&log);
    assert_found(&report, Severity::Note, Check::Mended, "gains");
}

#[test]
fn channels_with_clocks_of_their_own_may_have_other_lengths() {
    let [t, x_ref, ..] = signals();
    let late: Vec<f64> = (0..SAMPLES / 2).map(|k| k as f64 * 0.004 + 0.001).collect();
    let x_act: Vec<f64> = late.iter().map(|t| 20.0 * (6.0 * t).sin()).collect();
    for (t, x_ref, late, x_act) in [(&t, &x_ref, &late, &x_act), (&late, &x_act, &t, &x_ref)] {
        let vector = |column: &Vec<f64>| npy(column, &format!("({},)", column.len()), false);
        let arrays = [
            ("t_cmd", vector(t)),
            ("x_cmd", vector(x_ref)),
            ("t_act", vector(late)),
            ("x_act", vector(x_act)),
            ("gains", vector(&vec![1.0; 3])),
        ];
        let (log, report) = log("run.npz", npz(&arrays), None);
        let same = log.reference.columns()[0].iter().zip(&log.actual.columns()[0]);
        assert!(same.into_iter().all(|(command, actual)| (command - actual).abs() < 720.0 * 16e-6 / 8.0 + 1e-9));
        assert!(log.len() + 2 >= t.len(), "{}", log.len());
        assert_found(&report, Severity::Note, Check::Timing, "x_act: joined to the clock of the command");
        assert_found(&report, Severity::Note, Check::Mended, "gains");
    }
}

#[test]
fn a_matrix_of_either_order_is_one_signal_a_column() {
    let signals = signals();
    let by_columns = signals.concat();
    let by_rows: Vec<f64> = (0..SAMPLES).flat_map(|k| signals.iter().map(move |signal| signal[k])).collect();
    let mapping = "t=run.1,x_ref=run.2,x_act=run.3,y_ref=run.4,y_act=run.5";
    let shape = format!("({SAMPLES}, 5)");
    for array in [npy(&by_columns, &shape, true), npy(&by_rows, &shape, false)] {
        assert_signals(&log("run.npz", npz(&[("run", array)]), Some(mapping)).0);
    }
    assert_signals(&log("run.mat", mat(&matrix("run", SAMPLES, &by_columns)), Some(mapping)).0);
}

#[test]
fn variables_and_fields_of_matlab_are_columns() {
    let names = ["t", "x_ref", "x_act", "y_ref", "y_act"];
    let plain: Vec<u8> = names.into_iter().zip(signals()).flat_map(|(name, signal)| matrix(name, SAMPLES, &signal)).collect();
    let as_rows: Vec<u8> =
        names.into_iter().zip(signals()).flat_map(|(name, signal)| packed(&matrix(name, 1, &signal))).collect();
    for elements in [plain, as_rows] {
        assert_signals(&log("run.mat", mat(&elements), None).0);
    }
    let fields: Vec<(&str, Vec<u8>)> = names.into_iter().zip(signals().map(|signal| matrix("", SAMPLES, &signal))).collect();
    let mapping = "t=log.t,x_ref=log.x_ref,x_act=log.x_act,y_ref=log.y_ref,y_act=log.y_act";
    assert_signals(&log("run.mat", mat(&structure("log", &fields)), Some(mapping)).0);
}

#[test]
fn damaged_arrays_are_refused_with_their_place() {
    let refused = |name: &str, bytes: Vec<u8>, said: &str| {
        let error = log_from_bytes(name.as_ref(), bytes, &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.starts_with(name) && error.contains(said), "{error}");
    };
    let whole = npz(&[("t", npy(&signals()[0], &format!("({SAMPLES},)"), false))]);
    refused("cut.npz", whole[..whole.len() / 2].to_vec(), "the archive is damaged");
    refused("short.npz", npz(&[("t", npy(&[1.0; 9], "(10,)", false))]), "array `t`: it is cut off");
    refused(
        "huge.npz",
        npz(&[("t", npy(&[1.0], "(4000000000,)", false))]),
        "4000000000 × 1 numbers are more than the file holds",
    );
    refused("empty.npz", npz(&[("t", npy(&[], "(0,)", false))]), "no array of numbers");
    refused("new.mat", b"MATLAB 7.3 MAT-file, Platform".to_vec(), "save it with `save -v7`");
    let hdf5 = [b"\x89HDF\r\n\x1a\n".as_slice(), &[0; 600]].concat();
    refused("run.h5", hdf5.clone(), "this is an HDF5 file; export the signals as Parquet or CSV");
    refused("run.mat", [vec![0; 512], hdf5].concat(), "save a MAT file of MATLAB with `save -v7`");
    let file = mat(&matrix("t", SAMPLES, &signals()[0]));
    refused("cut.mat", file[..200].to_vec(), "byte 128: ");
    let packed = mat(&packed(&matrix("t", SAMPLES, &signals()[0])));
    refused("cut.mat", packed[..packed.len() - 40].to_vec(), "the file ends");
    let mut wrong = packed;
    wrong[150] ^= 0xff;
    assert!(log_from_bytes("wrong.mat".as_ref(), wrong, &ReadOptions::default()).is_err());
}

#[test]
fn no_bytes_make_reading_panic_or_take_memory_beyond_the_file() {
    let [t, ..] = signals();
    let names = ["t", "x_ref", "x_act"];
    let vectors: Vec<u8> = names.iter().flat_map(|name| matrix(name, SAMPLES, &t)).collect();
    let packed_twice = mat(&packed(&packed(&matrix("t", SAMPLES, &t))));
    // Nothing is taken from an element that is compressed twice.
    assert!(log_from_bytes("run.mat".as_ref(), packed_twice, &ReadOptions::default()).is_err());
    let flags = [2_u32.to_le_bytes(), [0; 4]].concat();
    let sizes = [u32::MAX.to_le_bytes(); 4].concat();
    let huge = mat(&element(14, &[element(6, &flags), element(5, &sizes), element(1, b"s")].concat()));
    assert!(log_from_bytes("run.mat".as_ref(), huge, &ReadOptions::default()).is_err());
    for shape in ["(0, 4000000000)", "(4000000000, 0)", "(18446744073709551615, 18446744073709551615)"] {
        assert!(log_from_bytes("run.npz".as_ref(), npz(&[("t", npy(&[], shape, false))]), &ReadOptions::default()).is_err());
    }
    let shape = format!("({SAMPLES},)");
    let archive = npz(&names.map(|name| (name, npy(&t, &shape, false))));
    for whole in [mat(&vectors), mat(&packed(&matrix("t", SAMPLES, &t))), archive] {
        for k in 0..4000_usize {
            let mut bytes = whole.clone();
            // The places at the front, where sizes and names stand, and some of the rest.
            let at = if k % 2 == 0 { k / 2 % 400 } else { k * 7919 % bytes.len() };
            bytes[at] = bytes[at].wrapping_add([1, 255, 128, 64][k / 800 % 4]);
            let _ = log_from_bytes("run".as_ref(), bytes, &ReadOptions::default());
        }
    }
}
