//! SIMD lanes for nodes of one run, or for the same node of several runs: `cargo bench --bench lanes`.
//!
//! Both variants compute the forces of a planar rod without stretch, in the simplest form. lissom uses lanes
//! for nodes; `docs/development/performance.md` explains the results.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use lissom::lie::{Instructions, LANES, Lanes, Pack, Scalar, Sweep, sine_cosine};
use lissom::rod::{Gauss, legendre};

type Four = Pack<true>;

const MASS: f64 = 0.0245;
const ROTARY: f64 = 6e-9;
const STIFFNESS: f64 = 0.16;
const DAMPING: f64 = 1e-4;
const GRAVITY: f64 = 9.81;

/// Tables of a rod of length one with K modes and N nodes.
struct Tables<const K: usize, const N: usize> {
    weighted_basis: [[f64; N]; K],
    /// Rotation of the nodes by each mode of curvature.
    turns: [[f64; N]; K],
    /// Integration matrices from the base to the nodes, and from the nodes to the tip.
    from_base: [[f64; N]; N],
    to_tip: [[f64; N]; N],
}

impl<const K: usize, const N: usize> Tables<K, N> {
    fn new() -> Self {
        let gauss = Gauss::new(N);
        let integral = gauss.integral();
        let from_base: [[f64; N]; N] = std::array::from_fn(|i| {
            let weights = integral.weights_up_to(gauss.nodes[i]);
            std::array::from_fn(|l| weights[l])
        });
        let values = |x: f64| {
            let mut values = [0.0; K];
            legendre(x, &mut values);
            values
        };
        let at_nodes: [[f64; K]; N] = std::array::from_fn(|i| values(gauss.nodes[i]));
        let basis: [[f64; N]; K] = std::array::from_fn(|k| std::array::from_fn(|i| at_nodes[i][k]));
        Self {
            weighted_basis: std::array::from_fn(|k| std::array::from_fn(|i| gauss.weights[i] * basis[k][i])),
            turns: std::array::from_fn(|k| {
                std::array::from_fn(|i| (0..N).map(|l| from_base[i][l] * basis[k][l]).sum())
            }),
            to_tip: std::array::from_fn(|i| std::array::from_fn(|l| gauss.weights[l] - from_base[i][l])),
            from_base,
        }
    }
}

/// Per length of the rod: the direction and the acceleration of the points; and the angular acceleration.
#[inline(always)]
fn rates(angle: Four, velocity: Four, acceleration: Four) -> ([Four; 2], [Four; 2]) {
    let (sine, cosine) = sine_cosine(angle);
    let square = velocity * velocity;
    let along = [-(acceleration * sine) - square * cosine, acceleration * cosine - square * sine];
    ([cosine, sine], along)
}

/// Inertial force and moment about the origin, at a node.
#[inline(always)]
fn forces([x, y]: [Four; 2], acceleration: [Four; 2], angular: Four) -> [Four; 3] {
    let [f, g] = acceleration.map(|a| a * MASS);
    [f, g, angular * ROTARY + x * g - y * f]
}

/// Lanes hold the same node of four runs.
struct AcrossRuns<'a, const K: usize, const N: usize> {
    tables: &'a Tables<K, N>,
    state: &'a [[Four; K]; 3],
}

impl<const K: usize, const N: usize> Sweep for AcrossRuns<'_, K, N> {
    type Output = [Four; K];

    #[inline(always)]
    fn call(self) -> [Four; K] {
        let Self { tables, state: [q, v, a] } = self;
        let zero = Four::splat(0.0);
        let (mut direction, mut along) = ([[zero; 2]; N], [[zero; 2]; N]);
        let mut angular = [zero; N];
        for i in 0..N {
            let mut sums = [zero; 3];
            for k in 0..K {
                let turn = Four::splat(tables.turns[k][i]);
                for (sum, values) in sums.iter_mut().zip([q, v, a]) {
                    *sum = turn.mul_add(values[k], *sum);
                }
            }
            (direction[i], along[i]) = rates(sums[0], sums[1], sums[2]);
            angular[i] = sums[2];
        }
        let (mut position, mut force) = ([[zero; 2]; N], [[zero; 3]; N]);
        for i in 0..N {
            let (mut place, mut acceleration) = ([zero; 2], [zero, Four::splat(GRAVITY)]);
            for l in 0..N {
                let weight = Four::splat(tables.from_base[i][l]);
                for c in 0..2 {
                    place[c] = weight.mul_add(direction[l][c], place[c]);
                    acceleration[c] = weight.mul_add(along[l][c], acceleration[c]);
                }
            }
            position[i] = place;
            force[i] = forces(place, acceleration, angular[i]);
        }
        let mut tau = [zero; K];
        for i in 0..N {
            let mut inner = [zero; 3];
            for l in 0..N {
                let weight = Four::splat(tables.to_tip[i][l]);
                for c in 0..3 {
                    inner[c] = weight.mul_add(force[l][c], inner[c]);
                }
            }
            let moment = inner[2] - position[i][0] * inner[1] + position[i][1] * inner[0];
            for k in 0..K {
                tau[k] = Four::splat(tables.weighted_basis[k][i]).mul_add(moment, tau[k]);
            }
        }
        for k in 0..K {
            tau[k] = Four::splat(STIFFNESS).mul_add(v[k] * DAMPING + q[k], tau[k]);
        }
        tau
    }
}

/// [`Tables`] with four nodes in each pack, P of them.
struct Packed<const K: usize, const N: usize, const P: usize> {
    weighted_basis: [[Four; P]; K],
    turns: [[Four; P]; K],
    from_base: [[Four; N]; P],
    to_tip: [[Four; N]; P],
}

