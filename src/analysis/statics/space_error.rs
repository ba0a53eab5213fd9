//! Error of an equilibrium due to the finite number of modes.
//!
//! The strains that the modes leave out follow from the balance of the forces in the shape
//! ([`Refinable::missing_strain`](crate::model::Refinable::missing_strain)); their displacements under constant forces cost little
//! more than an evaluation of these forces. Changes of the forces with the shape make the true error smaller under tension and larger
//! under compression, at most by the inverse of the lowest eigenvalue of the stiffness relative to that of the material. If the
//! error is not clearly small, one Newton step in a model with more modes, from the same shape, estimates it with all changes of forces,
//! loops and contacts (a hierarchical estimate: Bank and Weiser 1985). The remaining error of that model follows from the balance in the
//! new shape.

use super::outcome::Equilibrium;
use crate::analysis::refined::with_more_modes;
use crate::analysis::stability::Stability;
use crate::description::rod::STRAIN_NAMES;
use crate::error::{Interrupted, Number};
use crate::model::constraint::one_sided;
use crate::model::{MissingStrain, Model, RigidStretch};
use crate::numerics::linalg::{Lu, Matrix, minimum_norm_solution, norm};

/// Errors above this part of the length are worth a warning.
pub const LARGE: f64 = 1e-2;

/// Up to this part of the length, displacements by missing strains under constant forces are a sufficient estimate: no error that is
/// [`LARGE`] is estimated as smaller (`benches/python/accuracy/statics.py`).
const SUFFICIENT_ESTIMATE: f64 = 3e-3;

/// Displacements below this part of the length are rounding.
const ROUNDING_OF_DISPLACEMENTS: f64 = 1e-12;

/// Below this lowest eigenvalue of the stiffness, the amplification of an error by forces is unknown.
const SOFTEST: f64 = 0.05;

/// Up to this rotation between neighbouring nodes, in radians, quadrature errors are negligible in a significant error: helices of ten
/// turns at the limit of resolution, half a turn, have an error of 2e-4 of their length.
const RESOLVED_ROTATION: f64 = 2.0;

/// Additional modes of the strains that have some: enough for the error of cones and boundary layers. For large models fewer.
const MORE_MODES: [usize; 2] = [12, 4];

/// Largest model with more modes: one second of work.
const MOST_COORDINATES: usize = 600;

/// Reciprocal condition number below which a system counts as singular, as that of redundant loops.
const SINGULAR_SYSTEM: f64 = 1e-14;

/// Stiffness, relative to that of each coordinate, below which a neutral direction counts as one: a step along it is not the error of a shape.
const NEUTRAL_STIFFNESS: f64 = 1e-6;

/// Maximum number of steps of a model with more modes, each with its own tangent, and the part of the residual that the last one may
/// leave: the forces are then almost linear within the step.
const MOST_STEPS: usize = 6;
const LINEAR: f64 = 0.3;

/// Maximum number of corrections of a step with the same tangent, and the part of the residual that they may leave, so that the rest
/// is not attributed to missing modes.
const MAX_CORRECTIONS: usize = 8;
const BALANCED_FORCES: f64 = 1e-4;

/// If more modes leave more than this part of the error, the segments are too few rather than the modes.
const HARDLY_HELPS: f64 = 0.3;

/// Largest error of a place, relative to the length.
const LARGEST_ERROR: f64 = 2.0;

/// Permitted cost of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A model with more modes only if the balance of forces is not conclusive; usually a hundredth of the cost of a search.
    Little,
    /// Always one step of such a model.
    Full,
}

/// Method by which an error was estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimate {
    /// By the balance of forces alone.
    Balance,
    /// By a step of a model with more modes.
    MoreModes,
}

