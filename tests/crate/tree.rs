//! Matrices of trees and their solves against dense ones, for random generators and random rods.

use lissom::linalg::{Lu, Matrix, Singular, TreeLu, TreeMatrix};
use lissom::model::{
    Autonomous, Dynamics, Elastic, Energy, Facts, ForwardScratch, InvalidShape, Smooth, Tree,
};
use lissom::newmark;
use lissom::robot::{RobotModel, Rod, Solve};
use lissom::rod::{Section, Segment};
use lissom::roots::Derivative;
use lissom::second_order;
use lissom::second_order::{Failure, Status};
use proptest::prelude::*;

fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
}

/// Pseudorandom numbers in [-1, 1].
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        // Knuth's MMIX generator.
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A matrix of random generators; `dominance` is added to the diagonal.
fn random_chain(sizes: &[usize], ranks: [usize; 2], dominance: f64, seed: u64) -> TreeMatrix {
    let mut next = numbers(seed);
    random(TreeMatrix::chain(sizes, ranks), dominance, &mut next)
}

/// A matrix of random entries with the structure of `tree`.
fn random(mut tree: TreeMatrix, dominance: f64, next: &mut impl FnMut() -> f64) -> TreeMatrix {
    let TreeMatrix { blocks, carried, carrying, .. } = &mut tree;
    for part in [&mut carried.rows, &mut carried.columns, &mut carrying.rows, &mut carrying.columns] {
        part.iter_mut().for_each(|entry| *entry = next());
    }
    for block in blocks {
        block.iter_mut().for_each(|entry| *entry = next());
        (0..block.nrows()).for_each(|i| block[(i, i)] += dominance);
    }
    tree
}

/// A tree of blocks of these sizes with random branches, some with several places on a block.
fn random_tree(sizes: &[usize], ranks: [usize; 2], dominance: f64, seed: u64) -> (TreeMatrix, Hanging) {
    let mut next = numbers(seed);
    let mut choose = |n: usize| ((0.5 * (next() + 1.0) * n as f64) as usize).min(n.max(1) - 1);
    let mut places = Vec::new();
    for block in 0..sizes.len() {
        places.extend(std::iter::repeat_n(block, choose(4)));
    }
    let mut hangs_at = Vec::new();
    for block in 0..sizes.len() {
        let before = places.partition_point(|&place| place < block);
        hangs_at.push((before > 0 && choose(6) > 0).then(|| choose(before)));
    }
    let tree = TreeMatrix::zeros(sizes, &hangs_at, &places, ranks);
    (random(tree, dominance, &mut numbers(seed ^ 2)), Hanging { hangs_at, places })
}

/// The place to which each block is attached, and the block of each place.
struct Hanging {
    hangs_at: Vec<Option<usize>>,
    places: Vec<usize>,
}

impl Hanging {
    fn of_chain(blocks: usize) -> Self {
        let hangs_at = (0..blocks).map(|block| block.checked_sub(1)).collect();
        Self { hangs_at, places: (1..blocks).map(|block| block - 1).collect() }
    }

    /// The place on block `a` to which block `b` is attached, directly or through other blocks.
    fn place(&self, a: usize, mut b: usize) -> Option<usize> {
        loop {
            let place = self.hangs_at[b]?;
            b = self.places[place];
            if b == a {
                return Some(place);
            }
        }
    }
}

/// An entry according to the definition.
fn entry_by_definition(tree: &TreeMatrix, hanging: &Hanging, j: usize, k: usize) -> f64 {
    let mut block_of = Vec::new();
    let mut first_of = Vec::new();
    for (s, block) in tree.blocks.iter().enumerate() {
        let first = block_of.len();
        block_of.extend(std::iter::repeat_n(s, block.nrows()));
        first_of.extend(std::iter::repeat_n(first, block.nrows()));
    }
    let seen_at = |place: usize, k: usize| tree.places()[place].first + k - first_of[k];
    let (row, column) = (block_of[j], block_of[k]);
    if row == column {
        return tree.blocks[row][(j - first_of[j], k - first_of[k])];
    }
    if let Some(place) = hanging.place(row, column) {
        return tree.carrying.rows.column(seen_at(place, j)).dot(&tree.carried.columns.column(k));
    }
    if let Some(place) = hanging.place(column, row) {
        return tree.carried.rows.column(j).dot(&tree.carrying.columns.column(seen_at(place, k)));
    }
    0.0
}

