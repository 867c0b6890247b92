//! The fused layers compared with burn's own cells: outputs and all gradients.

use burn::module::Param;
use burn::nn::{GateController, GruConfig, Linear, LstmConfig};
use burn::tensor::{Device, Gradients, Tensor, TensorData};
use models::recurrent::{FusedRecurrent, Kind, LayerWeights};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const INPUT: usize = 6;
const HIDDEN: usize = 19;
const STEPS: usize = 11;
const BATCH: usize = 5;

fn draw(rng: &mut ChaCha8Rng, count: usize) -> Vec<f32> {
    (0..count).map(|_| rng.random_range(-0.6..0.6)).collect()
}

fn read<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().try_into_vec::<f32>().unwrap()
}

fn worst(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

/// Gives one of burn's gates the weights of our gate `index`; burn's hidden bias gets `hidden_bias`.
fn set(gate: &mut GateController, layer: &LayerWeights, index: usize, hidden_bias: Option<&[f32]>, device: &Device) {
    let fill = |linear: &mut Linear, weights: &[f32], width: usize, bias: Vec<f32>| {
        let own = &weights[index * HIDDEN * width..(index + 1) * HIDDEN * width];
        let own = Tensor::<2>::from_data(TensorData::new(own.to_vec(), [HIDDEN, width]), device);
        linear.weight = Param::from_data(own.transpose().into_data(), device);
        linear.bias = Some(Param::from_data(TensorData::new(bias, [HIDDEN]), device));
    };
    let bias = layer.bias[index * HIDDEN..(index + 1) * HIDDEN].to_vec();
    let hidden_bias = hidden_bias.map_or(vec![0.0; HIDDEN], <[f32]>::to_vec);
    fill(&mut gate.input_transform, &layer.weight_ih, INPUT, bias);
    fill(&mut gate.hidden_transform, &layer.weight_hh, HIDDEN, hidden_bias);
}

/// Gradients of burn's gate in our layout: input weights, hidden weights, input bias, hidden bias.
fn gradients(gate: &GateController, of: &Gradients) -> [Vec<f32>; 4] {
    let weight = |linear: &Linear| read(linear.weight.val().grad(of).unwrap().transpose());
    let bias = |linear: &Linear| read(linear.bias.as_ref().unwrap().val().grad(of).unwrap());
    let (input, hidden) = (&gate.input_transform, &gate.hidden_transform);
    [weight(input), weight(hidden), bias(input), bias(hidden)]
}

fn layer(kind: Kind, rng: &mut ChaCha8Rng) -> LayerWeights {
    let rows = kind.gates() * HIDDEN;
    LayerWeights {
        kind,
        input: INPUT,
        hidden: HIDDEN,
        weight_ih: draw(rng, rows * INPUT),
        weight_hh: draw(rng, rows * HIDDEN),
        bias: draw(rng, 4 * HIDDEN),
    }
}

#[test]
fn outputs_and_gradients_are_the_stock_cells() {
    let device = Device::flex().autodiff();
    for kind in [Kind::Lstm, Kind::Gru] {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let layer = layer(kind, &mut rng);
        let x = TensorData::new(draw(&mut rng, BATCH * STEPS * INPUT), [BATCH, STEPS, INPUT]);
        let loss = TensorData::new(draw(&mut rng, BATCH * STEPS * HIDDEN), [BATCH, STEPS, HIDDEN]);
        let leaf = || Tensor::<3>::from_data(x.clone(), &device).require_grad();
        let backward = |y: Tensor<3>| (y * Tensor::from_data(loss.clone(), &device)).sum().backward();

        let (x_stock, x_fused) = (leaf(), leaf());
        let (y_stock, gates, of_stock) = if kind == Kind::Lstm {
            let mut stock = LstmConfig::new(INPUT, HIDDEN, true).init(&device);
            set(&mut stock.input_gate, &layer, 0, None, &device);
            set(stock.forget_gate.as_mut().unwrap(), &layer, 1, None, &device);
            set(&mut stock.cell_gate, &layer, 2, None, &device);
            set(&mut stock.output_gate, &layer, 3, None, &device);
            let (y, _) = stock.forward(x_stock.clone(), None);
            let of = backward(y.clone());
            let gates = [&stock.input_gate, stock.forget_gate.as_ref().unwrap(), &stock.cell_gate, &stock.output_gate];
            (read(y.inner()), gates.map(|gate| gradients(gate, &of)).to_vec(), of)
        } else {
            let mut stock = GruConfig::new(INPUT, HIDDEN, true).init(&device);
            set(&mut stock.reset_gate, &layer, 0, None, &device);
            set(&mut stock.update_gate, &layer, 1, None, &device);
            set(&mut stock.new_gate, &layer, 2, Some(&layer.bias[3 * HIDDEN..]), &device);
            let y = stock.forward(x_stock.clone(), None);
            let of = backward(y.clone());
            let gates = [&stock.reset_gate, &stock.update_gate, &stock.new_gate];
            (read(y.inner()), gates.map(|gate| gradients(gate, &of)).to_vec(), of)
        };

        let fused = FusedRecurrent::from_layers(std::slice::from_ref(&layer), 0.0, &device).unwrap();
        let y = fused.forward(x_fused.clone());
        let of = backward(y.clone());
        let own = &fused.layers[0];
        let join = |part: usize| gates.iter().flat_map(|gate| gate[part].clone()).collect::<Vec<f32>>();
        let mut bias = join(2);
        if kind == Kind::Gru {
            bias.extend_from_slice(&gates[2][3]);
        }
        let errors = [
            worst(&read(y.inner()), &y_stock),
            worst(&read(x_fused.grad(&of).unwrap()), &read(x_stock.grad(&of_stock).unwrap())),
            worst(&read(own.weight_ih.val().grad(&of).unwrap()), &join(0)),
            worst(&read(own.weight_hh.val().grad(&of).unwrap()), &join(1)),
            worst(&read(own.bias.val().grad(&of).unwrap()), &bias),
        ];
        println!("{kind:?}: y, x, weight_ih, weight_hh, bias differ by {errors:?}");
        assert!(errors.iter().all(|&error| error < 1e-5), "{errors:?}");
    }
}
