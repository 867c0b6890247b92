//! Laws that learn programs, whose time the control plans anew.

use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits};
use machine::{MachineSpec, SimulatedMachine};
use motion::contour::MovingWindow;
use pipeline::Setup;
use pipeline::control::{Pairing, curve_program, learn_program};

/// Paper C, table II's order: where a control plans every program's time anew, learning in space ends below learning in time.
#[test]
fn spatial_learning_beats_tracking_where_programs_are_planned_anew() {
    let spec = MachineSpec::builtin("bc").unwrap();
    let butterfly = curve_program("saddle-butterfly", 50.0, 0.2, &Setup::new(&spec, None).unwrap()).unwrap();
    let mut machine = SimulatedMachine::new(&spec, 1001).unwrap();
    let mut learned = |law: &mut dyn CompensationLaw, pairing| {
        let runs = learn_program(&butterfly, &mut machine, law, pairing, 5, &CorrectionLimits::default()).unwrap();
        // Nothing is learned before the first run: its program is the original.
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
