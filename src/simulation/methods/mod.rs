//! Methods of simulations with their options, as users describe them.

mod tolerance;

use crate::description::schema::{Described, Reader};
use crate::error::{Checker, InvalidInput};
use crate::integrators::newmark;
use crate::integrators::newmark::{ATOL, Impacts, Parameters, Predictor, RTOL, Scheme, StepSize};
use crate::integrators::ode;
use crate::integrators::ode::Tolerance;
use crate::integrators::radau;
use crate::numerics::roots::Derivative;
use crate::simulation::accuracy;
use crate::simulation::stepping::Method;

/// Jacobian of a step of the Newmark family.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Described)]
pub enum Jacobian {
    /// Exact.
    #[default]
    Analytic,
    /// Forward differences.
    Forward,
    /// Central differences.
    Central,
}

/// Implicit methods of second order with steps of the size `dt`, by inverse dynamics: Newmark's, HHT and generalised-alpha.
///
/// The parameters choose the method: `beta` and `gamma` that of Newmark, `alpha` HHT, `rho_inf` the generalised-alpha method.
/// Without any, it is Newmark's average acceleration, and for models with contact or closed loops, which need numerical
/// damping, the generalised-alpha method with ``rho_inf=0.8``.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(concise, check = Newmark::fits, example = include_str!("newmark.txt"))]
pub struct Newmark {
    /// Spectral radius at infinite frequency, in [0, 1]: the factor by which a step multiplies infinitely fast oscillations.
    pub rho_inf: Option<f64>,
    /// Parameter of HHT, in [-1/3, 0].
    pub alpha: Option<f64>,
    /// Parameter of Newmark's method; by default 0.25.
    pub beta: Option<f64>,
    /// Parameter of Newmark's method; by default 0.5.
    pub gamma: Option<f64>,
    /// Relative tolerance. A step is solved until the estimated error of the
    /// acceleration i is far below ``atol[i] + rtol[i] * abs(a[i])``; adaptive steps keep the local errors of coordinate and
    /// velocity i below ``atol[i] + rtol[i] * abs(q[i])`` and ``atol[i] + rtol[i] * abs(v[i])``, in the root mean square.
    #[part(non_negative, default = Tolerance::Same(RTOL))]
    pub rtol: Tolerance,
    /// Absolute tolerance, in the unit of q, of q per second, and of q per second squared. By default errors of accelerations near zero
    /// move coordinates by rounding alone, in any units, and adaptive steps keep local errors with 1e-9.
    #[part(non_negative)]
    pub atol: Option<Tolerance>,
    /// Whether steps are adapted by an error estimate, beginning with `dt`.
    #[part(default = false)]
    pub adaptive: bool,
    /// Longest adaptive step; by default any.
    #[part(unit = "seconds", positive)]
    pub max_step: Option<f64>,
    /// Shortest adaptive step.
    #[part(unit = "seconds", non_negative, default = 0.0)]
    pub min_step: f64,
    /// Maximum number of accepted steps; by default unlimited.
    pub max_steps: Option<usize>,
    /// Jacobian of a step: exact, by forward differences (n additional evaluations) or by central differences (2n).
    #[part(default = Jacobian::Analytic)]
    pub jac: Jacobian,
    /// Accelerations with which Newton's method begins in a step: those of the last step, zero, or whichever of zero, the last
    /// ones and an extrapolation of the last two was best in the last step.
    #[part(default)]
    pub predictor: Predictor,
    /// Whether factorised Jacobians are used again while they converge; otherwise every Newton iteration evaluates one.
    #[part(default = true)]
    pub reuse_jacobian: bool,
    /// Treatment of impacts that take less than ten steps of fixed size. Resolved: steps with impacts that matter are repeated by Radau's
    /// method, with a bound of the work (see ``docs/contact.md``). Stopped: bodies that collide within a step do not rebound, with a warning
    /// if that takes much energy. ``"auto"`` resolves them in robots of rigid parts, and stops them in those with rods.
    /// In robots with tendons that do not stretch they are stopped.
    #[part(default)]
    pub impacts: Impacts,
}

