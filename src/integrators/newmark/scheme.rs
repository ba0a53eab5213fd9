//! The members of the Newmark family and their parameters.

use crate::description::signal::Cell;
use crate::error::{Checker, InvalidInput};
use crate::numerics::linalg::Complex;

/// A member of the Newmark family: the relation of displacements and velocities at the end of a step to
/// accelerations.
///
/// With the step size h and algorithmic accelerations `s`,
///
/// ```text
/// q1 = q0 + h v0 + h^2 ((1/2 - beta) s0 + beta s1)
/// v1 = v0 + h ((1 - gamma) s0 + gamma s1)
/// (1 - alpha_m) s1 + alpha_m s0 = (1 - alpha_f) a1 + alpha_f a0
/// ```
///
/// where the true accelerations `a` satisfy the equations of motion at the ends of the step. For the original
/// method of Newmark (1959) `alpha_m = alpha_f = 0` and `s = a`. The other members are the methods of Hilber,
/// Hughes and Taylor (1977) and of Chung and Hulbert (1993), in the form of Arnold and Bruels (2007), which
/// has order 2 also if the mass matrix depends on the configuration, and evaluates equations of motion only
/// at the end of a step. For a constant mass matrix it equals the original form, with forces averaged over
/// the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    beta: f64,
    gamma: f64,
    alpha_m: f64,
    alpha_f: f64,
    has_inertia: bool,
}

/// Factor of the inertia in quasi-static motions: the remaining Coriolis and centrifugal forces of slow velocities are then rounding.
/// Where a shape snaps, accelerations are scaled by its inverse.
pub(crate) const SLOWED: f64 = 1e-10;

/// Largest useful beta and gamma: those of the backward difference (Zienkiewicz 1977), the most damping member.
const LARGEST_BETA: f64 = 1.0;
const LARGEST_GAMMA: f64 = 1.5;

/// HHT is unconditionally stable for alpha in [-1/3, 0] (Hilber, Hughes and Taylor 1977).
const SMALLEST_HHT_ALPHA: f64 = -1.0 / 3.0;

/// Iterations that find how a growth is followed: other eigenvalues are lost by then, unless the growth is of no matter.
const GROWTH_STEPS: usize = 60;

/// The part of a step after a jump at which its first stage ends, `1 - 1/sqrt(2)`: the method of two stages and order 2 that removes what is
/// infinitely fast (Alexander 1977, theorem 5).
pub(crate) const FIRST_STAGE: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Largest jump of accelerations, by what it moves within a step as a part of the typical sizes of coordinates, after which steps go on as if there
/// were none.
const LARGEST_JUMP: f64 = 1e-3;

/// A gamma within that distance of the one of order 2 has order 2.
const ORDER_TOLERANCE: f64 = 1e-12;

impl Scheme {
    /// Constant average acceleration (trapezoidal rule): beta = 1/4, gamma = 1/2. Unconditionally stable, order 2,
    /// conserves the energy of linear systems.
    pub const AVERAGE_ACCELERATION: Self = Self::plain(0.25, 0.5);

    /// Linear acceleration: beta = 1/6, gamma = 1/2. Stable for `omega h <= 2 sqrt(3)`.
    pub const LINEAR_ACCELERATION: Self = Self::plain(1.0 / 6.0, 0.5);

    /// Fox and Goodwin (1949): beta = 1/12, gamma = 1/2; periods of linear undamped systems to order 4.
    /// Stable for `omega h <= sqrt(6)`.
    pub const FOX_GOODWIN: Self = Self::plain(1.0 / 12.0, 0.5);

    /// Central difference (velocity Verlet): beta = 0, gamma = 1/2. Displacements are explicit; stable for
    /// `omega h <= 2`.
    pub const CENTRAL_DIFFERENCE: Self = Self::plain(0.0, 0.5);

    /// Quasi-static motion by the backward Euler method: equilibria without inertia, whose velocities are differences of shapes. Damping
    /// and friction depend on these velocities.
    pub(crate) const QUASI_STATIC: Self = Self { has_inertia: false, ..Self::plain(1.0, 1.0) };

    const fn plain(beta: f64, gamma: f64) -> Self {
        Self { beta, gamma, alpha_m: 0.0, alpha_f: 0.0, has_inertia: true }
    }