/// Estimated error of an equilibrium due to the finite number of modes of its rods. Strains without modes count as rigid.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceError {
    /// Error of the tips of rods and of bodies, in metres, the largest one. By the balance alone it is that of the shape.
    pub tip: f64,
    /// Largest error of the position of anything, in metres.
    pub shape: f64,
    /// The same relative to the length of the model.
    pub relative: f64,
    /// Largest error of the curvature, torsion included, in radians per metre.
    pub curvature: f64,
    /// Largest error of the moment of the material, in newton metres.
    pub moment: f64,
    /// The segment, counted through all rods, that contributes most to the error of the shape, and its name.
    pub segment: usize,
    /// See `segment`.
    pub name: String,
    /// The strain of this segment with the largest error.
    pub strain: &'static str,
    /// How this was found.
    pub estimate: Estimate,
    /// Whether more modes of this segment help; otherwise it should be divided.
    pub is_helped_by_modes: bool,
    /// Deflection that rigid shear leaves out of this segment's rod, over that by bending ([`MissingStrain::rigid_shear`]).
    pub rigid_shear: f64,
    /// What stretch without modes leaves out, and the name of its segment.
    pub rigid_stretch: RigidStretch,
    /// See `rigid_stretch`.
    pub rigid_segment: String,
}

impl SpaceError {
    /// A sentence if axial forces would change the length of a segment whose stretch has no modes by more than [`LARGE`].
    pub fn about_stretch(&self) -> Option<String> {
        let RigidStretch { strain, force, stiffness, .. } = self.rigid_stretch;
        let (change, pulls) = match strain < 0.0 {
            true => ("shorten", "presses"),
            false => ("stretch", "pulls"),
        };
        (strain.abs() > LARGE).then(|| {
            let by = match strain.abs() {
                part if part < 1.0 => format!("{:.0} %", 100.0 * part),
                _ => "more than its length".to_owned(),
            };
            format!(
                "Stretch has no modes in {} and counts as rigid: with E A = {} N, what {pulls} along it (up to {} N) would {change} it by \
                 {by}. Give it `modes` of stretch.",
                self.rigid_segment,
                Number(rounded(stiffness)),
                Number(rounded(force.abs()))
            )
        })
    }

    /// What messages say of the error: sentences with a space before each, or nothing.
    pub fn sentences(&self) -> String {
        [self.doubt(), self.about_stretch()]
            .into_iter()
            .flatten()
            .map(|sentence| format!(" {sentence}"))
            .collect()
    }

    /// A warning if the error is large.
    pub fn doubt(&self) -> Option<String> {
        let is_small = self.relative <= LARGE;
        (!is_small).then(|| {
            let Self { relative, tip, name, strain, .. } = self;
            let cure = match self.is_helped_by_modes {
                true => format!("give it more `modes` of {strain}, or divide it into more segments"),
                false => format!("divide it into more segments, above all where loads, tendons or the section change; more `modes` of {strain} help less"),
            };
            let percent = 100.0 * relative;
            let digits = usize::from(percent < 10.0);
            let shear = match self.rigid_shear {
                added if added > LARGE => format!(
                    " Shear has no modes there and is not counted: in so thick a rod it would add {:.0} % to the deflection under a force \
                     at the tip.",
                    100.0 * added
                ),
                _ => String::new(),
            };
            format!(
                "The finite number of modes leaves an error of about {percent:.digits$} % of the length ({tip:.1e} m at the tip). Most \
                 of it is due to {strain} of {name}: {cure}.{shear}"
            )
        })
    }
}

/// A shape at rest whose error is estimated.
#[derive(Clone, Copy, Debug)]
pub struct Rest<'a> {
    /// Coordinates, shape (n,).
    pub q: &'a [f64],
    /// Lowest eigenvalue of the stiffness relative to that of material and springs; NaN if it is unknown.
    pub lowest: f64,
    /// Stability; `None` if it is unknown.
    pub stability: Option<Stability>,
    /// Fraction of the loads that acts.
    pub load_factor: f64,
}

impl<'a> Rest<'a> {
    /// A shape under the full load of which no more is known.
    pub fn of(q: &'a [f64], stability: Option<Stability>) -> Self {
        Self { q, lowest: f64::NAN, stability, load_factor: 1.0 }
    }

    /// Largest displacement by missing strains, if the change of forces with the shape enlarges it.
    pub(super) fn enlarged(&self, missing: MissingStrain) -> f64 {
        let softness = self.lowest.abs().clamp(SOFTEST, 1.0);
        missing.displacement / if softness.is_nan() { 1.0 } else { softness }
    }
}