/// An adaptive method; they have the same options.
macro_rules! adaptive {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        pub struct $name {
            /// Relative tolerance: the local errors of coordinate and velocity i are kept below
            /// ``atol[i] + rtol[i] * abs(q[i])`` and ``atol[i] + rtol[i] * abs(v[i])``, in the root mean square.
            #[part(non_negative, default = Tolerance::Same(RTOL))]
            pub rtol: Tolerance,
            /// Absolute tolerance, in the unit of q and of q per second.
            #[part(non_negative, default = Tolerance::Same(ATOL))]
            pub atol: Tolerance,
            /// Longest step; by default any. Steps end at the times of tables, and there are at least four per period of
            /// harmonic loads and base motions. Choose it shorter than a pulse in a function of time, which a step could miss.
            #[part(unit = "seconds", positive)]
            pub max_step: Option<f64>,
            /// Shortest step.
            #[part(unit = "seconds", non_negative, default = 0.0)]
            pub min_step: f64,
            /// Maximum number of accepted steps; by default unlimited.
            pub max_steps: Option<usize>,
        }

        impl $name {
            /// Options of this method of first order for a motion of `n` coordinates.
            fn options(&self, method: ode::Method, n: usize) -> Result<ode::Options, InvalidInput> {
                Ok(ode::Options {
                    method,
                    rtol: tolerance::of_states(&self.rtol, n, "rtol")?,
                    atol: tolerance::of_states(&self.atol, n, "atol")?,
                    max_step: self.max_step.unwrap_or(f64::INFINITY),
                    min_step: self.min_step,
                    max_steps: self.max_steps.unwrap_or(usize::MAX),
                    ..ode::Options::default()
                })
            }
        }
    };
}

adaptive! {
    /// Implicit method of order 5 with adaptive steps, Radau IIA, by inverse dynamics: for stiff models at small errors.
    #[derive(Clone, Debug, PartialEq, Described)]
    #[part(concise, example = include_str!("radau.txt"))]
    Radau
}

adaptive! {
    /// Explicit method of order 5 with adaptive steps, of Dormand and Prince, by forward dynamics.
    #[derive(Clone, Debug, PartialEq, Described)]
    #[part(concise, name = "RK45")]
    Rk45
}

adaptive! {
    /// Explicit method of order 8 with adaptive steps, of Dormand and Prince, by forward dynamics: for smooth motions at small
    /// errors.
    #[derive(Clone, Debug, PartialEq, Described)]
    #[part(concise, name = "DOP853")]
    Dop853
}

/// Equilibria under inputs, loads and prescribed motions that change slowly: steps of the size `dt` without inertia, by the backward Euler
/// method.
///
/// The velocity of a step is the change of the shape over it, so that friction sticks and slides, dampers and viscous materials follow, and
/// results depend on the direction and the history of the motion: insertion of catheters, ropes that are dragged. Nothing vibrates, so that
/// steps may be as long as the changes of loads allow; the error is proportional to them. The first step leads from `q0` to the equilibrium.
/// Steps in which a sticking contact slips, a shape snaps through, or nothing holds a part are made with inertia and lose its energy, with
/// a warning.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(concise)]
pub struct QuasiStatic {
    /// Relative tolerance of the equations of a step, of how far coordinates move in it.
    #[part(non_negative, default = Tolerance::Same(RTOL))]
    pub rtol: Tolerance,
    /// Absolute tolerance of the equations, in the unit of q per second squared: an error of ``atol * dt**2`` of a coordinate. By default,
    /// and at most, errors are 1e-9 of the sizes of coordinates: a radian, one over the length, or the length.
    #[part(non_negative)]
    pub atol: Option<Tolerance>,
    /// Maximum number of accepted steps; by default unlimited.
    pub max_steps: Option<usize>,
}

/// The method and steps that reach an accuracy, chosen among the adaptive methods by the stiffness of the model.
///
/// Runs are repeated until the estimated error of the tip is at most `rtol` times the length; see ``docs/accuracy.md``.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(concise, check = Auto::fits)]
pub struct Auto {
    /// Largest error of the tip relative to the model's length.
    #[part(positive, default = accuracy::DEFAULT_RTOL)]
    pub rtol: f64,
    /// Longest step; by default any.
    #[part(unit = "seconds", positive)]
    pub max_step: Option<f64>,
    /// Maximum number of accepted steps of each run; by default a million.
    pub max_steps: Option<usize>,
    /// Whether errors by the numbers of modes and nodes are estimated, and nodes added. Without, `rtol` bounds those of the
    /// time steps alone, at 0.4 to 0.9 of the cost.
    #[part(default = true)]
    pub space_error: bool,
}

/// A method with its options.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum Integration {
    /// The Newmark family.
    Newmark(Newmark),
    /// Radau IIA.
    Radau(Radau),
    /// The pair of order 5.
    Rk45(Rk45),
    /// The pair of order 8.
    Dop853(Dop853),
    /// Equilibria under what changes slowly.
    QuasiStatic(QuasiStatic),
    /// Whatever reaches an accuracy.
    Auto(Auto),
}