impl<const K: usize, const N: usize, const P: usize> Packed<K, N, P> {
    fn new(tables: &Tables<K, N>) -> Self {
        let pack = |row: &[f64; N], p: usize| Four::from_lanes(std::array::from_fn(|i| row[p * LANES + i]));
        let matrix = |rows: &[[f64; N]; N]| {
            std::array::from_fn(|p| {
                std::array::from_fn(|l| Four::from_lanes(std::array::from_fn(|i| rows[p * LANES + i][l])))
            })
        };
        let rows = |rows: &[[f64; N]; K]| std::array::from_fn(|k| std::array::from_fn(|p| pack(&rows[k], p)));
        Self {
            weighted_basis: rows(&tables.weighted_basis),
            turns: rows(&tables.turns),
            from_base: matrix(&tables.from_base),
            to_tip: matrix(&tables.to_tip),
        }
    }
}

/// Lanes hold four nodes of one run.
struct AcrossNodes<'a, const K: usize, const N: usize, const P: usize> {
    tables: &'a Packed<K, N, P>,
    state: &'a [[f64; K]; 3],
}

impl<const K: usize, const N: usize, const P: usize> Sweep for AcrossNodes<'_, K, N, P> {
    type Output = [f64; K];

    #[inline(always)]
    fn call(self) -> [f64; K] {
        let Self { tables, state: [q, v, a] } = self;
        let zero = Four::splat(0.0);
        let (mut direction, mut along) = ([[zero; P]; 2], [[zero; P]; 2]);
        let mut angular = [zero; P];
        for p in 0..P {
            let mut sums = [zero; 3];
            for k in 0..K {
                let turn = tables.turns[k][p];
                for (sum, values) in sums.iter_mut().zip([q, v, a]) {
                    *sum = turn.mul_add(Four::splat(values[k]), *sum);
                }
            }
            let rates = rates(sums[0], sums[1], sums[2]);
            for c in 0..2 {
                (direction[c][p], along[c][p]) = (rates.0[c], rates.1[c]);
            }
            angular[p] = sums[2];
        }
        let node = |values: &[Four; P], l: usize| Four::splat(values[l / LANES].lane(l % LANES));
        let (mut position, mut force) = ([[zero; P]; 2], [[zero; P]; 3]);
        for p in 0..P {
            let (mut place, mut acceleration) = ([zero; 2], [zero, Four::splat(GRAVITY)]);
            for l in 0..N {
                let weight = tables.from_base[p][l];
                for c in 0..2 {
                    place[c] = weight.mul_add(node(&direction[c], l), place[c]);
                    acceleration[c] = weight.mul_add(node(&along[c], l), acceleration[c]);
                }
            }
            let needed = forces(place, acceleration, angular[p]);
            (0..2).for_each(|c| position[c][p] = place[c]);
            (0..3).for_each(|c| force[c][p] = needed[c]);
        }
        let mut tau = [zero; K];
        for p in 0..P {
            let mut inner = [zero; 3];
            for l in 0..N {
                let weight = tables.to_tip[p][l];
                for c in 0..3 {
                    inner[c] = weight.mul_add(node(&force[c], l), inner[c]);
                }
            }
            let moment = inner[2] - position[0][p] * inner[1] + position[1][p] * inner[0];
            for k in 0..K {
                tau[k] = tables.weighted_basis[k][p].mul_add(moment, tau[k]);
            }
        }
        std::array::from_fn(|k| tau[k].sum() + STIFFNESS * (q[k] + DAMPING * v[k]))
    }
}

/// Benchmarks a rod of K coordinates with N nodes in P packs; M nodes would suffice without full packs.
fn rod<const K: usize, const N: usize, const P: usize, const M: usize>(criterion: &mut Criterion) {
    let instructions = Instructions::of_machine();
    if !instructions.has_fused() {
        return;
    }
    let (tables, fewer) = (Tables::<K, N>::new(), Tables::<K, M>::new());
    let packed = Packed::<K, N, P>::new(&tables);
    let state = [0.5, 1.0, 5.0].map(|size| std::array::from_fn(|k| size / (1.0 + (k * k) as f64)));
    let four = state.map(|values: [f64; K]| values.map(Four::splat));
    let of_nodes = |state| instructions.run::<Four, _>(AcrossNodes { tables: &packed, state });
    let of_runs = |state| instructions.run::<Four, _>(AcrossRuns { tables: &tables, state });
    for (one, other) in of_nodes(&state).into_iter().zip(of_runs(&four)) {
        assert!((one - other.lane(0)).abs() < 1e-12, "both are the same: {one}, {other:?}");
    }
    criterion.bench_function(&format!("{K} coordinates/one run, lanes of {N} nodes"), |bencher| {
        bencher.iter(|| of_nodes(black_box(&state)));
    });
    criterion.bench_function(&format!("{K} coordinates/four runs, {N} nodes"), |bencher| {
        bencher.iter(|| of_runs(black_box(&four)));
    });
    criterion.bench_function(&format!("{K} coordinates/four runs, {M} nodes"), |bencher| {
        bencher.iter(|| instructions.run::<Four, _>(AcrossRuns { tables: &fewer, state: black_box(&four) }));
    });
}

/// The lab's rod fills its packs; twelve modes need 22 nodes.
fn both(criterion: &mut Criterion) {
    rod::<3, 12, 3, 12>(criterion);
    rod::<12, 24, 6, 22>(criterion);
}

criterion_group!(benches, both);
criterion_main!(benches);
