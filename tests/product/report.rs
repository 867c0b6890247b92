//! The report page of every command that writes one: its data hold the sections, and the figures are those of the JSON.

use serde_json::Value;

use crate::common::{Folder, PART};

/// Largest page without its data, bytes.
const WITHOUT_DATA: usize = 250_000;

/// The data of a page.
pub fn data(folder: &Folder, name: &str) -> Value {
    let page = folder.read(name);
    let start = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let data = &page[start..start + page[start..].find("</script>").unwrap()];
    assert!(page.len() - data.len() < WITHOUT_DATA, "{}", page.len() - data.len());
    for loading in [" src=", "<link", "@import"] {
        assert!(!page.contains(loading), "{loading}");
    }
    serde_json::from_str(data).unwrap()
}

/// Titles of the sections of a group.
fn titles(page: &Value, group: usize) -> Vec<&str> {
    page["groups"][group]["sections"].as_array().unwrap().iter().map(|section| section["title"].as_str().unwrap()).collect()
}

pub fn section<'a>(page: &'a Value, group: usize, title: &str) -> &'a Value {
    let sections = page["groups"][group]["sections"].as_array().unwrap();
    sections.iter().find(|section| section["title"] == title).unwrap_or_else(|| panic!("{title}: {:?}", titles(page, group)))
}

/// Every one of `wanted` is a section of the first group.
fn has(page: &Value, wanted: &[&str]) {
    let titles = titles(page, 0);
    assert!(wanted.iter().all(|title| titles.contains(title)), "{titles:?} lack one of {wanted:?}");
}

/// What every page on runs of a path shows.
const OF_RUNS: [&str; 4] = ["Figures", "Where the error is", "Distribution of the error", "Spectrum of the error"];

#[test]
fn forecasts_before_and_after_a_compensation() {
    let folder = Folder::with_model();
    folder.write("part.nc", PART.replace("(ABOVE)", "(</script><b>)"));
    let words = ["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc", "--report", "page.html"];
    let figures = folder.figures(&words);
    let page = data(&folder, "page.html");
    has(&page, &OF_RUNS);
    has(
        &page,
        &["Reversals of axis x", "Reversals of axis y", "Learning curve", "Operating range", "Held-out errors of the model"],
    );
    let path = section(&page, 0, "Where the error is");
    let runs: Vec<&str> = path["runs"].as_array().unwrap().iter().map(|run| run["name"].as_str().unwrap()).collect();
    assert_eq!(runs, ["before", "after"]);
    for (run, when) in path["runs"].as_array().unwrap().iter().zip(["before", "after"]) {
        let max = figures["predicted_contour_um"][when]["max"].as_f64().unwrap();
        assert!((run["max_um"].as_f64().unwrap() - max).abs() < 1e-6, "{when}: {max}");
    }
    // The worst line is that with the largest error, with its text and a cause.
    let worst = &path["worst"][0][0];
    let max = figures["predicted_contour_um"]["before"]["max"].as_f64().unwrap();
    assert!((worst["max_um"][0].as_f64().unwrap() - max).abs() < 1e-6, "{worst}");
    assert!(!worst["why"].as_str().unwrap().is_empty());
    let lines = &path["lines"];
    let at = lines["numbers"].as_array().unwrap().iter().position(|number| number == &worst["line"]).unwrap();
    assert!(PART.contains(lines["texts"][at].as_str().unwrap()) && !lines["texts"][at].as_str().unwrap().is_empty());
    assert!(lines["texts"].as_array().unwrap().iter().any(|text| text.as_str().unwrap().contains("</script><b>")));
}

