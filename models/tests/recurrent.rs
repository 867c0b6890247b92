//! The recurrent operations and networks compared with PyTorch's numbers, and the ways of
//! prediction with each other.

use std::collections::HashMap;

use burn::nn::LinearConfig;
use burn::tensor::{Device, Tensor, TensorData};
use models::recurrent::{Head, Kind, LayerWeights, Level, Recurrent, RecurrentConfig, gru, lstm};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[derive(serde::Deserialize)]
struct Fixture {
    sizes: Sizes,
    lstm: Case,
    gru: Case,
}

#[derive(serde::Deserialize, Clone, Copy)]
struct Sizes {
    input: usize,
    hidden: usize,
    steps: usize,
    batch: usize,
    layers: usize,
}

#[derive(serde::Deserialize)]
struct Case {
    parameters: HashMap<String, Vec<f32>>,
    inputs: HashMap<String, Vec<f32>>,
    loss_weights: Vec<f32>,
    y: Vec<f32>,
    gradients: HashMap<String, Vec<f32>>,
}

fn fixture() -> Fixture {
    serde_json::from_str(include_str!("fixtures/recurrent.json")).unwrap()
}

fn worst(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

fn read<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().try_into_vec::<f32>().unwrap()
}

fn layers(kind: Kind, case: &Case, sizes: Sizes) -> Vec<LayerWeights> {
    (0..sizes.layers)
        .map(|layer| {
            let part = |name: &str| case.parameters[&format!("{name}_l{layer}")].clone();
            let parts = ["weight_ih", "weight_hh", "bias_ih", "bias_hh"].map(part);
            let input = if layer == 0 { sizes.input } else { sizes.hidden };
            LayerWeights::from_pytorch(kind, input, sizes.hidden, parts).unwrap()
        })
        .collect()
}

/// A bias gradient in PyTorch's two vectors: the merged bias has the gradient of both.
fn split_bias(kind: Kind, gradient: &[f32], hidden: usize) -> [Vec<f32>; 2] {
    match kind {
        Kind::Lstm => [gradient.to_vec(), gradient.to_vec()],
        Kind::Gru => {
            let (rz, rest) = gradient.split_at(2 * hidden);
            let (n, hn) = rest.split_at(hidden);
            [[rz, n].concat(), [rz, hn].concat()]
        }
    }
}

#[test]
fn outputs_and_every_gradient_are_pytorch_s() {
    let Fixture { sizes, lstm: lstm_case, gru: gru_case } = fixture();
    let device = Device::flex().autodiff();
    let Sizes { input, hidden, steps, batch, .. } = sizes;
    for (kind, case) in [(Kind::Lstm, &lstm_case), (Kind::Gru, &gru_case)] {
        let leaf2 = |values: &[f32], rows: usize| {
            let data = TensorData::new(values.to_vec(), [rows, values.len() / rows]);
            Tensor::<2>::from_data(data, &device).require_grad()
        };
        let data = TensorData::new(case.inputs["x"].clone(), [steps, batch, input]);
        let x = Tensor::<3>::from_data(data, &device).require_grad();
        let mut y = x.clone();
        let mut leaves = Vec::new();
        for (index, layer) in layers(kind, case, sizes).iter().enumerate() {
            let rows = kind.gates() * hidden;
            let state = |name: &str| {
                let values = &case.inputs[name];
                leaf2(&values[index * batch * hidden..(index + 1) * batch * hidden], batch)
            };
            let (ih, hh) = (leaf2(&layer.weight_ih, rows), leaf2(&layer.weight_hh, rows));
            let bias = TensorData::new(layer.bias.clone(), [4 * hidden]);
            let bias = Tensor::<1>::from_data(bias, &device).require_grad();
            let h0 = state("h0");
            let c0 = (kind == Kind::Lstm).then(|| state("c0"));
            let (w, v, b, h) = (ih.clone(), hh.clone(), bias.clone(), Some(h0.clone()));
            y = match kind {
                Kind::Lstm => lstm(y, w, v, b, h, c0.clone()),
                Kind::Gru => gru(y, w, v, b, h),
            };
            leaves.push((ih, hh, bias, h0, c0));
        }
        let error = worst(&read(y.clone().inner()), &case.y);
        println!("{kind:?}: outputs differ by {error:.1e}");
        assert!(error < 2e-6, "{error}");
        let loss = TensorData::new(case.loss_weights.clone(), [steps, batch, hidden]);
        let gradients = (y * Tensor::from_data(loss, &device)).sum().backward();
        let mut largest = worst(&read(x.grad(&gradients).unwrap()), &case.gradients["x"]);
        for (index, (ih, hh, bias, h0, c0)) in leaves.iter().enumerate() {
            let bias = read(bias.grad(&gradients).unwrap());
            let [bias_ih, bias_hh] = split_bias(kind, &bias, hidden);
            let found = [
                ("weight_ih", read(ih.grad(&gradients).unwrap())),
                ("weight_hh", read(hh.grad(&gradients).unwrap())),
                ("bias_ih", bias_ih),
                ("bias_hh", bias_hh),
            ];
            for (name, found) in found {
                largest = largest.max(worst(&found, &case.gradients[&format!("{name}_l{index}")]));
            }
            let of_state = index * batch * hidden..(index + 1) * batch * hidden;
            for (name, state) in [("h0", Some(h0)), ("c0", c0.as_ref())] {
                if let Some(state) = state {
                    let found = read(state.grad(&gradients).unwrap());
                    largest = largest.max(worst(&found, &case.gradients[name][of_state.clone()]));
                }
            }
        }
        println!("{kind:?}: gradients differ by {largest:.1e}");
        assert!(largest < 1e-5, "{largest}");
    }
}