/// Estimates the error of an equilibrium `found` of this model at the time `t` and with the inputs `u`, if not those by default.
/// `None` if it is none, if nothing in the model is discretised, or if rounding decides the forces. With [`Effort::Little`] it costs a few evaluations of forces,
/// otherwise a model with more modes and one tangent and factorisation of it. Allocates.
pub fn space_error<M: Model + Clone>(
    model: &mut M,
    found: &Equilibrium,
    at: (f64, Option<&[f64]>),
    effort: Effort,
) -> Result<Option<SpaceError>, Interrupted> {
    if !found.status.is_success() {
        return Ok(None);
    }
    let stability = found.verdict.map(|verdict| verdict.stability);
    error_at_rest(model, Rest { lowest: found.lowest, ..Rest::of(&found.q, stability) }, at, effort)
}

/// The same of a shape that is known to be an equilibrium. Under a part of the loads only where no constraints or supports act, whose
/// forces are not proportional to the loads.
pub fn error_at_rest<M: Model + Clone>(
    model: &mut M,
    rest: Rest<'_>,
    (t, u): (f64, Option<&[f64]>),
    effort: Effort,
) -> Result<Option<SpaceError>, Interrupted> {
    if rest.load_factor != 1.0 && !scales_with_loads(model) {
        return Ok(None);
    }
    let Some(missing) = model.missing_strain(rest.q, rest.load_factor) else { return Ok(None) };
    let length = model.facts().length;
    let doubtful = rest.enlarged(missing);
    if doubtful > SUFFICIENT_ESTIMATE * length && is_rounding(model, rest, missing) {
        return Ok(None);
    }
    let is_neutral = rest.stability == Some(Stability::Neutral);
    let clear = if effort == Effort::Little { SUFFICIENT_ESTIMATE } else { ROUNDING_OF_DISPLACEMENTS };
    let is_clear = doubtful <= clear * length && missing.turn <= RESOLVED_ROTATION;
    let shift = if is_neutral { NEUTRAL_STIFFNESS } else { 0.0 };
    let estimated =
        if is_clear { Estimated::NotTried } else { by_more_modes(model, rest, (t, u), missing, shift)? };
    let errors = match estimated {
        // Steps along directions without resistance are as long as rounding makes them.
        Estimated::By(errors) if !is_neutral || errors.shape <= doubtful => errors,
        // Displacements under constant forces are no estimate if forces change this much.
        Estimated::Unknown => return Ok(None),
        _ if doubtful > LARGEST_ERROR * length => return Ok(None),
        _ => Errors {
            tip: doubtful,
            shape: doubtful,
            strains: missing,
            estimate: Estimate::Balance,
            is_helped_by_modes: true,
        },
    };
    let Errors { tip, shape, strains, estimate, is_helped_by_modes } = errors;
    Ok(Some(SpaceError {
        tip,
        shape,
        relative: shape.max(tip) / length,
        curvature: strains.curvature,
        moment: strains.moment,
        segment: missing.segment,
        name: model.name_of_segment(missing.segment),
        strain: STRAIN_NAMES[missing.strain],
        estimate,
        is_helped_by_modes,
        rigid_shear: missing.rigid_shear,
        rigid_stretch: missing.rigid_stretch,
        rigid_segment: model.name_of_segment(missing.rigid_stretch.segment),
    }))
}

/// Whether all forces on rods are proportional to the loads: not those of constraints and supports.
pub(super) fn scales_with_loads<M: Model>(model: &M) -> bool {
    model.facts().constraints() == 0 && model.facts().springs == 0
}

/// A number with three digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// Whether rounding of the shape changes the missing strains: supports or contacts may be so stiff that no shape in floating-point
/// numbers has the right forces, and the balance is then no estimate.
fn is_rounding<M: Model>(model: &mut M, rest: Rest<'_>, missing: MissingStrain) -> bool {
    /// Rounding errors of a few operations.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    /// Largest relative change of the missing strains.
    const LARGEST_STRAIN_CHANGE: f64 = 0.3;
    let sizes = &model.facts().typical_coordinates;
    let nearby = |(k, (q, size)): (usize, (&f64, &f64))| {
        if k % 2 == 0 { q + ROUNDING * size } else { q - ROUNDING * size }
    };
    let nearby: Vec<f64> = rest.q.iter().zip(sizes).enumerate().map(nearby).collect();
    let there = model.missing_strain(&nearby, rest.load_factor).map_or(0.0, |there| there.displacement);
    (there - missing.displacement).abs() > LARGEST_STRAIN_CHANGE * missing.displacement
}

