//! A development benchmark of the law alone: iterations on the noise-free machine, then one run on
//! the machine, for random machines.
//!
//! `cargo run --release -p precomp-compensation --example perfect_model -- 1 12`

use compensation::laws::{ContourOptimal, Gain, SpatialIlc};
use compensation::{
    CorrectionLimits, CutOffCandidates, Descent, ImpulseResponse, LowPass, StopRule, descend, learn, spatial_candidates,
};
use machine::{Machine, MachineSpec, SimulatedMachine, SimulationOptions};
use motion::contour::{ContourEstimator, ContourSummary, Exact, ExactOnCurve, summary};
use motion::curves::library;
use motion::{DesiredPath, Trajectory, plan_curve_on};

type Failure = Box<dyn std::error::Error>;

fn figures(desired: &DesiredPath, actual: &Trajectory) -> Result<ContourSummary, Failure> {
    let tips = desired.tips_of(actual)?;
    let errors = match desired.curve() {
        Some(curve) => ExactOnCurve::new(curve.clone()).estimate(&tips, &desired.tips())?,
        None => Exact::default().estimate(&tips, &desired.tips())?,
    };
    summary(&errors).ok_or_else(|| "no samples".into())
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<u64> = std::env::args().skip(1).filter_map(|text| text.parse().ok()).collect();
    let (from, to) = (arguments.first().copied().unwrap_or(1), arguments.get(1).copied().unwrap_or(12));
    for seed in from..=to {
        let spec = MachineSpec::random(seed)?;
        let loops = spec.axes[0].drive().map(|drive| drive.loops.clone());
        if let Some(l) = loops {
            println!(
                "machine {seed}: Kv {:.0} kff {:.2} PID {:?} average {:.0} lag {:.0} delay {} period {} sensor {:?} a {:.0}",
                l.position_gain_1_s,
                l.feed_forward,
                l.position_integral_ms.map(f64::round),
                l.command_average_ms,
                l.command_lag_ms,
                l.delay_periods,
                spec.sampling_period_ms,
                spec.sensor,
                spec.path.acceleration_mm_s2
            );
        }
        for name in ["nurbs-1", "crown"] {
            let desired =
                plan_curve_on(library::by_name(name)?, 80.0, &spec.kinematics()?, &spec.limits(), &spec.plan_settings())?;
            bench(&spec, name, &desired)?;
        }
    }
    Ok(())
}

fn bench(spec: &MachineSpec, name: &str, desired: &DesiredPath) -> Result<(), Failure> {
    let clock = std::time::Instant::now();
    let mut model = SimulatedMachine::new(spec, 1)?.with_options(SimulationOptions::noise_free())?;
    let path = desired.trajectory();
    let memory_s = 0.4_f64.min(0.25 * path.duration_s());
    let responses = ImpulseResponse::probe_model(&mut model, path, memory_s)?;
    let lag_s: f64 = responses.iter().map(|r| r.delay_samples() * path.period_s()).fold(0.0, f64::max);
    let limits = CorrectionLimits { limits: Some(spec.limits()), settle_s: lag_s.max(0.012), ..CorrectionLimits::default() };
    let mut law = ContourOptimal::new(responses, 0.03)?;
    let mut measure = |desired: &DesiredPath, actual: &Trajectory| {
        figures(desired, actual).map_or(f64::INFINITY, |f| f.rms_mm + 0.1 * f.max_mm)
    };
    let candidates = spatial_candidates(
        &mut model,
        desired,
        &limits,
        &CutOffCandidates { turn_s: Some(lag_s.clamp(0.01, 0.1)), updates: 4, cut_offs: 5 },
        None,
        &mut measure,
    )?;
    let first = candidates[0].clone();
    let (more, _) =
        descend(&mut model, &mut law, desired, first, &limits, &Descent { runs: 5, ..Descent::default() }, &mut measure)?;
    let candidates: Vec<_> = candidates.into_iter().chain(more.into_iter().skip(1)).collect();
    let start = candidates.iter().min_by(|a, b| a.measure.total_cmp(&b.measure)).cloned().ok_or("no run")?;
    let (mut iterations, ended) =
        descend(&mut model, &mut law, desired, start, &limits, &Descent { runs: 9, ..Descent::default() }, &mut measure)?;
    let steps = candidates.len();
    iterations.splice(0..0, candidates);
    let best = iterations.iter().min_by(|a, b| a.measure.total_cmp(&b.measure)).ok_or("no run")?;
    let real = || SimulatedMachine::new(spec, 1);
    let um = |f: ContourSummary| format!("{:.3}/{:.2}", f.rms_mm * 1e3, f.max_mm * 1e3);
    let before = figures(desired, &real()?.run(path)?)?;
    let forecast = figures(desired, &best.actual)?;
    let after = figures(desired, &real()?.run(&best.reference)?)?;
    let took = clock.elapsed().as_secs_f64();
    let mut ilc = (f64::INFINITY, f64::INFINITY, String::new());
    for hz in [6.0, 10.0, 16.0, 25.0, 40.0, 64.0, 100.0] {
        let mut law = SpatialIlc::new(Gain::Constant(0.8), LowPass::new(hz, path.period_s())?)?;
        let learned =
            learn(&mut real()?, &mut law, desired, None, &CorrectionLimits::default(), &StopRule::after(7), &mut |_, _| 0.0)?;
        let last = figures(desired, &learned.iterations[7].actual)?;
        if last.rms_mm < ilc.0 {
            ilc = (last.rms_mm, ilc.1.min(last.max_mm), format!("{hz} Hz"));
        }
        ilc.1 = ilc.1.min(last.max_mm);
    }
    let trace: Vec<String> = iterations.iter().map(|r| format!("{:.2}", r.measure * 1e3)).collect();
    println!(
        "  {name}: before {} forecast {} after {} | ILC {:.3}/{:.2} {} | {:.2} {:.2} | lag {:.1} ms, {ended:?} {steps}, {took:.1} s | {}",
        um(before),
        um(forecast),
        um(after),
        ilc.0 * 1e3,
        ilc.1 * 1e3,
        ilc.2,
        after.rms_mm / ilc.0,
        after.max_mm / ilc.1,
        lag_s * 1e3,
        trace.join(" ")
    );
    Ok(())
}
