//! Tendons embedded in rods: lengths, gradients and second derivatives, which depend only on strains
//! (docs/actuators.md):
//!
//! ```text
//! l = int |u| dX,   dl/dq_k = int phi_k b_c . t dX,   d2l/dq_j dq_k = int phi_j phi_k b_c . (1 - t t^T) b_d / |u| dX
//! ```
//!
//! with the unit tangent `t = u / |u|` (Renda, Armanini, Lebastard, Candelier and Boyer 2020, section III;
//! for the tangent see the page above).

use crate::numerics::lie::Lanes;
use crate::robot::effects::actuator::plan::{Guide, RoutingSegment, pairs};

/// Writes a field of the strains at the nodes: entry `[component * packs + pack]`.
#[inline(always)]
pub(super) fn fields<P: Lanes>(routing_segment: &RoutingSegment<P>, q: &[f64], fields: &mut [P]) {
    for (c, component) in routing_segment.components.iter().enumerate() {
        let field = &mut fields[c * routing_segment.packs..][..routing_segment.packs];
        field.fill(P::splat(0.0));
        let rows = routing_segment.basis.chunks_exact(routing_segment.packs);
        for (&q, row) in q[component.first..][..component.modes].iter().zip(rows) {
            for (field, &basis) in field.iter_mut().zip(row) {
                *field = basis.mul_add(P::splat(q), *field);
            }
        }
    }
}

/// Length of a tendon in a routing segment with these strains; writes `b_c . t` and `1 / |u|`, and adds the gradient.
#[inline(always)]
pub(super) fn measure<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    guide: &Guide<P>,
    fields: &[P],
    slopes: &mut [P],
    inverse_norms: &mut [P],
    gradient: &mut [f64],
) -> f64 {
    let packs = routing_segment.packs;
    let number = routing_segment.components.len();
    let mut length = P::splat(0.0);
    for pack in 0..packs {
        let mut u = guide.start[pack];
        for c in 0..number {
            u = u.add_scaled(guide.directions[c * packs + pack], fields[c * packs + pack]);
        }
        let norm = u.dot(u).sqrt();
        let inverse = norm.reciprocal();
        inverse_norms[pack] = inverse;
        length = norm.mul_add(routing_segment.weights[pack], length);
        for c in 0..number {
            slopes[c * packs + pack] = u.dot(guide.directions[c * packs + pack]) * inverse;
        }
    }
    project(routing_segment, slopes, gradient);
    length.sum()
}

/// Adds `int phi_k f_c` for densities f to a vector dual to the coordinates.
#[inline(always)]
pub(super) fn project<P: Lanes>(routing_segment: &RoutingSegment<P>, densities: &[P], to: &mut [f64]) {
    let packs = routing_segment.packs;
    for (c, component) in routing_segment.components.iter().enumerate() {
        let density = &densities[c * packs..][..packs];
        let rows = routing_segment.weighted_basis.chunks_exact(packs);
        for (to, row) in to[component.first..][..component.modes].iter_mut().zip(rows) {
            let mut sum = P::splat(0.0);
            for (&weight, &density) in row.iter().zip(density) {
                sum = weight.mul_add(density, sum);
            }
            *to += sum.sum();
        }
    }
}

/// Adds `factor b_c . (1 - t t^T) b_d / |u|` at the nodes, times the ratios there: entry `[pair * packs + pack]`.
#[inline(always)]
pub(super) fn stiffen<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    guide: &Guide<P>,
    slopes: &[P],
    inverse_norms: &[P],
    ratios: &[P],
    factor: f64,
    stiffness: &mut [P],
) {
    let packs = routing_segment.packs;
    for (pair, (c, d)) in pairs(routing_segment.components.len()).enumerate() {
        for pack in 0..packs {
            let across = slopes[c * packs + pack]
                .mul_sub_from(slopes[d * packs + pack], guide.products[pair * packs + pack]);
            let scaled = inverse_norms[pack] * ratios[pack] * factor;
            let entry = &mut stiffness[pair * packs + pack];
            *entry = across.mul_add(scaled, *entry);
        }
    }
}

/// Adds `int phi_j phi_k S_cd` for stiffnesses S to a block of columns starting at coordinate `first`.
#[inline(always)]
pub(super) fn add_stiffness<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    stiffness: &[P],
    first: usize,
    block: &mut [f64],
    stride: usize,
) {
    let packs = routing_segment.packs;
    for (pair, (c, d)) in pairs(routing_segment.components.len()).enumerate() {
        let density = &stiffness[pair * packs..][..packs];
        let [c_first, d_first] = [c, d].map(|c| routing_segment.components[c].first - first);
        for k in 0..routing_segment.components[d].modes {
            let column = &routing_segment.weighted_basis[k * packs..][..packs];
            let rows = if c == d { 0..k + 1 } else { 0..routing_segment.components[c].modes };
            for j in rows {
                let row = &routing_segment.basis[j * packs..][..packs];
                let mut sum = P::splat(0.0);
                for pack in 0..packs {
                    sum = (column[pack] * row[pack]).mul_add(density[pack], sum);
                }
                let sum = sum.sum();
                let (row, column) = (c_first + j, d_first + k);
                block[column * stride + row] += sum;
                if row != column {
                    block[row * stride + column] += sum;
                }
            }
        }
    }
}

/// Writes the rates of `b_c . t` for these rates of the strains.
#[inline(always)]
pub(super) fn slope_rates<P: Lanes>(
    routing_segment: &RoutingSegment<P>,
    guide: &Guide<P>,
    slopes: &[P],
    inverse_norms: &[P],
    rates: &[P],
    densities: &mut [P],
) {
    let packs = routing_segment.packs;
    densities[..routing_segment.components.len() * packs].fill(P::splat(0.0));
    for (pair, (c, d)) in pairs(routing_segment.components.len()).enumerate() {
        for pack in 0..packs {
            let across = slopes[c * packs + pack]
                .mul_sub_from(slopes[d * packs + pack], guide.products[pair * packs + pack]);
            let stiffness = across * inverse_norms[pack];
            let at = |c: usize| c * packs + pack;
            densities[at(c)] = stiffness.mul_add(rates[at(d)], densities[at(c)]);
            if c != d {
                densities[at(d)] = stiffness.mul_add(rates[at(c)], densities[at(d)]);
            }
        }
    }
}
