//! The papers' orders of results, as `reproduce` prints them.

use crate::common::Folder;

#[test]
fn contour_learning_beats_axis_learning_on_the_raster_scan() {
    let folder = Folder::new();
    let figures = folder.figures(&["reproduce", "raster"]);
    let rows = figures["tables"][0]["rows"].as_array().unwrap();
    let figure = |row: usize, name: &str| rows[row][name].as_f64().unwrap();
    let last = rows.len() - 1;
    assert_eq!((figure(0, "a"), figure(last, "a")), (0.0, 1.0));
    assert!(figure(last, "across_rms_um") < 0.75 * figure(0, "across_rms_um"), "{figures}");
    assert!(figure(last, "contour_rms_um") < figure(0, "contour_rms_um"), "{figures}");
    assert!(figure(last, "axis_rms_um") > figure(0, "axis_rms_um"), "{figures}");
    assert!(figure(last, "effort_rms_um") < figure(0, "effort_rms_um"), "{figures}");
    assert!(figure(0, "permitted_model_error") > 0.5, "{figures}");
}

#[test]
fn estimators_stand_in_paper_ds_order_where_its_setting_is_inferred() {
    let folder = Folder::new();
    let figures = folder.figures(&["reproduce", "table-1"]);
    let table = figures["tables"].as_array().unwrap().last().unwrap();
    let max = |name: &str| {
        let row = table["rows"].as_array().unwrap().iter().find(|row| row["name"] == name).unwrap();
        row["measured"]["max_um"].as_f64().unwrap()
    };
    assert!(max("spline-search") < max("circle") && max("circle") < max("tangent"), "{table}");
    assert!(max("spline-search") < 5.5 && max("exact") < 0.01, "{table}");
}

#[test]
fn spatial_learning_converges_below_a_gain_of_two_and_tracking_with_a_new_plan_does_not() {
    let folder = Folder::new();
    let figures = folder.figures(&["reproduce", "spatial"]);
    let rows = figures["tables"][0]["rows"].as_array().unwrap();
    for row in rows {
        let runs: Vec<f64> = row["rms_by_run_um"].as_array().unwrap().iter().map(|rms| rms.as_f64().unwrap()).collect();
        let name = row["name"].as_str().unwrap();
        let diverges = name.contains("2.2") || name.contains("tracking");
        assert_eq!(runs[runs.len() - 1] > runs[0], diverges, "{name}: {runs:?}");
    }
    assert_eq!(rows.len(), 10);
}
