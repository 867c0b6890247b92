//! Iterative learning on a machine, one command a run.

use serde_json::{Value, json};

use crate::common::{Folder, without_mark};

#[test]
fn every_run_is_learned_from_its_log() {
    let folder = Folder::new();
    let part = "G21 G90 G17\nG0 X0 Y0\nG1 X30 F2400\nG3 X30 Y20 J10\nG1 X0\nG1 Y0\nM30\n";
    std::fs::write(folder.path("part.nc"), part).unwrap();
    folder.figures(&["simulate", "part.nc", "-o", "run1.csv"]);
    let mut rms = Vec::new();
    for run in 1..4 {
        let (log, next) = (format!("run{run}.csv"), format!("run{}.nc", run + 1));
        let figures = folder.figures(&[
            "refine",
            "part.nc",
            "--machine",
            "ballscrew",
            "--log",
            &log,
            "--run",
            &run.to_string(),
            "-o",
            &next,
        ]);
        rms.push(figures["contour_um"]["rms"].as_f64().unwrap());
        let (seed, after) = (run.to_string(), format!("run{}.csv", run + 1));
        folder.figures(&["simulate", &next, "--against", "part.nc", "-o", &after, "--seed", &seed]);
    }
    assert!(rms[1] < 0.5 * rms[0] && rms[2] < 0.5 * rms[0], "{rms:?}");
    let text = without_mark(&std::fs::read_to_string(folder.path("run4.nc")).unwrap());
    assert!(text.starts_with("G21 G90 G17\nG0 X0 Y0\n") && text.ends_with("M30\n"));

    // A log of something else, or none at all, teaches nothing.
    std::fs::write(folder.path("other.nc"), part.replace("Y20", "Y24").replace("J10", "J12")).unwrap();
    assert!(
        folder
            .fails(1, &["refine", "other.nc", "--machine", "ballscrew", "--log", "run1.csv", "-o", "no.nc"])
            .contains("leaves the desired path")
    );
    folder.fails(2, &["refine", "part.nc", "--machine", "ballscrew", "--log", "none.csv", "-o", "no.nc"]);
    folder.fails(2, &["refine", "part.nc", "--machine", "ballscrew", "--log", "run1.csv", "-o", "part.nc"]);
    assert!(!folder.path("no.nc").exists());
}

/// Runs that are simulated and learned from, one command each, as a user would.
struct Runs {
    folder: Folder,
    /// Further words of `simulate` and of `refine`.
    simulate: Vec<String>,
    refine: Vec<String>,
    rms_um: Vec<f64>,
    max_um: Vec<f64>,
}

impl Runs {
    fn new(simulate: &[&str], refine: &[&str]) -> Self {
        let folder = Folder::with_model_and_part();
        folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "run1.nc"]);
        let [simulate, refine] = [simulate, refine].map(|words| words.iter().map(|word| (*word).to_owned()).collect());
        Self { folder, simulate, refine, rms_um: Vec::new(), max_um: Vec::new() }
    }

    /// Runs the next program on the machine.
    fn run(&mut self) {
        let run = self.rms_um.len() + 1;
        let (program, log, seed) = (format!("run{run}.nc"), format!("run{run}.csv"), run.to_string());
        let mut words = vec!["simulate", &program, "--against", "part.nc", "-o", &log, "--seed", &seed];
        words.extend(self.simulate.iter().map(String::as_str));
        let contour = self.folder.figures(&words)["contour_um"].clone();
        self.rms_um.push(contour["rms"].as_f64().unwrap());
        self.max_um.push(contour["max"].as_f64().unwrap());
    }

    /// Learns from all runs so far.
    fn refine(&self) -> Value {
        let runs = 1..=self.rms_um.len();
        let files = |ending: &str| runs.clone().map(|run| format!("run{run}.{ending}")).collect::<Vec<_>>();
        let (logs, programs, next) = (files("csv"), files("nc"), format!("run{}.nc", self.rms_um.len() + 1));
        let mut words = vec!["refine", "part.nc", "-m", "machine.model", "-o", &next, "--log"];
        words.extend(logs.iter().map(String::as_str));
        words.push("--ran");
        words.extend(programs.iter().map(String::as_str));
        words.extend(self.refine.iter().map(String::as_str));
        self.folder.figures(&words)
    }

    fn learn(mut self, runs: usize) -> Self {
        for _ in 1..runs {
            self.run();
            self.refine();
        }
        self.run();
        self
    }
}