/// The ranks of spatial and planar robots, and any others.
fn ranks() -> impl Strategy<Value = [usize; 2]> {
    let of_robots = [[6, 6], [6, 9], [6, 12], [6, 18], [3, 3], [3, 4], [3, 5], [3, 9]];
    prop_oneof![prop::sample::select(of_robots.to_vec()), prop::array::uniform2(0usize..13)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_tree_matrix_multiplies_and_solves_like_the_dense_one(
        sizes in prop::collection::vec(prop_oneof![0usize..20, 0usize..3], 0..12), ranks in ranks(), seed: u64,
        is_chain: bool,
    ) {
        let n: usize = sizes.iter().sum();
        let (chain, hanging) = if is_chain {
            (random_chain(&sizes, ranks, 4.0 * n as f64, seed), Hanging::of_chain(sizes.len()))
        } else {
            random_tree(&sizes, ranks, 4.0 * n as f64, seed)
        };
        let dense = chain.to_dense();
        prop_assert_eq!((chain.n(), dense.shape()), (n, (n, n)));
        for j in 0..n {
            for k in 0..n {
                prop_assert!((dense[(j, k)] - entry_by_definition(&chain, &hanging, j, k)).abs() < 1e-14, "({j}, {k})");
            }
        }
        let mut next = numbers(seed ^ 1);
        let x: Vec<f64> = (0..n).map(|_| next()).collect();
        let mut b = vec![f64::NAN; n];
        chain.multiply(&x, &mut b);
        let product = &dense * nalgebra::DVector::from_column_slice(&x);
        prop_assert!(difference(&b, product.as_slice()) <= 1e-12 * (1.0 + largest(&b)));
        let mut lu = TreeLu::new(&chain);
        lu.factorise(&chain).unwrap();
        let mut found = b.clone();
        lu.solve(&mut found);
        prop_assert!(difference(&found, &x) < 1e-13, "{:e}", difference(&found, &x));
    }

    /// Without dominance, Schur complements may be large or small.
    #[test]
    fn an_indefinite_matrix_is_solved_or_refused(
        sizes in prop::collection::vec(1usize..7, 2..9), ranks in ranks(), seed: u64,
    ) {
        let (chain, _) = random_tree(&sizes, ranks, 0.0, seed);
        let n = chain.n();
        let mut next = numbers(seed ^ 1);
        let x: Vec<f64> = (0..n).map(|_| next()).collect();
        let mut b = vec![0.0; n];
        chain.multiply(&x, &mut b);
        let mut lu = TreeLu::new(&chain);
        prop_assume!(lu.factorise(&chain).is_ok());
        lu.solve(&mut b);
        let dense = chain.to_dense();
        let mut dense_lu = Lu::new(n);
        prop_assume!(dense_lu.factorise(&dense).is_ok());
        let condition = 1.0 / dense_lu.reciprocal_condition();
        prop_assert!(difference(&b, &x) < 1e-10 * condition, "{:e} {:e}", difference(&b, &x), condition);
    }
}

/// Random rods with any modes, including segments without modes, of both kernels, with and without loads,
/// mass and damping.
fn rods() -> impl Strategy<Value = Rod> {
    let modes = prop_oneof![
        1 => Just([0; 6]),
        3 => prop::array::uniform6(0usize..3),
        3 => prop::array::uniform3(0usize..3).prop_map(|[bend, stretch, shear]| [0, bend, 0, stretch, 0, shear]),
    ];
    let segment = (0.1..0.4, 0.008..0.02, 0.008..0.02, prop_oneof![Just(0.0), 0.001..0.1], modes);
    let vector = || prop::array::uniform3(-1.0..1.0);
    let load = || prop_oneof![Just([0.0; 3]), vector()];
    let planar = any::<bool>();
    (prop::collection::vec(segment, 1..9), [load(), load()], prop_oneof![Just(0.0), 0.01..0.2], planar)
        .prop_map(|(segments, [tip_force, tip_moment], tip_mass, planar)| {
            let segments = segments.into_iter().map(|(length, base, tip, retardation_time, modes)| Segment {
                section: Section::circle([base, tip]),
                modes: if planar { [0, modes[1], 0, modes[3], 0, modes[5]] } else { modes },
                retardation_time,
                ..Segment::straight(length, base, 3e5, 1.1e5, 1000.0)
            });
            Rod {
                base_orientation: [0.8, 0.2, -0.4, 0.4],
                tip_force,
                tip_moment,
                tip_mass,
                ..Rod::new(segments.collect())
            }
        })
}

/// A state of size `scale` with different values of all coordinates.
fn state(n: usize, scale: f64, phase: f64) -> Vec<f64> {
    (0..n).map(|i| scale * (1.7 * i as f64 + phase).sin()).collect()
}

/// The random rods with loads and bodies anywhere.
fn loaded_rods() -> impl Strategy<Value = Rod> {
    use lissom::body::Body;
    use lissom::load::{Extent, Frame, Load};
    let vector = || prop::array::uniform3(-1.0..1.0);
    let load = (0usize..3, any::<bool>(), 0.0..0.6, 0.1..0.4, vector(), vector());
    let body = (prop::option::of(0.0..1.0), 0.01..0.2, prop::array::uniform3(-0.02..0.02));
    (rods(), prop::collection::vec(load, 0..4), prop::collection::vec(body, 0..3)).prop_map(
        |(rod, loads, bodies)| {
            let length = rod.length();
            let loads = loads.into_iter().map(|(kind, is_dead, x, width, force, moment)| Load {
                link: 0,
                extent: match kind {
                    0 => Extent::Tip,
                    1 => Extent::At(x * length),
                    _ => Extent::Along([x * length, (x + width) * length]),
                },
                frame: if is_dead { Frame::World } else { Frame::Body },
                force: force.into(),
                moment: moment.into(),
            });
            let bodies = bodies.into_iter().map(|(at, mass, centre): (Option<f64>, f64, [f64; 3])| Body {
                link: 0,
                at: at.map(|x| x * length),
                mass,
                centre,
                inertia: [[2e-5, 0.0, 0.0], [0.0, 3e-5, 0.0], [0.0, 0.0, 3e-5]],
                hull: None,
            });
            Rod { loads: loads.collect(), bodies: bodies.collect(), ..rod }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn tangents_of_random_rods_are_chains(rod in loaded_rods(), phase in 0.0..6.0) {
        let mut model = RobotModel::with_solve(&(&rod).into(), Solve::Tree).unwrap();
        let n = model.facts().n;
        let (q, qd, qdd) = (state(n, 1.0, phase), state(n, 2.0, 1.0 + phase), state(n, 10.0, 2.0));
        let Tree { mut tangent, mut mass } = model.tree().unwrap();
        let mut dense = Matrix::zeros(n, n);
        for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1e-4, 1e-2, 1.0]] {
            model.weighted_tangent(&q, &qd, &qdd, weights, &mut dense);
            model.tree_tangent(&q, &qd, &qdd, weights, &mut tangent);
            let (found, scale) = (tangent.to_dense(), largest(dense.as_slice()));
            prop_assert!(difference(found.as_slice(), dense.as_slice()) <= 1e-14 * scale);
        }
        model.tree_mass_matrix(&q, &mut mass);
        model.mass_matrix(&q, &mut dense);
        let (found, scale) = (mass.to_dense(), largest(dense.as_slice()));
        prop_assert!(difference(found.as_slice(), dense.as_slice()) <= 1e-14 * scale);
    }

    /// The errors of both solves grow with the condition number; the error of the block solve has the same
    /// order of magnitude.
    #[test]
    fn random_rods_are_solved_as_chains_as_well_as_densely(rod in loaded_rods(), phase in 0.0..6.0) {
        let mut model = RobotModel::with_solve(&(&rod).into(), Solve::Tree).unwrap();
        let n = model.facts().n;
        let (q, qd, qdd) = (state(n, 1.0, phase), state(n, 2.0, 1.0 + phase), state(n, 10.0, 2.0));
        let Tree { mut tangent, .. } = model.tree().unwrap();
        let mut chain_lu = TreeLu::new(&tangent);
        let mut lu = Lu::new(n);
        for h in [1e-3, 1e-2] {
            model.tree_tangent(&q, &qd, &qdd, [0.25 * h * h, 0.5 * h, 1.0], &mut tangent);
            chain_lu.factorise(&tangent).unwrap();
            lu.factorise(&tangent.to_dense()).unwrap();
            let x = state(n, 1.0, 0.5);
            let mut b = vec![0.0; n];
            tangent.multiply(&x, &mut b);
            chain_lu.solve(&mut b);
            let bound = 1e-15 * (10.0 + 1.0 / lu.reciprocal_condition());
            prop_assert!(difference(&b, &x) <= bound, "{:e} > {:e}", difference(&b, &x), bound);
        }
    }

    #[test]
    fn forward_dynamics_of_chains_balance_the_equations_of_motion(rod in loaded_rods(), phase in 0.0..6.0) {
        let mut model = RobotModel::with_solve(&(&rod).into(), Solve::Tree).unwrap();
        let n = model.facts().n;
        let (q, qd, zero) = (state(n, 0.7, phase), state(n, 2.0, 1.0), vec![0.0; n]);
        let (mut qdd, mut tau) = (vec![0.0; n], vec![0.0; n]);
        model.inverse_dynamics(&q, &qd, &zero, &mut tau);
        let scale = largest(&tau);
        let mut scratch = ForwardScratch::of(&model);
        model.forward_dynamics(&q, &qd, &mut qdd, &mut scratch).unwrap();
        model.inverse_dynamics(&q, &qd, &qdd, &mut tau);
        prop_assert!(largest(&tau) <= 1e-10 * scale, "{:e} of {:e}", largest(&tau), scale);
    }
}

fn soft(modes: [usize; 6]) -> Segment {
    Segment { modes, retardation_time: 0.01, ..Segment::straight(0.1, 0.01, 1e6, 4e5, 1000.0) }
}

fn motion(rod: &Rod, solve: Solve, options: &newmark::Options) -> second_order::Solution {
    let mut model = RobotModel::with_solve(&rod.into(), solve).unwrap();
    assert_eq!(model.solve(), solve);
    let zero = vec![0.0; model.facts().n];
    newmark::solve(&mut model, (0.0, 0.3), &zero, &zero, options, None, &mut |_, _| Ok(())).unwrap()
}

/// The steps differ by the tolerance of Newton's method, here by rounding errors.
#[test]
fn motions_agree_with_those_of_the_dense_solve() {
    let options =
        newmark::Options { rtol: 1e-10.into(), atol: Some(1e-10.into()), ..newmark::Options::new(5e-3) };
    for (segments, modes) in [(1, [1, 2, 2, 0, 0, 0]), (5, [1, 1, 1, 1, 0, 0]), (12, [0, 2, 0, 0, 0, 0])] {
        let rod = Rod {
            tip_mass: 0.02,
            tip_force: [0.0, if modes[2] > 0 { 0.1 } else { 0.0 }, 0.1],
            ..Rod::new(vec![soft(modes); segments])
        };
        let [dense, chain] = [Solve::Dense, Solve::Tree].map(|solve| motion(&rod, solve, &options));
        for motion in [&dense, &chain] {
            assert_eq!(motion.status, Status::Finished, "{}", motion.message);
        }
        let far = difference(&dense.q, &chain.q);
        assert!(far < 1e-8 * largest(&dense.q), "{segments} segments: {far:e}");
        assert_eq!(dense.counters.newton_iterations, chain.counters.newton_iterations);
    }
}

/// A hundred segments: in both solves alike, rounding errors grow with the condition number of the mass
/// matrix.
#[test]
fn a_hundred_segments_move_as_the_dense_solve_says() {
    let link = Segment { length: 0.02, ..soft([0, 1, 1, 0, 0, 0]) };
    let rod = Rod { tip_force: [0.0, 0.05, 0.0], ..Rod::new(vec![link; 100]) };
    let mut model = RobotModel::of_rod(&rod).unwrap();
    let n = model.facts().n;
    let (q, qd, zero) = (state(n, 0.3, 0.1), state(n, 0.5, 1.0), vec![0.0; n]);
    let left = [ForwardScratch::new(n), ForwardScratch::of(&model)].map(|mut scratch| {
        let (mut qdd, mut tau) = (vec![0.0; n], vec![0.0; n]);
        model.forward_dynamics(&q, &qd, &mut qdd, &mut scratch).unwrap();
        model.inverse_dynamics(&q, &qd, &qdd, &mut tau);
        let found = largest(&tau);
        model.inverse_dynamics(&q, &qd, &zero, &mut tau);
        found / largest(&tau)
    });
    assert!(left[1] < 10.0 * left[0] + 1e-14, "dense {:e}, chain {:e}", left[0], left[1]);
    let options = newmark::Options::new(1e-2);
    let [dense, chain] = [Solve::Dense, Solve::Tree].map(|solve| motion(&rod, solve, &options));
    assert_eq!(chain.status, Status::Finished, "{}", chain.message);
    let far = difference(&dense.q, &chain.q);
    assert!(far < 1e-6 * largest(&dense.q), "{far:e}");
}

#[test]
fn a_singular_or_non_finite_chain_is_refused() {
    for ranks in [[3, 4], [6, 9], [2, 7]] {
        refuses_what_is_singular_or_not_finite(ranks);
    }
}

fn refuses_what_is_singular_or_not_finite(ranks: [usize; 2]) {
    let sizes = [2, 3, 1, 2];
    let good = random_chain(&sizes, ranks, 30.0, 7);
    let mut lu = TreeLu::new(&good);
    // Two equal rows.
    let mut singular = good.clone();
    singular.blocks[1].set_row(1, &good.blocks[1].row(0).into_owned());
    singular.carrying.rows.set_column(3, &good.carrying.rows.column(2).into_owned());
    singular.carried.rows.set_column(3, &good.carried.rows.column(2).into_owned());
    assert_eq!(lu.factorise(&singular), Err(Singular));
    // All stored numbers of the matrix.
    let n = good.n();
    let poisoned = |poison: &dyn Fn(&mut TreeMatrix)| {
        let mut bad = good.clone();
        poison(&mut bad);
        assert!(!bad.is_finite());
        assert!(!bad.to_dense().iter().all(|entry| entry.is_finite()));
        bad
    };
    for bad in [f64::NAN, f64::INFINITY] {
        for s in 0..sizes.len() {
            for entry in 0..good.blocks[s].len() {
                assert_eq!(lu.factorise(&poisoned(&|a| a.blocks[s][entry] = bad)), Err(Singular));
            }
        }
        for coordinate in 0..n {
            let (is_first, is_last) = (coordinate < sizes[0], coordinate >= n - 2);
            if !is_last {
                assert_eq!(
                    lu.factorise(&poisoned(&|a| a.carrying.rows[(1, coordinate)] = bad)),
                    Err(Singular)
                );
                assert_eq!(
                    lu.factorise(&poisoned(&|a| a.carrying.columns[(1, coordinate)] = bad)),
                    Err(Singular)
                );
            }
            if !is_first {
                assert_eq!(
                    lu.factorise(&poisoned(&|a| a.carried.columns[(1, coordinate)] = bad)),
                    Err(Singular)
                );
                assert_eq!(
                    lu.factorise(&poisoned(&|a| a.carried.rows[(1, coordinate)] = bad)),
                    Err(Singular)
                );
            }
        }
    }
    // Nothing remains of the failed factorisation.
    assert_eq!(lu.factorise(&good), Ok(()));
    let (mut found, mut fresh) = (vec![1.0; n], vec![1.0; n]);
    lu.solve(&mut found);
    let mut other = TreeLu::new(&good);
    other.factorise(&good).unwrap();
    other.solve(&mut fresh);
    assert_eq!(found, fresh);
}

/// A regular matrix with a singular last block is rejected, because elimination without exchanges between
/// blocks cannot solve it.
#[test]
fn a_singular_schur_complement_of_a_regular_matrix_is_refused() {
    let mut chain = TreeMatrix::chain(&[1, 1], [1, 1]);
    for generators in [&mut chain.carried, &mut chain.carrying] {
        generators.rows.fill(1.0);
        generators.columns.fill(1.0);
    }
    chain.blocks[0][(0, 0)] = 1.0;
    assert_eq!(chain.to_dense(), Matrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 0.0]));
    assert_eq!(Lu::new(2).factorise(&chain.to_dense()), Ok(()));
    assert_eq!(TreeLu::new(&chain).factorise(&chain), Err(Singular));
}

