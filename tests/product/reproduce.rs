//! The papers' results, as `reproduce` prints them, and the page of all of them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

use serde_json::Value;

use crate::common::Folder;

/// Figures, page and pictures of the tables that take seconds.
static CHEAP: LazyLock<(Value, String, BTreeMap<String, String>)> = LazyLock::new(|| {
    let folder = Folder::new();
    let figures = folder.figures(&["reproduce", "circle", "spatial", "overshoot", "table-1", "raster", "--page", "papers.md"]);
    (figures, folder.read("papers.md"), pictures(&folder.path("papers-figures")))
});

/// The files of a folder with their content.
fn pictures(folder: &Path) -> BTreeMap<String, String> {
    let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap());
    files.map(|file| (file.file_name().into_string().unwrap(), std::fs::read_to_string(file.path()).unwrap())).collect()
}

/// The tables of one paper with this name.
fn tables<'a>(figures: &'a Value, paper: &str, name: &str) -> Vec<&'a Value> {
    let all = figures["tables"].as_array().unwrap().iter();
    all.filter(|table| table["paper"] == paper && table["table"] == name).collect()
}

/// From single axes to the contour alone the contour error falls below this share, and the axes' errors grow.
fn trades_time_for_contour(table: &Value, share: f64) {
    let rows = table["rows"].as_array().unwrap();
    let figure = |row: usize, name: &str| rows[row][name].as_f64().unwrap();
    let last = rows.len() - 1;
    assert_eq!((figure(0, "a"), figure(last, "a")), (0.0, 1.0));
    assert!(figure(last, "across_rms_um") < share * figure(0, "across_rms_um"), "{table}");
    assert!(figure(last, "axis_rms_um") > figure(0, "axis_rms_um"), "{table}");
    assert!(figure(last, "effort_rms_um") < figure(0, "effort_rms_um"), "{table}");
}

#[test]
fn contour_learning_beats_axis_learning_on_the_raster_scan() {
    let table = tables(&CHEAP.0, "E", "figures 4, 5, 8")[0];
    trades_time_for_contour(table, 0.75);
    let rows = table["rows"].as_array().unwrap();
    assert!(rows[4]["contour_rms_um"].as_f64().unwrap() < rows[0]["contour_rms_um"].as_f64().unwrap(), "{table}");
    assert!(rows[0]["permitted_model_error"].as_f64().unwrap() > 0.5, "{table}");
}

/// `cargo test --release --test product testbed -- --ignored`
#[test]
#[ignore = "a minute of conjugate gradients"]
fn paper_es_testbed_shows_its_trade_its_corner_and_its_tuning_rules() {
    let figures = Folder::new().figures(&["reproduce", "testbed"]);
    trades_time_for_contour(tables(&figures, "E", "figures 4, 5, 8")[0], 0.85);
    let corners = tables(&figures, "E", "figure 6")[0]["rows"].as_array().unwrap();
    for side in ["before_rms_um", "after_rms_um"] {
        assert!(corners[1][side].as_f64().unwrap() < corners[0][side].as_f64().unwrap(), "{side}");
    }
    let rules = tables(&figures, "E", "section III")[0]["rows"].as_array().unwrap();
    let measured: Vec<f64> = rules.iter().map(|rule| rule["measured"].as_f64().unwrap()).collect();
    let [_, deadbeat, of_r, of_s, quick_noise, slow_noise] = measured[..] else { panic!("{rules:?}") };
    assert!((deadbeat - 1.0).abs() < 1e-3 && (of_r - 1.0).abs() < 1e-3, "{rules:?}");
    assert!(of_s > 1.05 && slow_noise < 0.7 * quick_noise, "{rules:?}");
}

#[test]
fn estimators_stand_in_paper_ds_order_where_its_setting_is_inferred() {
    let found = tables(&CHEAP.0, "D", "I");
    let table = found.last().unwrap();
    let max = |name: &str| {
        let row = table["rows"].as_array().unwrap().iter().find(|row| row["name"] == name).unwrap();
        row["measured"]["max_um"].as_f64().unwrap()
    };
    assert!(max("spline-search") < max("circle") && max("circle") < max("tangent"), "{table}");
    assert!(max("spline-search") < 5.5 && max("exact") < 0.01, "{table}");
}

#[test]
fn spatial_learning_converges_below_a_gain_of_two_and_tracking_with_a_new_plan_does_not() {
    let rows = tables(&CHEAP.0, "A", "ellipse and flower")[0]["rows"].as_array().unwrap();
    for row in rows {
        let runs: Vec<f64> = row["rms_by_run_um"].as_array().unwrap().iter().map(|rms| rms.as_f64().unwrap()).collect();
        let name = row["name"].as_str().unwrap();
        let diverges = name.contains("2.2") || name.contains("tracking");
        assert_eq!(runs[runs.len() - 1] > runs[0], diverges, "{name}: {runs:?}");
    }
    assert_eq!(rows.len(), 12);
}

