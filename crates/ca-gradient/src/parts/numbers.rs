//! Numbers that a scene begins with, their indices and their derivatives.

use crate::difference::{Start, derivatives};
use crate::parameter::put;
use crate::{Error, Parameter};
use ca_compile::load::finish;
use ca_core::Scene;
use ca_core::internal::scene;
use ca_model::diag::Diags;
use cordis_anima::{Loaded, Options, catalog};

pub struct Numbers {
    /// The scene with each number replaced by its index.
    pub place: Scene,
    pub count: usize,
    /// Derivatives of the numbers, per parameter.
    pub derivatives: Vec<Vec<f64>>,
}

impl Numbers {
    /// Differentiates the numbers of a model, compiled with these options.
    ///
    /// # Errors
    /// If the model has errors, or a parameter cannot be differentiated.
    pub fn new(loaded: &Loaded, options: &Options, parameters: &[Parameter]) -> Result<Numbers, Error> {
        let mut place = loaded.compile(options)?.scene;
        let start = Start::of(&mut place);
        let kinds = catalog();
        let bounds = Options { bounds_only: true, clouds: loaded.clouds.clone(), ..options.clone() };
        let mut all = Vec::new();
        for p in parameters {
            let other = |value: f64| {
                let found = finish(&put(p, &loaded.model, value), Diags::new(), &kinds, &bounds);
                found.map(|mut c| Start::of(&mut c.scene)).map_err(|diags| Error::first(&diags))
            };
            all.push(derivatives(&start, p, &other)?);
        }
        let mut count = 0.0;
        scene::numbers(&mut place, &mut |v| {
            *v = count;
            count += 1.0;
        });
        Ok(Numbers { place, count: start.len(), derivatives: all })
    }
}