/// `a = f` for two coordinates with one block each; the tangent is `tangent` from t = 0.5 on, where the first one moves with 0.5.
struct Two {
    facts: Facts,
    tangent: TreeMatrix,
}

impl Dynamics for Two {
    fn facts(&self) -> &Facts {
        &self.facts
    }
    fn inverse_dynamics(&mut self, _q: &[f64], _qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        tau.copy_from_slice(&[qdd[0] - 1.0, qdd[1] + 2.0]);
    }
    fn weighted_tangent(&mut self, _: &[f64], _: &[f64], _: &[f64], _: [f64; 3], _: &mut Matrix) {
        unreachable!("a chain")
    }
    fn tree(&self) -> Option<Tree> {
        let chain = || TreeMatrix::chain(&[1, 1], [1, 1]);
        Some(Tree { tangent: chain(), mass: chain() })
    }
    fn tree_tangent(&mut self, _: &[f64], qd: &[f64], _: &[f64], _: [f64; 3], tangent: &mut TreeMatrix) {
        tangent.clone_from(&self.tangent);
        if qd[0] < 0.49 {
            tangent.blocks.iter_mut().for_each(|block| block[(0, 0)] = 1.0);
        }
    }
    fn mass_matrix(&mut self, _q: &[f64], _mass: &mut Matrix) {
        unreachable!("a chain")
    }
    fn energy(&mut self, _q: &[f64], _qd: &[f64]) -> Energy {
        Energy::default()
    }
    fn dissipated_power(&mut self, _q: &[f64], _qd: &[f64]) -> f64 {
        0.0
    }
    fn supplied_power(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64]) -> f64 {
        0.0
    }
    fn tip(&mut self, _q: &[f64]) -> [f64; 3] {
        [0.0; 3]
    }
    fn invalid_shape(&mut self, _q: &[f64]) -> Option<InvalidShape> {
        None
    }
}

