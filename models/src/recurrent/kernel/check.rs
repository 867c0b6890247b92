//! The kernels' gradients compared with central differences, and plain code with vectors.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{AtInput, Ends, Level, PackedLayer, Pass, Shape, Tape, Weights, Work, backward, forward};
use crate::recurrent::Kind;

/// Sizes with remainders in all dimensions: rows, columns, vectors.
const SHAPE: Shape = Shape { steps: 6, batch: 9, input: 5, hidden: 21 };

/// Input, the three weights, `h0`, `c0`, and the loss's weights on the outputs.
struct Case {
    kind: Kind,
    values: [Vec<f32>; 6],
    loss: Vec<f32>,
}

impl Case {
    fn new(kind: Kind, shape: Shape) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut draw = |count: usize, size: f32| -> Vec<f32> { (0..count).map(|_| size * rng.random_range(-1.0..1.0)).collect() };
        let rows = kind.gates() * shape.hidden;
        let cell = if kind == Kind::Lstm { shape.state() } else { 0 };
        Self {
            kind,
            values: [
                draw(shape.rows() * shape.input, 1.0),
                draw(rows * shape.input, 0.4),
                draw(rows * shape.hidden, 0.4),
                draw(4 * shape.hidden, 0.5),
                draw(shape.state(), 0.8),
                draw(cell, 0.8),
            ],
            loss: draw(shape.rows() * shape.hidden, 1.0),
        }
    }

    fn weights(&self) -> Weights<'_> {
        Weights { kind: self.kind, input: &self.values[1], hidden: &self.values[2], bias: &self.values[3] }
    }

    fn run(&self, level: Level, shape: Shape) -> Tape {
        let layer = PackedLayer::new(level, &self.weights(), shape.input, shape.hidden);
        let mut tape = Tape::default();
        let [x, _, _, _, h0, c0] = &self.values;
        forward(&layer, shape, x, h0, c0, &mut tape, |_| ());
        tape
    }

    fn loss(&self, shape: Shape) -> f64 {
        let tape = self.run(Level::detect(), shape);
        tape.outputs().iter().zip(&self.loss).map(|(&y, &w)| f64::from(y) * f64::from(w)).sum()
    }

    fn gradients(&self, level: Level, shape: Shape) -> (Vec<f32>, [Vec<f32>; 6]) {
        let tape = self.run(level, shape);
        let outputs = tape.outputs().to_vec();
        let pass = Pass { weights: self.weights(), shape, x: &self.values[0], tape: &tape };
        let mut at_outputs = self.loss.clone();
        let mut x = vec![0.0; pass.x.len()];
        let ends = Ends { outputs: &mut at_outputs, input: AtInput::Into(&mut x) };
        let made = backward(level, &pass, ends, &mut Work::default());
        if shape.input == shape.hidden {
            // The same in the memory of the outputs' gradient.
            let mut over = self.loss.clone();
            let ends = Ends { outputs: &mut over, input: AtInput::OverOutputs };
            backward(level, &pass, ends, &mut Work::default());
            assert_eq!(over, x);
        }
        (outputs, [x, made.input, made.hidden, made.bias, made.h0, made.c0])
    }
}

#[test]
fn gradients_are_the_loss_s_differences() {
    for kind in [Kind::Lstm, Kind::Gru] {
        let mut case = Case::new(kind, SHAPE);
        let (_, gradients) = case.gradients(Level::detect(), SHAPE);
        let mut worst = 0.0_f64;
        for (part, gradient) in gradients.iter().enumerate() {
            assert_eq!(gradient.len(), case.values[part].len());
            for index in (0..gradient.len()).step_by(7) {
                let value = case.values[part][index];
                let mut at = |shift: f32| {
                    case.values[part][index] = value + shift;
                    case.loss(SHAPE)
                };
                let difference = (at(1e-2) - at(-1e-2)) / 2e-2;
                case.values[part][index] = value;
                worst = worst.max((difference - f64::from(gradient[index])).abs());
            }
        }
        assert!(worst < 5e-4, "{kind:?}: {worst}");
    }
}

#[test]
fn every_level_and_repetition_agrees() {
    let largest = |a: &[f32], b: &[f32]| {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).fold(0.0_f32, |worst, (a, b)| worst.max((a - b).abs() / (1.0 + b.abs())))
    };
    let small = Shape { batch: 1, ..SHAPE };
    let long = Shape { steps: 90, batch: 7, input: 33, hidden: 37 };
    let even = Shape { steps: 9, batch: 5, input: 32, hidden: 32 };
    for kind in [Kind::Lstm, Kind::Gru] {
        for shape in [SHAPE, small, long, even] {
            let case = Case::new(kind, shape);
            let (y, gradients) = case.gradients(Level::detect(), shape);
            let (y_plain, plain) = case.gradients(Level::portable(), shape);
            assert!(largest(&y, &y_plain) < 1e-5);
            for (fast, plain) in gradients.iter().zip(&plain) {
                assert!(largest(fast, plain) < 1e-5, "{kind:?} {}", largest(fast, plain));
            }
            // The same bits again.
            assert_eq!((y, gradients), case.gradients(Level::detect(), shape));
        }
    }
}
