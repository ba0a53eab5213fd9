//! State at the end of a step as a function of its accelerations.

/// A state that is affine in its accelerations: `q = q_base + weights[0] a`, `v = v_base + weights[1] a`.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    pub(super) t: f64,
    /// Derivatives of q, v and a with respect to a; the last one is 1.
    pub(super) weights: [f64; 3],
    pub(super) q_base: Vec<f64>,
    pub(super) v_base: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) a: Vec<f64>,
}

impl Trial {
    pub(super) fn new(n: usize) -> Self {
        Self {
            t: 0.0,
            weights: [0.0; 3],
            q_base: vec![0.0; n],
            v_base: vec![0.0; n],
            q: vec![0.0; n],
            v: vec![0.0; n],
            a: vec![0.0; n],
        }
    }

    /// Takes `a` as the accelerations.
    pub(super) fn set(&mut self, a: &[f64]) {
        self.a.copy_from_slice(a);
        self.update();
    }

    /// Subtracts `da` from the accelerations.
    pub(super) fn subtract(&mut self, da: &[f64]) {
        for (a, da) in self.a.iter_mut().zip(da) {
            *a -= da;
        }
        self.update();
    }

    fn update(&mut self) {
        let Self { weights: [wq, wv, _], q_base, v_base, q, v, a, .. } = self;
        for (((q, v), (q_base, v_base)), a) in q.iter_mut().zip(v).zip(q_base.iter().zip(v_base)).zip(a) {
            *q = q_base + *wq * *a;
            *v = *v_base + *wv * *a;
        }
    }
}