impl Elastic for Two {
    fn elastic_forces(&mut self, _q: &[f64], tau: &mut [f64]) {
        tau.fill(0.0);
    }
    fn elastic_tangent(&mut self, _q: &[f64], tangent: &mut Matrix) {
        tangent.fill(0.0);
    }
    fn turned_loads(&mut self, _q: &[f64], forces: &mut Matrix, _borne: &mut [f64]) {
        forces.fill(0.0);
    }
    fn sizes(&mut self, _q: &[f64], sizes: &mut [f64]) {
        sizes.fill(1.0);
    }
}

impl Autonomous for Two {}

impl Smooth for Two {}

#[test]
fn a_step_with_a_singular_chain_ends_with_a_status_that_says_so() {
    let zeros = TreeMatrix::chain(&[1, 1], [1, 1]);
    let mut infinite = zeros.clone();
    infinite.blocks[0][(0, 0)] = f64::INFINITY;
    for (tangent, failure) in [(zeros, Failure::SingularJacobian), (infinite, Failure::NonFinite)] {
        let options = newmark::Options { reuse_jacobian: false, ..newmark::Options::new(0.1) };
        let mut system = Two { facts: Facts::smooth(2, 1.0), tangent };
        let zero = [0.0; 2];
        let found = newmark::solve(&mut system, (0.0, 1.0), &zero, &zero, &options, None, &mut |_, _| Ok(()))
            .unwrap();
        assert_eq!(found.status, Status::StepFailed(failure), "{}", found.message);
        assert_eq!(found.t.len(), 5);
        assert_eq!(found.a[..2], [1.0, -2.0]);
    }
}

