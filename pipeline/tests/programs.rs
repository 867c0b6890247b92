//! ILC on programs whose feed profile the control replans.

use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits};
use machine::{MachineSpec, SimulatedMachine};
use motion::contour::MovingWindow;
use pipeline::Setup;
use pipeline::control::{MOVE_POINTS, Pairing, curve_program, learn_program};

/// Order of table II in Paper C: where a control replans every program, spatial ILC ends below tracking ILC.
#[test]
fn spatial_learning_beats_tracking_where_programs_are_replanned() {
    let spec = MachineSpec::builtin("bc").unwrap();
    let butterfly = curve_program("saddle-butterfly", 50.0, 0.2, &Setup::new(&spec, None).unwrap()).unwrap();
    let mut machine = SimulatedMachine::new(&spec, 1001).unwrap();
    let mut learned = |law: &mut dyn CompensationLaw, pairing| {
        let runs = learn_program(&butterfly, &mut machine, law, (pairing, MOVE_POINTS), 5, &CorrectionLimits::default()).unwrap();
        // The program of the first run is the original.
        assert_eq!(&runs[0].run.command, butterfly.plan.desired.trajectory());
        let figures = [0, 5].map(|run| runs[run].figures.tip);
        println!("{}, {pairing:?}: {figures:?}", law.name());
        figures
    };
    let gain = Gain::Constant(0.5);
    let mut spatial = SpatialIlc::new(gain, None).unwrap().with_estimator(Box::new(MovingWindow::default()));
    let [first, spatial] = learned(&mut spatial, Pairing::Place);
    assert!(spatial.rms_mm < 0.1 * first.rms_mm && spatial.max_mm < 0.3 * first.max_mm);
    for (pairing, worse) in [(Pairing::Place, 1.0), (Pairing::Time, 2.0)] {
        let [_, tracking] = learned(&mut TrackingIlc::new(gain, None), pairing);
        assert!(worse * spatial.rms_mm < tracking.rms_mm, "{pairing:?}");
        assert!(worse * spatial.max_mm < tracking.max_mm, "{pairing:?}");
    }
}
