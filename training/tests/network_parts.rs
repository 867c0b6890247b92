//! Gradient clipping and flag windows.

use burn::module::Module;
use burn::nn::{Linear, LinearConfig};
use burn::optim::GradientsParams;
use burn::tensor::{Device, Tensor};
use training::network::windows::FlagWindows;
use training::network::{clip_global_norm, global_norm};
use training::staged::AxisRun;

#[derive(Module, Debug)]
struct Two {
    first: Linear,
    second: Linear,
}

fn flat(gradients: &GradientsParams, two: &Two) -> Vec<f64> {
    let mut all = Vec::new();
    for linear in [&two.first, &two.second] {
        let weight = gradients.get::<2>(linear.weight.id).expect("a gradient");
        all.extend(weight.into_data().iter::<f64>());
        let bias = linear.bias.as_ref().expect("a bias");
        all.extend(gradients.get::<1>(bias.id).expect("a gradient").into_data().iter::<f64>());
    }
    all
}

#[test]
fn clipping_shortens_all_gradients_together_and_keeps_their_direction() {
    let device = Device::flex().autodiff();
    let two = Two { first: LinearConfig::new(3, 4).init(&device), second: LinearConfig::new(4, 2).init(&device) };
    let gradients = || {
        let x = Tensor::<2>::from_data([[1.0, -2.0, 3.0], [0.5, 0.1, -4.0]], &device);
        let loss = two.second.forward(two.first.forward(x).tanh()).powf_scalar(2.0).sum() * 100.0;
        GradientsParams::from_grads(loss.backward(), &two)
    };
    let before = flat(&gradients(), &two);
    let norm = before.iter().map(|g| g * g).sum::<f64>().sqrt();
    let mut clipped = gradients();
    assert!((clip_global_norm(&mut clipped, &two, 0.5) / norm - 1.0).abs() < 1e-5);
    assert!(norm > 0.5, "{norm}");
    let after = flat(&clipped, &two);
    assert!((global_norm(&clipped, &two) - 0.5).abs() < 1e-5);
    for (after, before) in after.iter().zip(&before) {
        assert!((after - before * 0.5 / norm).abs() < 1e-6, "{after} {before}");
    }
    // Short ones stay as they are.
    let mut kept = gradients();
    clip_global_norm(&mut kept, &two, 2.0 * norm);
    assert_eq!(flat(&kept, &two), before);
}

/// Back and forth with every other stop a dwell. The error has bumps of known length after
/// reversals and starts.
fn with_bumps(reversal_samples: usize, start_samples: usize) -> AxisRun {
    let period_s = 0.002;
    let mut reference = vec![0.0; 100];
    let mut bumps = vec![0.0; 100];
    for stroke in 0..60 {
        let sign = if stroke % 2 == 0 { 1.0 } else { -1.0 };
        let rested = stroke % 4 == 0;
        let length = 300 + 37 * (stroke % 5);
        for k in 1..=length {
            let speed = sign * 20.0 * (std::f64::consts::PI * (f64::from(k) - 0.5) / f64::from(length)).sin();
            reference.push(reference.last().copied().unwrap_or_default() + speed * period_s);
            let (bump, window) = if rested { (0.004, start_samples) } else { (0.003, reversal_samples) };
            // The event is the last sample before the new direction.
            bumps.push(if k as usize <= window { sign * bump } else { 0.0 });
        }
        if stroke % 4 == 3 {
            reference.extend(vec![reference.last().copied().unwrap_or_default(); 200]);
            bumps.extend(vec![0.0; 200]);
        }
    }
    let actual = reference.iter().enumerate().map(|(k, x)| {
        let v = if k > 0 { (x - reference[k - 1]) / period_s } else { 0.0 };
        x - 0.001 * v - bumps[k]
    });
    let actual = actual.collect();
    AxisRun::new(reference, actual, period_s)
}

#[test]
fn flag_windows_are_found_in_the_runs() {
    for (reversal, start) in [(20, 45), (35, 12)] {
        let found = FlagWindows::identify(&[with_bumps(reversal, start)]);
        println!("after reversals {} for {reversal}, after starts {} for {start}", found.backlash, found.start);
        assert!(found.backlash.abs_diff(reversal) <= 3, "{found:?}");
        assert!(found.start.abs_diff(start) <= 3, "{found:?}");
    }
}

#[test]
fn too_few_events_give_default_windows() {
    let reference: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
    let run = AxisRun::new(reference.clone(), reference, 0.002);
    assert_eq!(FlagWindows::identify(&[run]), FlagWindows { backlash: 25, start: 25 });
}