/// Finite differences do not use the structure of a chain; they give the same motion with a dense Jacobian.
#[test]
fn differenced_jacobians_of_chains_are_dense() {
    let rod = Rod::new(vec![soft([0, 1, 1, 0, 0, 0]); 3]);
    let options = newmark::Options::new(5e-3);
    let differences = newmark::Options { derivative: Derivative::Central, ..options.clone() };
    let [exact, differenced] = [options, differences].map(|options| motion(&rod, Solve::Tree, &options));
    assert_eq!([exact.counters.nfev_jacobian > 0, differenced.counters.nfev_jacobian > 0], [false, true]);
    assert!(difference(&exact.q, &differenced.q) < 1e-4 * largest(&exact.q));
}

#[test]
fn long_rods_are_chains_by_default_and_short_ones_are_not() {
    let solve = |segments, modes| RobotModel::of_rod(&Rod::new(vec![soft(modes); segments])).unwrap().solve();
    assert_eq!(solve(1, [4; 6]), Solve::Dense);
    assert_eq!(solve(2, [4; 6]), Solve::Dense);
    assert_eq!(solve(9, [0, 2, 0, 0, 0, 0]), Solve::Dense);
    assert_eq!(solve(10, [0, 2, 0, 0, 0, 0]), Solve::Tree);
    assert_eq!(solve(128, [0, 1, 1, 0, 0, 0]), Solve::Tree);
    let short = RobotModel::of_rod(&Rod::new(vec![soft([0, 1, 0, 0, 0, 0])])).unwrap();
    assert!(short.tree().is_none());
}

/// The cost of a step grows linearly with the number of segments: residual, tangent, factorisation and
/// solution take the same number of products for each additional segment, and a Newmark run takes the same
/// number of evaluations.
#[test]
fn the_cost_of_a_long_chain_grows_with_its_length() {
    let model = |segments| RobotModel::of_rod(&Rod::new(vec![soft([0, 1, 1, 0, 0, 0]); segments])).unwrap();
    let total = |segments| {
        let cost = model(segments).multiplications();
        cost.residual + cost.tangent + cost.factorisation + cost.solution
    };
    let ratio = total(100) as f64 / total(10) as f64;
    assert!((9.9..10.2).contains(&ratio), "{ratio}");
}