/// Estimate of a model with more modes.
enum Estimated {
    /// There is no such model.
    NotTried,
    /// Steps in it lead to no equilibrium nearby.
    Unknown,
    By(Errors),
}

/// Errors of positions, and of strains.
struct Errors {
    tip: f64,
    shape: f64,
    strains: MissingStrain,
    estimate: Estimate,
    is_helped_by_modes: bool,
}

/// Errors by steps of a model with more modes.
fn by_more_modes<M: Model + Clone>(
    model: &mut M,
    rest: Rest<'_>,
    (t, u): (f64, Option<&[f64]>),
    missing: MissingStrain,
    shift: f64,
) -> Result<Estimated, Interrupted> {
    let finer = |more| with_more_modes(model, rest.q, more, MOST_COORDINATES);
    let Some((mut richer, q)) = MORE_MODES.into_iter().find_map(finer) else {
        return Ok(Estimated::NotTried);
    };
    if let Some(u) = u {
        richer.set_inputs(u);
    }
    richer.set_time(t)?;
    let Some(multipliers) = multipliers_of(model, rest.q) else { return Ok(Estimated::NotTried) };
    let balance = Balance { multipliers: &multipliers, load_factor: rest.load_factor, shift };
    let Some((mut system, there)) = followed(&mut richer, &q, balance) else {
        return Ok(Estimated::Unknown);
    };
    let [tip, shape] = displacements(model, rest.q, &mut richer, [&q, &there]);
    let step: Vec<f64> = there.iter().zip(&q).map(|(there, q)| there - q).collect();
    let strains = richer.effect_of_strains(&q, &step).unwrap_or_default();
    let part = left_out(&mut richer, &mut system, there, missing);
    let [tip, shape, curvature, moment] =
        [tip, shape, strains.curvature, strains.moment].map(|found| found * (1.0 + part));
    let is_finite = [tip, shape, curvature, moment].iter().all(|x| x.is_finite());
    // Additional modes that represent none of the missing strains give no estimate.
    if !is_finite || part >= 1.0 || tip.max(shape) > LARGEST_ERROR * model.facts().length {
        return Ok(Estimated::Unknown);
    }
    Ok(Estimated::By(Errors {
        tip,
        shape,
        strains: MissingStrain { curvature, moment, ..strains },
        estimate: Estimate::MoreModes,
        is_helped_by_modes: part <= HARDLY_HELPS,
    }))
}

/// Forces of constraints in a shape; `None` if they are singular.
fn multipliers_of<M: Model>(model: &mut M, q: &[f64]) -> Option<Vec<f64>> {
    let rest = vec![0.0; q.len()];
    let mut multipliers = vec![0.0; model.facts().constraints()];
    if !multipliers.is_empty() {
        one_sided::multipliers(model, [q, &rest, &rest], &mut multipliers).ok()?;
    }
    Some(multipliers)
}

/// Whether a shape is an equilibrium under the full load: a step of Newton's method hardly moves it. Costs a tangent and its factorisation.
pub fn is_at_rest<M: Model + Clone>(model: &mut M, q: &[f64]) -> bool {
    /// Displacement by that step, relative to the length: a tenth of what is a [`LARGE`] error.
    const AT_REST: f64 = 0.1 * LARGE;
    let length = model.facts().length;
    let mut moved = || {
        let multipliers = multipliers_of(model, q)?;
        let balance = Balance { multipliers: &multipliers, load_factor: 1.0, shift: 0.0 };
        let there = Linearised::new(model, q, balance)?.step(model, q)?;
        let mut same = model.clone();
        Some(displacements(model, q, &mut same, [q, &there]))
    };
    moved().is_some_and(|moved| moved.iter().all(|moved| *moved <= AT_REST * length))
}

