//! Recurrent layers compared with burn's own, with the sizes of `benches/pytorch/recurrent.py`.

use std::{hint::black_box, time::Duration};

use burn::{
    module::Module,
    nn::{Linear, LinearConfig, Lstm, LstmConfig},
    optim::{GradientsParams, ModuleOptimizer},
    tensor::{Device, Tensor, TensorData},
};
use criterion::{Criterion, criterion_group, criterion_main};
use models::recurrent::{Adam, FusedRecurrent, Kind, Recurrent, RecurrentConfig};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const LAYERS: usize = 3;
const HIDDEN: usize = 128;
const BATCH: usize = 32;
const STEPS: usize = 128;
const INPUT: usize = 10;
const LONG: usize = 4096;

#[derive(Module, Debug)]
struct Network {
    stack: FusedRecurrent,
    head: Linear,
}

fn draw(rng: &mut ChaCha8Rng, shape: [usize; 3]) -> TensorData {
    let count = shape.iter().product();
    let values: Vec<f32> = (0..count).map(|_| rng.random_range(-1.7..1.7)).collect();
    TensorData::new(values, shape)
}

fn network(kind: Kind, device: &Device) -> Network {
    let config = RecurrentConfig { kind, input: INPUT, hidden: HIDDEN, layers: LAYERS, dropout: 0.0, forget_bias: None };
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    match config.init(&mut rng, device) {
        Ok(stack) => Network { stack, head: LinearConfig::new(HIDDEN, 1).init(device) },
        Err(error) => panic!("{error}"),
    }
}

fn training(c: &mut Criterion) {
    let device = Device::flex().autodiff();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let x = Tensor::<3>::from_data(draw(&mut rng, [BATCH, STEPS, INPUT]), &device);
    let y = Tensor::<3>::from_data(draw(&mut rng, [BATCH, STEPS, 1]), &device);
    for (name, kind) in [("lstm", Kind::Lstm), ("gru", Kind::Gru)] {
        let mut net = Some(network(kind, &device));
        let mut adam = ModuleOptimizer::from(Adam::new(1e-8));
        c.bench_function(&format!("{name} training step"), |b| {
            b.iter(|| {
                if let Some(now) = net.take() {
                    let error = now.stack.forward_to(&now.head, x.clone()) - y.clone();
                    let gradients = error.powf_scalar(2.0).mean().backward();
                    let gradients = GradientsParams::from_grads(gradients, &now);
                    net = Some(adam.step(1e-3, now, gradients));
                }
            });
        });
    }
}

fn stock(c: &mut Criterion) {
    let device = Device::flex().autodiff();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let x = Tensor::<3>::from_data(draw(&mut rng, [BATCH, STEPS, INPUT]), &device);
    let y = Tensor::<3>::from_data(draw(&mut rng, [BATCH, STEPS, HIDDEN]), &device);
    let layers: Vec<Lstm> =
        (0..LAYERS).map(|i| LstmConfig::new(if i == 0 { INPUT } else { HIDDEN }, HIDDEN, true).init(&device)).collect();
    c.bench_function("lstm gradients, burn's own", |b| {
        b.iter(|| {
            let last = layers.iter().fold(x.clone(), |x, layer| layer.forward(x, None).0);
            black_box((last - y.clone()).powf_scalar(2.0).mean().backward())
        });
    });
}

fn prediction(c: &mut Criterion) {
    let device = Device::flex().autodiff();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let x: Vec<f32> = (0..LONG * INPUT).map(|_| rng.random_range(-1.7..1.7)).collect();
    for (name, kind) in [("lstm", Kind::Lstm), ("gru", Kind::Gru)] {
        let net = network(kind, &device).valid();
        let net = match Recurrent::from_module(&net.stack, &net.head) {
            Ok(net) => net,
            Err(error) => panic!("{error}"),
        };
        c.bench_function(&format!("{name} predict {LONG}"), |b| {
            b.iter(|| black_box(net.predict(&x, &mut net.zero_state(1))));
        });
        c.bench_function(&format!("{name} predict {LONG} in chunks of 128 after 64"), |b| {
            b.iter(|| black_box(net.predict_chunked(&x, 128, 64)));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    targets = training, stock, prediction
}
criterion_main!(benches);