    /// Newmark's method. `beta` in [0, 1] and `gamma` in [1/2, 3/2]: below 1/2 oscillations grow for any step
    /// size, above 1/2 the method damps them and has order 1.
    pub fn newmark(beta: f64, gamma: f64) -> Result<Self, InvalidInput> {
        let mut checker = Checker::new();
        checker.require(
            (0.0..=LARGEST_BETA).contains(&beta),
            "beta",
            beta,
            "a number in [0, 1]: below 0 short oscillations grow whatever the step",
        );
        checker.require(
            (0.5..=LARGEST_GAMMA).contains(&gamma),
            "gamma",
            gamma,
            "a number in [0.5, 1.5]: below 0.5 oscillations grow whatever the step",
        );
        checker.finish()?;
        Ok(Self::plain(beta, gamma))
    }

    /// The alpha method of Hilber, Hughes and Taylor, `alpha` in [-1/3, 0]: order 2, unconditionally stable.
    /// Smaller values damp unresolved oscillations more strongly; 0 is [`Self::AVERAGE_ACCELERATION`].
    pub fn hht(alpha: f64) -> Result<Self, InvalidInput> {
        let expected = "a number in [-1/3, 0], where the method is stable whatever the step";
        let mut checker = Checker::new();
        checker.require((SMALLEST_HHT_ALPHA..=0.0).contains(&alpha), "alpha", alpha, expected);
        checker.finish()?;
        Ok(Self::second_order(0.0, -alpha))
    }

    /// The generalised-alpha method of Chung and Hulbert, by the spectral radius `rho_inf` in [0, 1] for
    /// infinitely fast oscillations: 1 conserves them, 0 removes them in one step. Order 2, unconditionally
    /// stable, with the least damping of slow motions for given `rho_inf`.
    pub fn generalised_alpha(rho_inf: f64) -> Result<Self, InvalidInput> {
        let expected = "a number in [0, 1]: the spectral radius for infinitely fast oscillations";
        let mut checker = Checker::new();
        checker.require((0.0..=1.0).contains(&rho_inf), "rho_inf", rho_inf, expected);
        checker.finish()?;
        // Chung and Hulbert (1993), eq. 25.
        Ok(Self::second_order((2.0 * rho_inf - 1.0) / (rho_inf + 1.0), rho_inf / (rho_inf + 1.0)))
    }

    /// gamma for order 2, beta for the largest damping of fast oscillations (Chung and Hulbert 1993, eqs. 17 and 20).
    fn second_order(alpha_m: f64, alpha_f: f64) -> Self {
        let shift = alpha_m - alpha_f;
        Self {
            beta: 0.25 * (1.0 - shift) * (1.0 - shift),
            gamma: 0.5 - shift,
            alpha_m,
            alpha_f,
            has_inertia: true,
        }
    }

    /// Parameter beta of the displacement update.
    pub fn beta(&self) -> f64 {
        self.beta
    }

    /// Parameter gamma of the velocity update.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Weight of the step's start in the balance of accelerations; 0 for Newmark's method and HHT.
    pub fn alpha_m(&self) -> f64 {
        self.alpha_m
    }

    /// Weight of the step's start in the balance of forces; 0 for Newmark's method.
    pub fn alpha_f(&self) -> f64 {
        self.alpha_f
    }

    /// Order of convergence: 2, or 1 if gamma differs from `1/2 - alpha_m + alpha_f`.
    pub fn order(&self) -> usize {
        if (self.gamma - 0.5 + self.shift()).abs() < ORDER_TOLERANCE { 2 } else { 1 }
    }

    /// Largest `omega h` for which an undamped linear oscillation does not grow; infinite for unconditionally
    /// stable members (Hughes 1987, eq. 9.1.23).
    pub fn stability_limit(&self) -> f64 {
        let lack = 0.5 * self.gamma - self.beta;
        if self.is_plain() && lack > 0.0 { lack.sqrt().recip() } else { f64::INFINITY }
    }

    /// Spectral radius of the amplification matrix of a plain scheme for `x'' + c x' + k x = 0` and steps of size h, by `c h` and
    /// `k h^2` (Hughes 2000, section 9.1.2): a vibration grows where it exceeds one.
    pub(crate) fn amplification(&self, damping: f64, stiffness: f64) -> f64 {
        let Self { beta, gamma, .. } = *self;
        let leading = 1.0 + gamma * damping + beta * stiffness;
        // The eigenvalues z are the roots of z^2 - 2 half z + product.
        let half = (1.0 - (0.5 - gamma) * damping - 0.5 * (0.5 + gamma - 2.0 * beta) * stiffness) / leading;
        let product = (1.0 - (1.0 - gamma) * damping + (0.5 - gamma + beta) * stiffness) / leading;
        let discriminant = half * half - product;
        if discriminant > 0.0 { half.abs() + discriminant.sqrt() } else { product.abs().sqrt() }
    }