/// The shape to which Newton's method leads from one nearby, and the equations linearised at the start of the last step. One step
/// suffices if its residual is small. `None` without convergence.
fn followed<M: Model>(model: &mut M, q: &[f64], balance: Balance<'_>) -> Option<(Linearised, Vec<f64>)> {
    let mut system = Linearised::new(model, q, balance)?;
    let mut there = system.step(model, q)?;
    for _ in 0..MOST_STEPS {
        let before = system.out_of_balance;
        let next = system.clone().after(model, &there)?;
        if next <= LINEAR * before || next <= BALANCED_FORCES * system.at_first {
            return Some((system, there));
        }
        let at_first = system.at_first;
        let balance = Balance { multipliers: &system.multipliers, ..balance };
        system = Linearised { at_first, ..Linearised::new(model, &there, balance)? };
        there = system.step(model, &there)?;
    }
    None
}

/// The part of the missing strains that more modes leave out as well, from the balance of forces at the end of a step.
fn left_out<M: Model>(
    model: &mut M,
    system: &mut Linearised,
    mut q: Vec<f64>,
    missing: MissingStrain,
) -> f64 {
    let mut has_converged = system.out_of_balance <= BALANCED_FORCES * system.at_first;
    for _ in 0..MAX_CORRECTIONS {
        let before = system.out_of_balance;
        let Some(next) = system.step(model, &q) else { break };
        has_converged = system.out_of_balance <= BALANCED_FORCES * system.at_first;
        if has_converged || system.out_of_balance > before && before < system.at_first {
            break;
        }
        q = next;
    }
    let left = model.missing_strain(&q, system.load_factor).map_or(0.0, |missing| missing.displacement);
    let part = if missing.displacement > 0.0 { left / missing.displacement } else { 0.0 };
    // Far from an equilibrium the balance is no estimate.
    if has_converged { part } else { 0.0 }
}

/// The forces in balance: those of constraints, a fraction of the loads, and an additional stiffness relative to that of each coordinate.
#[derive(Clone, Copy)]
struct Balance<'a> {
    multipliers: &'a [f64],
    load_factor: f64,
    shift: f64,
}

/// The equations of shape and multipliers together, linearised at a shape and in dimensionless form.
#[derive(Clone)]
struct Linearised {
    /// Changes of coordinates with an elastic energy of one joule, so that bending and stretching have equal weight.
    sizes: Vec<f64>,
    /// Change of the gap of each constraint by coordinates of these sizes; zero for inactive constraints.
    moved: Vec<f64>,
    system: Matrix,
    /// Factors, unless the system is singular, as with redundant loops.
    lu: Option<Lu>,
    multipliers: Vec<f64>,
    load_factor: f64,
    /// Norm of the right-hand side of the first step and of the last one.
    at_first: f64,
    out_of_balance: f64,
}

impl Linearised {
    /// `None` if a number is not finite.
    fn new<M: Model>(model: &mut M, q: &[f64], balance: Balance<'_>) -> Option<Self> {
        let Balance { multipliers, load_factor, shift } = balance;
        let (n, m) = (q.len(), multipliers.len());
        let rest = vec![0.0; n];
        let (mut tangent, mut jacobian) = (Matrix::zeros(n, n), Matrix::zeros(m, n));
        if model.facts().is_one_sided {
            model.release(multipliers);
        }
        model.set_multipliers(multipliers);
        model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
        model.set_multipliers(&vec![0.0; m]);
        if load_factor != 1.0 {
            let mut elastic = Matrix::zeros(n, n);
            model.elastic_tangent(q, &mut elastic);
            for (entry, part) in tangent.iter_mut().zip(&elastic) {
                *entry = part + load_factor * (*entry - part);
            }
        }
        if m > 0 {
            model.gap_jacobian(q, &mut jacobian);
        }
        let typical = &model.facts().typical_coordinates;
        let energies: Vec<f64> = (0..n).map(|k| tangent[(k, k)] * typical[k] * typical[k]).collect();
        let energy = energies.iter().copied().fold(0.0, f64::max);
        let least = f64::EPSILON * energy;
        let size = |k: usize| typical[k] / (if energies[k] > least { energies[k] } else { energy }).sqrt();
        let sizes: Vec<f64> = (0..n).map(size).collect();
        let mut system = Matrix::zeros(n + m, n + m);
        for k in 0..n {
            for j in 0..n {
                system[(j, k)] = tangent[(j, k)] * sizes[j] * sizes[k];
            }
        }
        let moved = |i: usize| (0..n).map(|k| (jacobian[(i, k)] * sizes[k]).powi(2)).sum::<f64>().sqrt();
        let moved: Vec<f64> = (0..m).map(moved).collect();
        for i in 0..m {
            if moved[i] == 0.0 {
                system[(n + i, n + i)] = 1.0;
                continue;
            }
            for k in 0..n {
                let entry = jacobian[(i, k)] * sizes[k] / moved[i];
                (system[(n + i, k)], system[(k, n + i)]) = (entry, entry);
            }
        }
        (0..n).for_each(|k| system[(k, k)] += shift);
        if !system.iter().all(|x| x.is_finite()) {
            return None;
        }
        let mut lu = Lu::new(n + m);
        let is_regular = lu.factorise(&system).is_ok() && lu.reciprocal_condition() > SINGULAR_SYSTEM;
        let (lu, multipliers) = (is_regular.then_some(lu), multipliers.to_vec());
        Some(Self { sizes, moved, system, lu, multipliers, load_factor, at_first: 0.0, out_of_balance: 0.0 })
    }

