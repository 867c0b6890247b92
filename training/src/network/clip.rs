//! Clipping of all gradients together: burn's own clips each tensor alone, which bends the step's direction.

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::Tensor;

/// Norm of all of `module`'s gradients together: `√Σg²`.
#[must_use]
pub fn global_norm<M: Module>(gradients: &GradientsParams, module: &M) -> f64 {
    let mut squares = Squares { gradients, sum: 0.0 };
    module.visit(&mut squares);
    squares.sum.sqrt()
}

/// Shortens the gradients to a global norm of `limit` where it is larger, keeping their direction; returns the norm before.
pub fn clip_global_norm<M: Module>(gradients: &mut GradientsParams, module: &M, limit: f64) -> f64 {
    let norm = global_norm(gradients, module);
    if norm > limit && norm.is_finite() {
        module.visit(&mut Scale { gradients, factor: limit / norm });
    }
    norm
}

struct Squares<'a> {
    gradients: &'a GradientsParams,
    sum: f64,
}

impl ModuleVisitor for Squares<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.get::<D>(param.id) {
            self.sum += gradient.into_data().iter::<f64>().map(|g| g * g).sum::<f64>();
        }
    }
}

struct Scale<'a> {
    gradients: &'a mut GradientsParams,
    factor: f64,
}

impl ModuleVisitor for Scale<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.remove::<D>(param.id) {
            self.gradients.register::<D>(param.id, gradient.mul_scalar(self.factor));
        }
    }
}