    /// The factor by which a step multiplies what grows as `exp(z)` in it, of `x'' = z^2 x` in steps of one: the dominant eigenvalue, by iteration.
    pub(crate) fn growth(&self, z: Complex) -> Complex {
        let Self { beta, gamma, alpha_m, alpha_f, .. } = *self;
        let square = z * z;
        let (of_true, of_state) = ((1.0 - alpha_f) / (1.0 - alpha_m), alpha_f / (1.0 - alpha_m));
        let (mut x, mut v, mut s) = (Complex::from(1.0), z, square);
        let mut factor = z.exp();
        for _ in 0..GROWTH_STEPS {
            let known = square * x * of_state - s * (alpha_m / (1.0 - alpha_m));
            let predicted = x + v + s * (0.5 - beta) + known * beta;
            let end = predicted / (Complex::from(1.0) - square * (beta * of_true));
            let after = square * end * of_true + known;
            let velocity = v + s * (1.0 - gamma) + after * gamma;
            factor = end / x;
            let inverse = Complex::from(1.0) / end;
            (x, v, s) = (Complex::from(1.0), velocity * inverse, after * inverse);
        }
        factor
    }

    /// True when algorithmic and true accelerations are the same.
    pub(super) fn is_plain(&self) -> bool {
        self.alpha_m == 0.0 && self.alpha_f == 0.0
    }

    /// Weights, in the algorithmic accelerations at the end of a step of two stages, of the accelerations at the ends of both: those
    /// that follow change as they do between these.
    pub(crate) fn after_stages(&self) -> [f64; 2] {
        let ahead = self.shift() / (1.0 - FIRST_STAGE);
        [-ahead, 1.0 + ahead]
    }

    /// Whether the step of size `h` after accelerations have jumped from one to the other is one of two stages, for coordinates of these sizes. Steps of
    /// conditionally stable members resolve what is fast.
    pub(crate) fn bridges_jump(&self, [before, after]: [&[f64]; 2], sizes: &[f64], h: f64) -> bool {
        let moves = |((before, after), size): ((&f64, &f64), &f64)| {
            h * h * (after - before).abs() > LARGEST_JUMP * size
        };
        self.has_inertia
            && self.stability_limit().is_infinite()
            && before.iter().zip(after).zip(sizes).any(moves)
    }

    /// Whether accelerations act.
    pub(crate) fn has_inertia(&self) -> bool {
        self.has_inertia
    }

    /// Whether it damps infinitely fast oscillations.
    pub(crate) fn damps(&self) -> bool {
        self.gamma + self.shift() >= 0.5 - ORDER_TOLERANCE && self.gamma > 0.5 + ORDER_TOLERANCE
    }

    /// Shift of the time of an algorithmic acceleration relative to its state, in steps.
    pub(super) fn shift(&self) -> f64 {
        self.alpha_m - self.alpha_f
    }

    /// Change of the algorithmic with the true acceleration at the end of the step.
    fn gain(&self) -> f64 {
        (1.0 - self.alpha_f) / (1.0 - self.alpha_m)
    }

    /// Derivatives of displacement, velocity and acceleration at the end of a step of size `h` with respect
    /// to the acceleration there: the weights of stiffness, damping and mass in the Jacobian of the step.
    pub fn weights(&self, h: f64) -> [f64; 3] {
        [self.gain() * self.beta * h * h, self.gain() * self.gamma * h, 1.0]
    }

    /// A step of size `h`. The lead of the algorithmic accelerations at its start over the true ones is multiplied by `memory`; `None`
    /// for a step without memory.
    pub(crate) fn step(&self, h: f64, memory: Option<f64>) -> Step {
        match memory {
            Some(stretch) => self.with_memory(h, stretch),
            None if self.is_plain() => self.with_memory(h, 1.0),
            None => self.without_memory(h),
        }
    }

    fn with_memory(&self, h: f64, stretch: f64) -> Step {
        let (alpha_m, alpha_f) = (self.alpha_m, self.alpha_f);
        let of_start = [1.0 - stretch, stretch];
        let rest =
            [(alpha_f - alpha_m * of_start[0]) / (1.0 - alpha_m), -alpha_m * of_start[1] / (1.0 - alpha_m)];
        let (bq, bv) = (h * h * (0.5 - self.beta), h * (1.0 - self.gamma));
        let (cq, cv) = (h * h * self.beta, h * self.gamma);
        let both = |b: f64, c: f64| [b * of_start[0] + c * rest[0], b * of_start[1] + c * rest[1]];
        Step {
            made_for: (h, Some(stretch)),
            weights: self.weights(h),
            displacement: both(bq, cq),
            velocity: both(bv, cv),
            rest,
            gain: self.gain(),
        }
    }

