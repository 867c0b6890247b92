//! Adam in one pass over each parameter.

use burn::optim::{AdamState, AdaptiveMomentumState, LearningRate, Optimizer};
use burn::tensor::{Device, Tensor, TensorData};
use pulp::{Simd, WithSimd};

use super::Level;

/// Adam with the formula and state of burn's own, bit by bit, without a tensor for every operation.
#[derive(Debug, Clone)]
pub struct Adam {
    beta_1: f32,
    beta_2: f32,
    epsilon: f32,
}

impl Adam {
    /// With the usual `β₁` = 0.9 and `β₂` = 0.999.
    #[must_use]
    pub fn new(epsilon: f32) -> Self {
        Self { beta_1: 0.9, beta_2: 0.999, epsilon }
    }
}

impl Optimizer for Adam {
    type State<const D: usize> = AdamState<D>;

    fn step<const D: usize>(
        &self,
        rate: LearningRate,
        tensor: Tensor<D>,
        gradient: Tensor<D>,
        state: Option<AdamState<D>>,
    ) -> (Tensor<D>, Option<AdamState<D>>) {
        let device = tensor.device();
        let state = state.unwrap_or_else(|| {
            let zeros = || Tensor::zeros(tensor.shape(), &device);
            AdamState::new(AdaptiveMomentumState::new(0, zeros(), zeros()))
        });
        let time = state.momentum.time + 1;
        let mut data = [tensor, gradient, state.momentum.moment_1, state.momentum.moment_2]
            .map(|tensor| tensor.into_data().convert::<f32>());
        let passes = i32::try_from(time).unwrap_or(i32::MAX);
        let root = (1.0 - self.beta_2.powi(passes)).sqrt();
        let [values, gradient, moment_1, moment_2] = data.each_mut().map(|data| data.as_mut_slice::<f32>().unwrap_or_default());
        Level::detect().run(Update {
            adam: self,
            rate: rate as f32,
            scale: root / (1.0 - self.beta_1.powi(passes)),
            floor: self.epsilon * root,
            values,
            gradient,
            moment_1,
            moment_2,
        });
        let [values, _, moment_1, moment_2] = data;
        let tensor = |data: TensorData| Tensor::from_data(data, &device);
        (tensor(values), Some(AdamState::new(AdaptiveMomentumState::new(time, tensor(moment_1), tensor(moment_2)))))
    }

    fn to_device<const D: usize>(mut state: AdamState<D>, device: &Device) -> AdamState<D> {
        state.momentum = state.momentum.to_device(device);
        state
    }
}

/// A step of a parameter.
struct Update<'a> {
    adam: &'a Adam,
    rate: f32,
    /// Bias correction: removes the zero initialisation of both moments from the step.
    scale: f32,
    floor: f32,
    values: &'a mut [f32],
    gradient: &'a [f32],
    moment_1: &'a mut [f32],
    moment_2: &'a mut [f32],
}

impl WithSimd for Update<'_> {
    type Output = ();

    /// Plain code, vectorised by the compiler for the level.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { rate, scale, floor, values, gradient, moment_1, moment_2, .. } = self;
        let &Adam { beta_1, beta_2, .. } = self.adam;
        for (((value, &g), m), v) in values.iter_mut().zip(gradient).zip(moment_1).zip(moment_2) {
            *m = *m * beta_1 + g * (1.0 - beta_1);
            *v = *v * beta_2 + g * g * (1.0 - beta_2);
            *value -= *m * scale / (v.sqrt() + floor) * rate;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::module::{Module, Param};
    use burn::optim::{AdamConfig, GradientsParams, ModuleOptimizer};

    #[derive(Module, Debug)]
    struct Line {
        weight: Param<Tensor<2>>,
    }

    #[test]
    fn every_bit_is_that_of_burn_s_own() {
        let device = Device::flex().autodiff();
        let x: Vec<f32> = (0..7 * 37).map(|i| (i as f32 * 0.7).sin()).collect();
        let x = Tensor::<2>::from_data(TensorData::new(x, [7, 37]), &device);
        let run = |mut adam: ModuleOptimizer| -> Vec<f32> {
            let mut line = Line { weight: Param::from_data(TensorData::new(vec![0.1_f32; 37 * 5], [37, 5]), &device) };
            for step in 0..20 {
                let error = x.clone().matmul(line.weight.val()) - 0.3;
                let gradients = (error.clone() * error).mean().backward();
                let gradients = GradientsParams::from_grads(gradients, &line);
                line = adam.step(1e-2 / f64::from(step + 1), line, gradients);
            }
            line.weight.val().into_data().try_into_vec().unwrap_or_default()
        };
        let own = run(Adam::new(1e-8).into());
        assert_eq!(own.len(), 37 * 5);
        assert_eq!(own, run(AdamConfig::new().with_epsilon(1e-8).init()));
    }
}