/// Values of a page by chapter, section and row: what is printed and what is measured.
fn values(page: &str) -> BTreeMap<[String; 3], [String; 2]> {
    let (mut chapter, mut section, mut found) = (String::new(), String::new(), BTreeMap::new());
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            chapter = title.to_owned();
        } else if let Some(title) = line.strip_prefix("### ") {
            section = title.to_owned();
        } else if let [_, what, unit, printed, measured, _, _, _] = line.split('|').map(str::trim).collect::<Vec<_>>()[..] {
            let key = [chapter.clone(), section.clone(), format!("{what} {unit}")];
            assert!(found.insert(key, [printed.to_owned(), measured.to_owned()]).is_none(), "twice: {section}: {line}");
        }
    }
    found
}

/// Whether two measured values agree: within 10 % or 0.02 of the unit. Times are those of the machine at hand.
fn agree(unit: &str, one: &str, other: &str) -> bool {
    match (one.parse::<f64>(), other.parse::<f64>()) {
        (Ok(one), Ok(other)) => unit.ends_with("ns a sample") || (one - other).abs() <= f64::max(0.02, 0.1 * other.abs()),
        _ => one == other,
    }
}

/// Sections of `made` are those of the committed page: the same rows and printed values, and measured values that agree.
fn compare(made: &str) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/papers.md");
    let (committed, made) = (values(&std::fs::read_to_string(path).unwrap()), values(made));
    let remade = "docs/papers.md is stale; make it anew with the command that it names";
    for (key, [printed, measured]) in &made {
        let [expected_printed, expected] = committed.get(key).unwrap_or_else(|| panic!("{key:?}: {remade}"));
        assert_eq!(printed, expected_printed, "{key:?}: {remade}");
        assert!(agree(&key[2], measured, expected), "{key:?}: {measured}, committed {expected}: {remade}");
    }
    let sections: Vec<_> = made.keys().map(|key| &key[..2]).collect();
    for key in committed.keys().filter(|key| sections.contains(&&key[..2])) {
        assert!(made.contains_key(key), "{key:?}: {remade}");
    }
    assert!(!made.is_empty());
}

#[test]
fn cheap_sections_of_the_papers_page_are_up_to_date() {
    compare(&CHEAP.1);
}

/// Pictures that a page shows.
fn shown(page: &str) -> BTreeSet<String> {
    let links = page.split("](papers-figures/").skip(1);
    links.map(|rest| rest.split(')').next().unwrap().to_owned()).collect()
}

#[test]
fn pictures_of_the_papers_page_are_there_small_and_of_the_same_lines() {
    /// Largest picture, bytes.
    const LARGEST: usize = 100_000;
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let committed = pictures(&docs.join("papers-figures"));
    let page = std::fs::read_to_string(docs.join("papers.md")).unwrap();
    assert_eq!(shown(&page), committed.keys().cloned().collect());
    let (_, page, made) = &*CHEAP;
    assert_eq!(shown(page), made.keys().cloned().collect());
    for (name, picture) in made.iter().chain(&committed) {
        assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n") && picture.len() < LARGEST, "{name}");
    }
    for (name, picture) in made {
        let lines = |picture: &str| picture.matches("<polyline ").count();
        assert!(lines(picture) > 0);
        assert_eq!(lines(picture), lines(&committed[name]), "{name}");
    }
}

/// `cargo test --release --test product s_shaped -- --ignored`
#[test]
#[ignore = "trains a five-axis model and learns for two minutes"]
fn the_first_run_of_the_s_shaped_test_piece_loses_nine_tenths_of_its_error() {
    let figures = Folder::new().figures(&["reproduce", "five-axis"]);
    let rows = tables(&figures, "C", "S-shaped test piece")[0]["rows"].as_array().unwrap();
    let figure = |row: usize, name: &str| rows[row]["measured"][name].as_f64().unwrap();
    for name in ["mean_um", "max_um", "max_before_end_um", "orientation_mean_urad", "orientation_max_urad"] {
        assert!(figure(2, name) < 0.1 * figure(0, name), "{name}: {rows:?}");
    }
}

/// Runs the command that the page names. `cargo test --release --test product papers_page -- --ignored`
#[test]
#[ignore = "trains models: many minutes"]
fn the_whole_papers_page_is_up_to_date() {
    let committed = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/papers.md")).unwrap();
    let command = committed.split('`').find_map(|text| text.strip_prefix("precomp ")).unwrap();
    let folder = Folder::new();
    folder.figures(&command.split(' ').collect::<Vec<_>>());
    let made = folder.read("FILE.md");
    compare(&made);
    assert_eq!(values(&made).len(), values(&committed).len());
}