/// How a motion is computed.
#[derive(Clone, Debug, PartialEq)]
pub enum Configuration {
    /// By a method.
    Method(Method),
    /// By any method that reaches the requested accuracy.
    Accuracy(accuracy::Request),
}

impl Configuration {
    /// Size of fixed steps, or interval of output times.
    pub fn dt(&self) -> f64 {
        match self {
            Self::Method(method) => method.dt(),
            Self::Accuracy(request) => request.dt,
        }
    }
}

impl Integration {
    /// The way to compute a motion of `n` coordinates with steps of the size `dt`, or with output at this interval.
    ///
    /// # Errors
    /// Options that do not fit.
    pub fn configuration(
        &self,
        n: usize,
        dt: f64,
        needs_damping: bool,
        returns_steps: bool,
    ) -> Result<Configuration, InvalidInput> {
        let first_order = |options| Configuration::Method(Method::FirstOrder { options, dt, returns_steps });
        Ok(match self {
            Self::Newmark(newmark) => {
                Configuration::Method(Method::Newmark(newmark.options(dt, needs_damping)?))
            }
            Self::Radau(radau) => {
                let options = radau::Options::from(radau.options(ode::Method::Radau, n)?);
                Configuration::Method(Method::Radau { options, dt, returns_steps })
            }
            Self::Rk45(rk45) => first_order(rk45.options(ode::Method::Rk45, n)?),
            Self::Dop853(dop853) => first_order(dop853.options(ode::Method::Dop853, n)?),
            Self::QuasiStatic(quasi_static) => {
                Configuration::Method(Method::Newmark(quasi_static.options(dt)))
            }
            Self::Auto(auto) => Configuration::Accuracy(auto.request(dt)),
        })
    }
}

impl Newmark {
    fn fits(&self, reader: &mut Reader) {
        let mut check = Checker::new();
        check.nested("", self.scheme(false).map(|_| ()));
        check.nested("", self.step_size().map(|_| ()));
        let is_followed = self.adaptive && self.impacts == Impacts::Resolved;
        check.require(
            !is_followed,
            "impacts",
            "'resolved'",
            "'stopped': adaptive steps follow impacts anyway",
        );
        reader.nested(check);
    }

    /// The scheme; without parameters average acceleration, or one with numerical damping if needed.
    ///
    /// # Errors
    /// Parameters of several methods, or such that make no method.
    fn scheme(&self, needs_damping: bool) -> Result<Scheme, InvalidInput> {
        let Self { beta, gamma, alpha, rho_inf, .. } = *self;
        let parameters = Parameters { beta, gamma, alpha, rho_inf };
        match parameters.is_empty() && needs_damping {
            true => Scheme::generalised_alpha(Parameters::RHO_INF),
            false => Scheme::with(&parameters),
        }
    }

    fn step_size(&self) -> Result<StepSize, InvalidInput> {
        StepSize::new(self.adaptive, self.max_step, self.min_step)
    }

    /// Options of steps of this size.
    ///
    /// # Errors
    /// Invalid parameters.
    fn options(&self, dt: f64, needs_damping: bool) -> Result<newmark::Options, InvalidInput> {
        Ok(newmark::Options {
            scheme: self.scheme(needs_damping)?,
            step_size: self.step_size()?,
            derivative: match self.jac {
                Jacobian::Analytic => Derivative::Analytic,
                Jacobian::Forward => Derivative::Forward,
                Jacobian::Central => Derivative::Central,
            },
            rtol: self.rtol.clone(),
            atol: self.atol.clone(),
            predictor: self.predictor,
            reuse_jacobian: self.reuse_jacobian,
            impacts: self.impacts,
            max_steps: self.max_steps.unwrap_or(usize::MAX),
            ..newmark::Options::new(dt)
        })
    }
}

impl QuasiStatic {
    /// Options of steps of this size.
    fn options(&self, dt: f64) -> newmark::Options {
        newmark::Options {
            scheme: Scheme::QUASI_STATIC,
            rtol: self.rtol.clone(),
            atol: self.atol.clone(),
            impacts: Impacts::Stopped,
            max_steps: self.max_steps.unwrap_or(usize::MAX),
            ..newmark::Options::new(dt)
        }
    }
}

impl Auto {
    fn fits(&self, reader: &mut Reader) {
        let mut check = Checker::new();
        check.nested("", self.request(1.0).validate());
        reader.nested(check);
    }

    fn request(&self, dt: f64) -> accuracy::Request {
        let default = accuracy::Request::new(self.rtol, dt);
        accuracy::Request {
            max_steps: self.max_steps.unwrap_or(default.max_steps),
            max_step: self.max_step.unwrap_or(default.max_step),
            space_error: self.space_error,
            ..default
        }
    }
}