    /// Norm of the residual in a shape.
    fn after<M: Model>(mut self, model: &mut M, q: &[f64]) -> Option<f64> {
        self.step(model, q)?;
        Some(self.out_of_balance)
    }

    /// The shape to which a step of Newton's method leads from another one nearby, with changing multipliers; with redundant loops the
    /// smallest step. `None` if it is not finite.
    fn step<M: Model>(&mut self, model: &mut M, q: &[f64]) -> Option<Vec<f64>> {
        let (n, m) = (q.len(), self.multipliers.len());
        let rest = vec![0.0; n];
        let (mut forces, mut gaps) = (vec![0.0; n], vec![0.0; m]);
        model.set_multipliers(&self.multipliers);
        model.inverse_dynamics(q, &rest, &rest, &mut forces);
        model.set_multipliers(&vec![0.0; m]);
        if self.load_factor != 1.0 {
            let mut elastic = vec![0.0; n];
            model.elastic_forces(q, &mut elastic);
            for (force, part) in forces.iter_mut().zip(elastic) {
                *force = part + self.load_factor * (*force - part);
            }
        }
        if m > 0 {
            model.gaps(q, &mut gaps);
        }
        let of_forces = forces.iter().zip(&self.sizes).map(|(force, size)| -force * size);
        let of_gaps =
            gaps.iter().zip(&self.moved).map(|(gap, moved)| if *moved == 0.0 { 0.0 } else { -gap / moved });
        let mut right: Vec<f64> = of_forces.chain(of_gaps).collect();
        self.out_of_balance = norm(&right);
        if self.at_first == 0.0 {
            self.at_first = self.out_of_balance;
        }
        match &mut self.lu {
            Some(lu) => lu.solve(&mut right),
            None => right = minimum_norm_solution(&self.system, &right)?.x,
        }
        for ((multiplier, x), moved) in self.multipliers.iter_mut().zip(&right[n..]).zip(&self.moved) {
            if *moved != 0.0 {
                *multiplier += x / moved;
            }
        }
        let there: Vec<f64> =
            q.iter().zip(&right).zip(&self.sizes).map(|((q, x), size)| q + x * size).collect();
        there.iter().all(|x| x.is_finite()).then_some(there)
    }
}

/// Largest distances of tips and bodies, and of any section or body, between both models. For sections only the step counts, because
/// the models have different nodes.
fn displacements<M: Model>(coarse: &mut M, q: &[f64], richer: &mut M, [from, to]: [&[f64]; 2]) -> [f64; 2] {
    let largest = |from: &[[f64; 3]], to: &[[f64; 3]]| {
        let distance =
            |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        // Keeps NaN.
        let distances = from.iter().zip(to).map(distance);
        distances.fold(0.0, |largest: f64, x| if x <= largest { largest } else { x })
    };
    let (mut before, mut after) = (Vec::new(), Vec::new());
    let (mut outline, mut stepped) = (Vec::new(), Vec::new());
    coarse.places(q, &mut before);
    richer.places(to, &mut after);
    richer.outline(from, &mut outline);
    richer.outline(to, &mut stepped);
    let (tip, along) = (largest(&before, &after), largest(&outline, &stepped));
    [tip, if along <= tip { tip } else { along }]
}