    /// The step whose algorithmic accelerations are those of true ones that change linearly over it, `s0 = a0 + shift (a1 - a0)`
    /// and `s1 = a1 + shift (a1 - a0)`. For members of order 2 this is Newmark's method with gamma = 1/2 and
    /// beta = (1 + shift^2)/4, so that it gains no momentum. Used after a corner of a load, where earlier accelerations are invalid.
    fn without_memory(&self, h: f64) -> Step {
        let shift = self.shift();
        let beta = self.beta + 0.5 * shift;
        Step {
            made_for: (h, None),
            weights: [beta * h * h, 0.5 * h, 1.0],
            displacement: [(0.5 - beta) * h * h, 0.0],
            velocity: [0.5 * h, 0.0],
            rest: [-shift, 0.0],
            gain: 1.0 + shift,
        }
    }

    /// beta and gamma of Newmark's method for accelerations that change smoothly from step to step.
    pub(crate) fn smooth_weights(&self) -> [f64; 2] {
        [self.beta + 0.5 * self.shift(), self.gamma + self.shift()]
    }

    /// The local error of the displacement is this times `h^3` and the third derivative; where accelerations change by
    /// `da` over the step, this times `h^2 da` (Zienkiewicz and Xie 1991, for algorithmic accelerations that are ahead).
    pub(super) fn displacement_error(&self) -> f64 {
        self.beta + 0.5 * self.shift() - 1.0 / 6.0
    }

    /// The local error of the velocity is this times `h da`, to leading order: 0 for the members of order 2.
    pub(super) fn velocity_error(&self) -> f64 {
        self.gamma + self.shift() - 0.5
    }

    /// The local error of the displacement also contains the first number times `h^2 x`, that of the velocity the second times `h x`,
    /// where `x` is the deviation of the algorithmic acceleration at the start from that of a smooth motion, which is
    /// ahead by `shift da`. It enters once more, with the opposite sign, through the acceleration at the end.
    pub(super) fn errors_of_memory(&self) -> [f64; 2] {
        let echo = self.alpha_m / (1.0 - self.alpha_m);
        [0.5 - self.beta - self.beta * echo, 1.0 - self.gamma - self.gamma * echo]
    }
}

/// Largest ratio of successive step sizes, after a short step to a corner of a table, for which algorithmic accelerations are kept: the
/// remainder of fast vibrations in them grows with the ratio.
const LARGEST_STRETCH: f64 = 10.0;

/// The factor of the lead of algorithmic accelerations over the true ones in a step of size `h` after one of size `before`; `None` for a
/// step without memory.
pub(crate) fn stretch(h: f64, before: f64) -> Option<f64> {
    Some(h / before).filter(|ratio| *ratio <= LARGEST_STRETCH)
}

/// The same for a step of fixed size between these times, after one that began `before`: without memory if a corner of the excitation
/// (`corner`) separates them. The first step is treated as if it followed one of its size.
pub(crate) fn memory(
    corner: impl FnOnce(Cell) -> Option<f64>,
    before: Option<f64>,
    [t, end]: [f64; 2],
) -> Option<f64> {
    let before = before.unwrap_or(t - (end - t));
    let cell = Cell { start: before, t: before, end };
    let is_corner = corner(cell).is_some_and(|corner| (corner - t).abs() <= cell.margin());
    if is_corner { None } else { stretch(end - t, t - before) }
}

/// Coefficients of a step, the same for all coordinates: of the true and algorithmic accelerations `[a, s]` at its start and of `a` at its
/// end in the state at its end. In a plain scheme `s = a`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Size of the step, and its memory of algorithmic accelerations: the arguments of [`Scheme::step`].
    pub(crate) made_for: (f64, Option<f64>),
    /// Weights of the new acceleration in displacement, velocity and acceleration.
    pub(crate) weights: [f64; 3],
    /// Weights of `[a, s]` in the displacement, beside `q + h v` and the new acceleration.
    pub(crate) displacement: [f64; 2],
    /// Weights of `[a, s]` in the velocity, beside `v` and the new acceleration.
    pub(crate) velocity: [f64; 2],
    /// Weights of `[a, s]` in the new algorithmic acceleration.
    pub(crate) rest: [f64; 2],
    /// Weight of the new acceleration in the new algorithmic one.
    pub(crate) gain: f64,
}