#[test]
fn runs_that_are_learned_from_become_better_and_stay_so() {
    let Runs { rms_um, max_um, .. } = Runs::new(&[], &[]).learn(6);
    let best = rms_um.iter().copied().fold(f64::INFINITY, f64::min);
    // The first run is within a few per cent of the repeatability of the machine.
    assert!(rms_um.iter().all(|rms| *rms < 1.05 * rms_um[0]), "{rms_um:?}");
    assert!(0.5 * (rms_um[4] + rms_um[5]) < 0.98 * rms_um[0], "{rms_um:?}");
    assert!(rms_um[5] <= 1.1 * best, "{rms_um:?}");
    assert!(max_um[5] <= 1.16 * max_um[0], "{max_um:?}");
}

#[test]
fn without_noise_nothing_adds_up_from_run_to_run() {
    let Runs { rms_um, .. } = Runs::new(&["--noise", "0"], &[]).learn(4);
    assert!(rms_um[1..].iter().all(|rms| *rms <= 1.02 * rms_um[0]), "{rms_um:?}");
}

#[test]
fn after_a_worse_run_the_best_program_is_handed_back() {
    for law in [&[][..], &["--law", "spatial"]] {
        let mut runs = Runs::new(&[], law);
        runs.run();
        // The second program was not compensated.
        runs.folder.write("run2.nc", runs.folder.read("part.nc"));
        runs.run();
        let figures = runs.refine();
        assert_eq!((&figures["ended"], &figures["best_run"], &figures["written_run"]), (&json!("worse"), &json!(1), &json!(1)));
        assert_eq!(figures["runs"].as_array().unwrap().len(), 2);
        assert_eq!(runs.folder.read("run3.nc"), runs.folder.read("run1.nc"));
    }
}

#[test]
fn programs_in_another_order_than_the_logs_are_refused() {
    let mut runs = Runs::new(&[], &[]);
    runs.run();
    runs.folder.write("run2.nc", runs.folder.read("part.nc"));
    runs.run();
    for law in ["model-based", "spatial"] {
        let refine = |first: &'static str, second: &'static str| {
            [
                "refine",
                "part.nc",
                "-m",
                "machine.model",
                "--law",
                law,
                "-o",
                "no.nc",
                "--log",
                "run1.csv",
                "run2.csv",
                "--ran",
                first,
                second,
            ]
        };
        let error = runs.folder.fails(1, &refine("run2.nc", "run1.nc"));
        assert!(error.contains("run1.csv is no run of run2.nc") && error.contains("in the order of the logs"), "{law}: {error}");
        assert!(!runs.folder.path("no.nc").exists());
    }
}

#[test]
fn a_single_log_is_of_the_program_that_is_said_to_have_run() {
    let mut runs = Runs::new(&[], &[]);
    runs.run();
    let folder = &runs.folder;
    folder.figures(&["simulate", "part.nc", "--machine", "ballscrew", "-o", "original.csv"]);
    let refine = |log: &'static str, ran: &'static str| {
        ["refine", "part.nc", "-m", "machine.model", "-o", "no.nc", "--log", log, "--ran", ran]
    };
    let error = folder.fails(1, &refine("run1.csv", "part.nc"));
    assert!(error.contains("run1.csv is no run of part.nc: its command is shifted"), "{error}");
    let error = folder.fails(1, &refine("original.csv", "run1.nc"));
    assert!(error.contains("original.csv is no run of run1.nc") && error.contains("from part.nc"), "{error}");
    assert!(!folder.path("no.nc").exists());
    folder.figures(&refine("original.csv", "part.nc"));
}

/// A run of a compensated program on the built-in machine with three quarters of its accelerations: it keeps a time of its own.
fn slower_run() -> Runs {
    let mut runs = Runs::new(&[], &[]);
    runs.run();
    let own = include_str!("../../machine/machines/ballscrew.toml");
    let slower = own.replace("acceleration_mm_s2 = 800.0", "acceleration_mm_s2 = 600.0");
    assert_ne!(own, slower);
    runs.folder.write("slower.toml", slower);
    runs.folder.figures(&["simulate", "run1.nc", "--machine", "slower.toml", "-o", "slower.csv"]);
    runs
}