/// A network with random weights and three outputs.
fn network(kind: Kind, level: Level) -> Recurrent {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let config = RecurrentConfig { kind, input: 4, hidden: 24, layers: 2, dropout: 0.0, forget_bias: None };
    let stack = config.init(&mut rng, &Device::flex()).unwrap();
    let mut draw = |count: usize| (0..count).map(|_| rng.random_range(-0.3..0.3)).collect();
    let head = Head { outputs: 3, weight: draw(72), bias: draw(3) };
    Recurrent::with_level(stack.weights().unwrap(), head, level).unwrap()
}

fn signal(steps: usize) -> Vec<f32> {
    (0..4 * steps).map(|i| ((i * i % 97) as f32 / 48.0 - 1.0) * (i as f32 * 0.01).cos()).collect()
}

#[test]
fn sample_by_sample_is_the_whole_and_plain_code_the_vectors() {
    let x = signal(700);
    for kind in [Kind::Lstm, Kind::Gru] {
        let network_fast = network(kind, Level::detect());
        let whole = network_fast.predict(&x, &mut network_fast.zero_state(1)).unwrap();
        assert_eq!(whole.len(), 3 * 700);
        let mut state = network_fast.zero_state(1);
        let mut streamed = Vec::new();
        let mut rest = x.as_slice();
        // Calls of 1, 2, 3 … steps.
        for steps in 1.. {
            let (now, later) = rest.split_at((4 * steps).min(rest.len()));
            streamed.extend(network_fast.predict(now, &mut state).unwrap());
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        assert!(worst(&whole, &streamed) < 1e-6);
        let plain = network(kind, Level::portable());
        let plain = plain.predict(&x, &mut plain.zero_state(1)).unwrap();
        assert!(worst(&whole, &plain) < 1e-5);
        // Same input, same bits.
        assert_eq!(whole, network_fast.predict(&x, &mut network_fast.zero_state(1)).unwrap());
    }
}

#[test]
fn chunks_with_enough_warm_up_are_the_whole() {
    let x = signal(2000);
    for kind in [Kind::Lstm, Kind::Gru] {
        let network = network(kind, Level::detect());
        let whole = network.predict(&x, &mut network.zero_state(1)).unwrap();
        let error = |chunk, warmup| worst(&whole, &network.predict_chunked(&x, chunk, warmup).unwrap());
        println!("{kind:?}: cold {:.1e}, warm {:.1e}", error(37, 0), error(37, 80));
        assert!(error(37, 80) < 1e-4);
        assert!(error(37, 0) > 1e-2, "without a warm-up the cuts must show");
        assert!(error(2000, 0) < 1e-6);
        assert!(error(5000, 10) < 1e-6);
    }
}

#[test]
fn the_module_its_plain_copy_and_its_tensors_agree() {
    let device = Device::flex().autodiff();
    for kind in [Kind::Lstm, Kind::Gru] {
        let config = RecurrentConfig { kind, input: 4, hidden: 24, layers: 3, dropout: 0.4, forget_bias: Some(1.0) };
        let stack = config.init(&mut ChaCha8Rng::seed_from_u64(5), &device).unwrap();
        let head = LinearConfig::new(24, 2).init(&device);
        let x = signal(60);
        let tensor = Tensor::<3>::from_data(TensorData::new(x.clone(), [1, 60, 4]), &device);
        let trained = read(stack.forward_to(&head, tensor.clone()));
        assert!(worst(&trained, &read(head.forward(stack.forward(tensor.clone())))) < 1e-6);
        let plain = Recurrent::from_module(&stack, &head).unwrap();
        let predicted = plain.predict(&x, &mut plain.zero_state(1)).unwrap();
        assert!(worst(&trained, &predicted) < 1e-5);
        let again = Recurrent::from_tensors(kind, plain.to_tensors()).unwrap();
        assert_eq!(again.predict(&x, &mut again.zero_state(1)).unwrap(), predicted);
        assert_eq!(again.to_tensors(), plain.to_tensors());
        // Dropout comes from the generator alone.
        let dropped = |seed| read(stack.forward_training(&head, tensor.clone(), &mut ChaCha8Rng::seed_from_u64(seed)));
        assert_eq!(dropped(1), dropped(1));
        assert!(worst(&dropped(1), &dropped(2)) > 1e-3);
        // The start: forget bias where asked, all else within its bounds and not all alike.
        let first = &stack.weights().unwrap()[0];
        if kind == Kind::Lstm {
            assert!(first.bias[24..48].iter().all(|&bias| bias == 1.0));
        }
        let bound = 1.0 / 24.0_f32.sqrt();
        assert!(first.weight_hh.iter().all(|w| w.abs() <= bound));
        let mean_square = first.weight_hh.iter().map(|w| w * w).sum::<f32>() / first.weight_hh.len() as f32;
        assert!((mean_square / (bound * bound / 3.0) - 1.0).abs() < 0.1, "not uniform");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let network = network(Kind::Lstm, Level::detect());
    assert!(network.predict(&[0.0; 7], &mut network.zero_state(1)).is_err());
    assert!(network.predict_chunked(&[0.0; 8], 0, 3).is_err());
    assert!(network.predict(&[0.0; 8], &mut network.zero_state(0)).is_err());
    let other = crate::network(Kind::Gru, Level::detect());
    assert!(network.predict(&[0.0; 8], &mut other.zero_state(1)).is_err());
    let mut tensors = network.to_tensors();
    tensors.remove(1);
    assert!(Recurrent::from_tensors(Kind::Lstm, tensors).is_err());
    assert!(Recurrent::from_tensors(Kind::Gru, network.to_tensors()).is_err());
    let head = Head { outputs: 1, weight: vec![0.0; 5], bias: vec![0.0] };
    assert!(Recurrent::new(network.layers().to_vec(), head).is_err());
    assert!(Recurrent::new(Vec::new(), network.head().clone()).is_err());
    let config = RecurrentConfig { kind: Kind::Gru, input: 0, hidden: 3, layers: 1, dropout: 0.0, forget_bias: None };
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    assert!(config.init(&mut rng, &Device::flex()).is_err());
    let config = RecurrentConfig { input: 2, dropout: 1.0, ..config };
    assert!(config.init(&mut rng, &Device::flex()).is_err());
    assert_eq!(network.predict(&[], &mut network.zero_state(1)).unwrap(), Vec::<f32>::new());
}