/// Parameters of a named method; `None` selects the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// Parameter of `newmark`. Default: 1/4.
    pub beta: Option<f64>,
    /// Parameter of `newmark`. Default: 1/2.
    pub gamma: Option<f64>,
    /// Parameter of `hht`. Default: [`Parameters::HHT_ALPHA`].
    pub alpha: Option<f64>,
    /// Parameter of `generalised_alpha`. Default: [`Parameters::RHO_INF`].
    pub rho_inf: Option<f64>,
}

impl Parameters {
    /// Default alpha of HHT: unresolved oscillations lose 18 percent per step.
    pub const HHT_ALPHA: f64 = -0.1;
    /// Default spectral radius of the generalised-alpha method: unresolved oscillations lose 20 percent per
    /// step.
    pub const RHO_INF: f64 = 0.8;

    /// Whether no parameter is given.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Names accepted by [`Scheme::by_name`].
pub const METHODS: [&str; 7] = [
    "newmark",
    "average_acceleration",
    "linear_acceleration",
    "fox_goodwin",
    "central_difference",
    "hht",
    "generalised_alpha",
];

impl Scheme {
    /// The scheme with one of the names in [`METHODS`] (or `generalized_alpha`). Parameters that the method
    /// does not have are rejected.
    pub fn by_name(name: &str, parameters: &Parameters) -> Result<Self, InvalidInput> {
        Self::with(&Parameters::by_name(name, parameters)?)
    }

    /// The scheme with these parameters: `rho_inf` chooses the generalised-alpha method, `alpha` HHT, and the others, or none,
    /// Newmark's method. Parameters of several schemes are rejected.
    pub fn with(parameters: &Parameters) -> Result<Self, InvalidInput> {
        let Parameters { beta, gamma, alpha, rho_inf } = *parameters;
        let all = [("rho_inf", rho_inf), ("alpha", alpha), ("beta", beta), ("gamma", gamma)];
        let mut given = all.into_iter().filter_map(|(name, value)| Some((name, value?)));
        let (first, second) = (given.next(), given.next());
        if let (Some((one, _)), Some((other, value))) = (first, second)
            && one != "beta"
        {
            let expected = format!("nothing: {one} and {other} are parameters of different methods");
            return Err(InvalidInput::new(other, value, expected));
        }
        match *parameters {
            Parameters { rho_inf: Some(rho_inf), .. } => Self::generalised_alpha(rho_inf),
            Parameters { alpha: Some(alpha), .. } => Self::hht(alpha),
            _ => Self::newmark(beta.unwrap_or(0.25), gamma.unwrap_or(0.5)),
        }
    }
}

impl Parameters {
    /// Parameters of the scheme with one of the names in [`METHODS`] (or `generalized_alpha`), with its defaults; those of `newmark` are
    /// unchanged, and may be of any scheme, as for [`Scheme::with`]. Parameters that the method does not have are rejected.
    pub fn by_name(name: &str, given: &Self) -> Result<Self, InvalidInput> {
        let Self { beta, gamma, alpha, rho_inf } = *given;
        let taken: &[&str] = match name {
            "newmark" => &["beta", "gamma", "alpha", "rho_inf"],
            "hht" => &["alpha"],
            "generalised_alpha" | "generalized_alpha" => &["rho_inf"],
            _ if METHODS.contains(&name) => &[],
            _ => return Err(InvalidInput::new("method", format!("{name:?}"), one_of(&METHODS))),
        };
        let mut checker = Checker::new();
        for (value, parameter) in [(beta, "beta"), (gamma, "gamma"), (alpha, "alpha"), (rho_inf, "rho_inf")] {
            if let Some(value) = value
                && !taken.contains(&parameter)
            {
                let expected = format!("nothing: method {name:?} has no {parameter}");
                checker.require(false, parameter, value, &expected);
            }
        }
        checker.finish()?;
        let of =
            |scheme: Scheme| Self { beta: Some(scheme.beta), gamma: Some(scheme.gamma), ..Self::default() };
        Ok(match name {
            "newmark" => *given,
            "average_acceleration" => of(Scheme::AVERAGE_ACCELERATION),
            "linear_acceleration" => of(Scheme::LINEAR_ACCELERATION),
            "fox_goodwin" => of(Scheme::FOX_GOODWIN),
            "central_difference" => of(Scheme::CENTRAL_DIFFERENCE),
            "hht" => Self { alpha: alpha.or(Some(Self::HHT_ALPHA)), ..Self::default() },
            _ => Self { rho_inf: rho_inf.or(Some(Self::RHO_INF)), ..Self::default() },
        })
    }
}

fn one_of(names: &[&str]) -> String {
    format!("one of {}", names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", "))
}