#[test]
fn a_control_with_other_limits_runs_the_program_all_the_same() {
    let folder = slower_run().folder;
    let refine = ["refine", "part.nc", "-m", "machine.model", "--log", "slower.csv", "-o", "next.nc", "--ran"];
    for law in ["model-based", "spatial"] {
        folder.figures(&[&refine[..], &["run1.nc", "--law", law]].concat());
    }
    std::fs::remove_file(folder.path("next.nc")).unwrap();
    assert!(folder.fails(1, &[&refine[..], &["part.nc"]].concat()).contains("slower.csv is no run of part.nc"));
    assert!(!folder.path("next.nc").exists());
    let recorded = ["compensate", "part.nc", "-m", "machine.model", "-o", "next.nc", "--reference", "slower.csv"];
    assert!(folder.fails(1, &recorded).contains("shifted as that of a compensated program"));
}

#[test]
fn a_run_has_one_contour_error_whoever_states_it() {
    let folder = slower_run().folder;
    let of = |figures: &Value| figures["contour_um"].clone();
    let measured = of(&folder.figures(&["measure", "slower.csv", "--desired", "part.nc", "-m", "machine.model"]));
    let refine = ["refine", "part.nc", "-m", "machine.model", "--log", "slower.csv", "-o", "next.nc", "--report", "report.html"];
    for law in ["model-based", "spatial"] {
        let refined = of(&folder.figures(&[&refine[..], &["--law", law]].concat()));
        for figure in ["rms", "max", "p95"] {
            let [one, other] = [&measured, &refined].map(|of| of[figure].as_f64().unwrap());
            assert!((one / other - 1.0).abs() < 1e-6, "{law}: {measured} {refined}");
        }
        let shown = format!("\"run 1\",\"{:.3}\"", refined["rms"].as_f64().unwrap());
        assert!(folder.read("report.html").contains(&shown), "{law}: {shown}");
    }
}

#[test]
fn every_run_has_its_program_and_every_program_its_original() {
    let mut runs = Runs::new(&[], &[]);
    runs.run();
    let folder = &runs.folder;
    let words = ["refine", "part.nc", "-m", "machine.model", "--log", "run1.csv", "run1.csv", "-o", "no.nc"];
    assert!(folder.fails(2, &words).contains("2 logs and 0 programs"));
    folder.write("other.nc", folder.read("part.nc").replace("F900", "F800"));
    folder.figures(&["compensate", "other.nc", "-m", "machine.model", "-o", "of-other.nc"]);
    for foreign in ["of-other.nc", "other.nc"] {
        let words = ["refine", "part.nc", "-m", "machine.model", "--log", "run1.csv", "--ran", foreign, "-o", "no.nc"];
        assert!(folder.fails(1, &words).contains(&format!("{foreign} is not part.nc, nor does it state")));
    }
    let words = ["refine", "part.nc", "--machine", "ballscrew", "--law", "model-based", "--log", "run1.csv", "-o", "no.nc"];
    assert!(folder.fails(2, &words).contains("needs a model"));
    assert!(!folder.path("no.nc").exists());
    // A single run that the model explains shows nothing new: its program runs once more.
    assert_eq!(runs.refine()["ended"], "no-gain");
    assert_eq!(folder.read("run2.nc"), folder.read("run1.nc"));
}

#[test]
fn recordings_of_another_machine_are_refused_and_repeated_ones_are_told() {
    let mut runs = Runs::new(&[], &[]);
    runs.run();
    let folder = &runs.folder;
    let refine = |logs: &[&'static str], ran: &[&'static str]| {
        [&["refine", "part.nc", "-m", "machine.model", "-o", "no.nc", "--log"][..], logs, &["--ran"], ran].concat()
    };
    std::fs::copy(folder.path("run1.csv"), folder.path("again.csv")).unwrap();
    let said = folder.prints(&refine(&["run1.csv", "again.csv"], &["run1.nc", "run1.nc"]));
    assert!(said.contains("again.csv is the same recording as run1.csv"), "{said}");
    std::fs::remove_file(folder.path("no.nc")).unwrap();
    // The same program on a machine of other drives.
    folder.figures(&["simulate", "run1.nc", "--machine", "random:403", "-o", "foreign.csv", "--against", "part.nc"]);
    let error = folder.fails(1, &refine(&["foreign.csv"], &["run1.nc"]));
    assert!(error.contains("foreign.csv is not of the machine of the model") && error.contains("held-out runs"), "{error}");
    assert!(!folder.path("no.nc").exists());
}