#[test]
fn a_forecast_and_a_measurement() {
    let folder = Folder::with_model();
    folder.figures(&["predict", "curve:crown", "-m", "machine.model", "--report", "forecast.html"]);
    has(&data(&folder, "forecast.html"), &OF_RUNS);
    folder.figures(&["simulate", "curve:circle", "-o", "circle.csv"]);
    let words = ["measure", "circle.csv", "--desired", "curve:circle", "-m", "machine.model", "--report", "run.html"];
    let figures = folder.figures(&words);
    let page = data(&folder, "run.html");
    has(&page, &OF_RUNS);
    has(&page, &["Circular test", "Does the model still fit?"]);
    let row = &section(&page, 0, "Circular test")["rows"][0];
    let circular = figures["circular_test"]["counterclockwise"]["circular_um"].as_f64().unwrap();
    assert!((row[1].as_str().unwrap().parse::<f64>().unwrap() - circular).abs() < 1e-3, "{row} {circular}");
    let path = section(&page, 0, "Where the error is");
    assert!((path["runs"][0]["max_um"].as_f64().unwrap() - figures["contour_um"]["max"].as_f64().unwrap()).abs() < 1e-6);
    // Without a program its places take the part of lines.
    assert_eq!(path["worst"][0][0]["line"], 0);
    folder.fails(
        2,
        &["measure", "circle.csv", "--desired", "curve:circle", "-m", "machine.model", "--readback", "--report", "no.html"],
    );
}

#[test]
fn the_runs_of_a_refinement() {
    let folder = Folder::with_model_and_part();
    folder.figures(&["simulate", "part.nc", "-o", "run.csv"]);
    let by_model = ["refine", "part.nc", "--log", "run.csv", "-m", "machine.model", "-o", "next.nc", "--report", "model.html"];
    folder.figures(&by_model);
    let page = data(&folder, "model.html");
    has(&page, &OF_RUNS);
    let names: Vec<&Value> =
        section(&page, 0, "Where the error is")["runs"].as_array().unwrap().iter().map(|run| &run["name"]).collect();
    assert_eq!(names, ["run 1", "next (forecast)"]);
    let by_law = ["--ran", "part.nc", "next.nc", "-o", "third.nc", "--machine", "ballscrew", "--report", "law.html"];
    folder.figures(&["simulate", "next.nc", "-o", "second.csv", "--seed", "2"]);
    folder.figures(&[&["refine", "part.nc", "--log", "run.csv", "second.csv"][..], &by_law].concat());
    has(&data(&folder, "law.html"), &["Run by run"]);
}

#[test]
fn a_trained_and_an_adapted_model() {
    let folder = Folder::with_model();
    for (index, curve) in ["curve:crown", "curve:flower", "curve:nurbs-1"].iter().enumerate() {
        folder.figures(&["simulate", curve, "-o", &format!("{index}.csv"), "--seed", &(60_000 + index).to_string()]);
    }
    let logs = ["train", "0.csv", "1.csv", "2.csv"];
    folder.figures(&[&logs[..], &["--predictor", "linear", "-o", "new.model", "--report", "train.html"]].concat());
    let page = data(&folder, "train.html");
    has(&page, &["Held-out errors of the model", "Prediction of axis x", "What is left over of axis y", "Operating range"]);
    let rated = section(&page, 1, "What the logs say about the machine");
    assert!(!rated["rows"].as_array().unwrap().is_empty() && page["groups"][1]["name"] == "Diagnosis", "{rated}");
    let lines = section(&page, 0, "Prediction of axis x")["lines"].as_array().unwrap();
    assert!(lines.iter().any(|line| line["name"] == "measured") && lines.iter().any(|line| line["name"] == "predicted"));
    folder.figures(&[&logs[..], &["--from", "machine.model", "-o", "adapted.model", "--report", "adapted.html"]].concat());
    let adapted = data(&folder, "adapted.html");
    has(&adapted, &["Adaptation", "Held-out errors of the model"]);
    assert_eq!(adapted["groups"][1]["name"], "Diagnosis");
}

#[test]
fn five_axes_show_the_direction_of_the_tool() {
    let folder = Folder::new();
    folder.figures(&["simulate", "curve:saddle", "--machine", "bc", "-o", "saddle.csv"]);
    folder.figures(&["measure", "saddle.csv", "--machine", "bc", "--report", "page.html"]);
    let page = data(&folder, "page.html");
    let path = section(&page, 0, "Where the error is");
    assert_eq!(path["tool"].as_array().unwrap().len(), 3);
    assert!(path["runs"][0]["turn_urad"]["length"].as_u64().unwrap() > 1000);
    let units: Vec<&Value> = path["axes"].as_array().unwrap().iter().map(|axis| &axis["unit"]).collect();
    assert!(units.contains(&&Value::from("µm")) && units.contains(&&Value::from("µrad")));
}
