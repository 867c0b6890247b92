//! Feeds chosen by the forecast. Works on the story's part and model, so that no second one has to be trained.

use serde_json::Value;

use crate::common::{Folder, text};

pub fn slower_where_the_forecast_asks_for_it(folder: &Folder) {
    let compensate = |out: &str, more: &[&str]| -> Value {
        let mut words = vec!["compensate", "part.nc", "-m", "machine.model", "-o", out];
        words.extend(more);
        folder.figures(&words)["feeds"].clone()
    };
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let figure = |feeds: &Value, name: &str| feeds[name].as_f64().unwrap();

    // A tolerance that is kept anyway changes nothing.
    let wide = compensate("wide.nc", &["--tolerance", "1mm"]);
    assert_eq!(wide["slower_moves"], 0);
    assert!(read("wide.nc") == read("out.nc"), "a tolerance that is kept changes the program");

    let max = figure(&wide, "max_before_um");
    let tight = format!("{}um", 0.4 * max);
    let slow = compensate("slow.nc", &["--tolerance", &tight]);
    assert!(figure(&slow, "slower_moves") >= 1.0, "{slow}");
    // A move whose error is none of speed keeps its feed, and the largest error may be one of those.
    assert!(figure(&slow, "max_after_um") <= max, "{slow}");
    assert!(figure(&slow, "cycle_after_s") > figure(&slow, "cycle_before_s"), "{slow}");
    let kept = compensate("kept.nc", &["--tolerance", &tight, "--keep-time"]);
    assert!(figure(&kept, "cycle_after_s") < figure(&slow, "cycle_after_s"), "{kept} against {slow}");

    // The last feed move leaves the programmed feed in force, and rapids and cycles stay.
    let slow = read("slow.nc");
    assert!(slow.contains("N120 G81 X0. Y0. Z-5. R2. F100\r\n"));
    assert_ne!(slow, read("out.nc"));
    assert!(folder.figures(&["simulate", "slow.nc", "--against", "part.nc", "-o", "slow.csv"])["seconds"].as_f64().is_some());

    folder.fails(2, &["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc", "--tolerance", "2"]);
    folder.fails(2, &["compensate", "part.nc", "-m", "machine.model", "-o", "x.nc", "--keep-time"]);
    let reference = folder.precomp(&["compensate", "cut.csv", "-m", "machine.model", "-o", "x.csv", "--tolerance", "2um"]);
    assert_eq!(reference.status.code(), Some(2));
    assert!(text(&reference.stderr).contains("only part programs"), "{}", text(&reference.stderr));
}
