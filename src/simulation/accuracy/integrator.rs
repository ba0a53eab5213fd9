//! The explicit and the implicit method, with their error constants.

use crate::integrators::ode;
use crate::integrators::radau;
use crate::simulation::simulate::Method;

use super::request::Request;

/// Properties of a method.
#[derive(Debug, PartialEq)]
pub(super) struct Integrator {
    pub(super) name: &'static str,
    /// Order of the error of a motion in the step size.
    pub(super) order: i32,
    /// A step h multiplies a vibration of rate omega by `exp(i omega h) (1 + e)` with `|e| = omega h (omega
    /// h)^order / constant`: from the stability functions (Hairer and Wanner 1996, sections IV.3 and IV.10;
    /// for DOP853 from its coefficients). The error of Radau is dissipation, that of DOP853 a phase error.
    constant: f64,
    /// Largest step, times the frequency, for which this formula holds.
    pub(super) longest: f64,
    /// Longest stable step times the largest rate: 6.1 for DOP853 (Hairer and Wanner 1996, section IV.2),
    /// reduced to allow for a growing rate.
    pub(super) stability: f64,
    /// Step required for accuracy, times the largest frequency to be resolved, over `tolerance^(1/order)`:
    /// measured on the lab's rod.
    pub(super) step: f64,
    /// Cost of a step in units of inverse dynamics: twelve forward dynamics for DOP853; about three
    /// iterations of three residuals, and the tangents, for Radau.
    pub(super) cost: f64,
    /// The error of a run is proportional to this power of its tolerance. The local error estimate of a step
    /// of size h is of order h^8 for DOP853, whose global error is of order h^8, and of order h^4 for Radau,
    /// whose global error is of order h^5.
    pub(super) exponent: f64,
}

pub(super) static DOP853: Integrator = Integrator {
    name: "dop853",
    order: 8,
    constant: 1.4e7,
    longest: 3.0,
    stability: 4.0,
    step: 6.0,
    cost: 30.0,
    exponent: 1.0,
};

pub(super) static RADAU: Integrator = Integrator {
    name: "radau",
    order: 5,
    constant: 7.2e3,
    longest: 3.0,
    stability: f64::INFINITY,
    step: 4.0,
    cost: 20.0,
    exponent: 1.25,
};

/// Relative tolerance of Radau over the tolerance of a run, which is absolute. Prevents tolerances below the
/// rounding of large coordinates.
const RADAU_RELATIVE: f64 = 1e-2;

impl Integrator {
    /// Relative error of a vibration per radian for steps of this size.
    pub(super) fn error_of_a_radian(&self, frequency: f64, step: f64) -> f64 {
        (frequency * step).powi(self.order) / self.constant
    }

    /// Step, times the frequency, that causes this error.
    pub(super) fn step_of_error(&self, error: f64) -> f64 {
        (self.constant * error).powf(1.0 / f64::from(self.order))
    }

    /// Ratio of steps at a tolerance that is smaller by this factor.
    pub(super) fn shorter(&self, factor: f64) -> f64 {
        factor.powf(1.0 / f64::from(self.order))
    }

    /// Expected ratio of the errors of a looser run and of this one, each given by its tolerance and number
    /// of steps: from the tolerances, but not more than the numbers of steps support.
    pub(super) fn gain(&self, [looser, this]: [(f64, f64); 2]) -> f64 {
        let expected = (looser.0 / this.0).powf(self.exponent);
        let seen = (this.1 / looser.1).powi(self.order);
        expected.min(seen).max(1.0)
    }

    /// The method with tolerances for errors up to `tolerance`, of coordinates relative to `sizes` and of
    /// velocities relative to `sizes` times `frequency`.
    pub(super) fn method(&self, sizes: &[f64], frequency: f64, tolerance: f64, request: Request) -> Method {
        let Request { dt, max_steps, max_step, .. } = request;
        let of_velocities = sizes.iter().map(|size| size * frequency * tolerance);
        let atol: Vec<f64> = sizes.iter().map(|size| size * tolerance).chain(of_velocities).collect();
        if *self == DOP853 {
            let options = ode::Options {
                method: ode::Method::Dop853,
                rtol: 0.0.into(),
                atol: atol.into(),
                max_steps,
                max_step,
                ..ode::Options::default()
            };
            Method::FirstOrder { options, dt, returns_steps: false }
        } else {
            let options = radau::Options {
                rtol: (RADAU_RELATIVE * tolerance).into(),
                atol: atol.into(),
                max_steps,
                max_step,
                ..radau::Options::default()
            };
            Method::Radau { options, dt, returns_steps: false }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    /// `(1 + 2 z/5 + z^2/20) / (1 - 3 z/5 + 3 z^2/20 - z^3/60)`, the stability function of Radau.
    fn radau(z: Complex<f64>) -> Complex<f64> {
        let one = Complex::from(1.0);
        (one + z * 0.4 + z * z * 0.05) / (one - z * 0.6 + z * z * 0.15 - z * z * z / 60.0)
    }

    #[test]
    fn what_a_step_of_radau_does_is_known_and_not_more_where_steps_are_long() {
        for (angle, slack) in [(0.1, 1.02), (0.5, 1.1), (1.0, 1.2), (RADAU.longest, 2.0)] {
            let exact = (radau(Complex::new(0.0, angle)) / Complex::new(0.0, angle).exp() - 1.0).norm();
            let estimated = angle * RADAU.error_of_a_radian(1.0, angle);
            assert!((1.0 / slack..slack).contains(&(estimated / exact)), "{angle}: {estimated} for {exact}");
        }
    }

    #[test]
    fn a_gain_is_what_the_steps_bear_out() {
        let [expected, none, some] =
            [1000.0, 100.0, 120.0].map(|steps| RADAU.gain([(1e-2, 100.0), (1e-3, steps)]));
        assert!((expected - 10.0_f64.powf(1.25)).abs() < 1e-12);
        assert_eq!(none, 1.0);
        assert!((some - 1.2_f64.powi(5)).abs() < 1e-12);
    }

    #[test]
    fn the_step_of_an_error_has_that_error() {
        for integrator in [&RADAU, &DOP853] {
            let step = integrator.step_of_error(1e-4);
            assert!((integrator.error_of_a_radian(1.0, step) / 1e-4 - 1.0).abs() < 1e-12);
        }
    }
}
