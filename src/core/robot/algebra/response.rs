//! Linear responses to displacement, velocity and acceleration other than those of rigid bodies: springs to
//! the world, and the fluid around a section.

use crate::numerics::lie::{Geometry, Scalar, Twist, Wrench};

/// A wrench that is linear in a twist: a matrix stored by columns. A plane uses only the first
/// [`Geometry::COMPONENTS`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linear<G: Geometry, T: Scalar> {
    columns: [Wrench<G, T>; 6],
}

impl<G: Geometry, T: Scalar> Linear<G, T> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self { columns: [Wrench::zero(); 6] }
    }

    /// Matrix of a linear map, from its values for unit twists.
    #[inline(always)]
    pub(crate) fn of(map: impl Fn(Twist<G, T>) -> Wrench<G, T>) -> Self {
        let mut matrix = Self::zero();
        for (index, column) in matrix.columns[..G::COMPONENTS].iter_mut().enumerate() {
            let mut unit = Twist::zero();
            *unit.component_mut(index) = T::splat(1.0);
            *column = map(unit);
        }
        matrix
    }

    #[inline(always)]
    pub(crate) fn times_add(&self, mut twist: Twist<G, T>, mut sum: Wrench<G, T>) -> Wrench<G, T> {
        for (index, &column) in self.columns[..G::COMPONENTS].iter().enumerate() {
            sum = sum.add_scaled(column, *twist.component_mut(index));
        }
        sum
    }

    #[inline(always)]
    fn transposed_times(&self, twist: Twist<G, T>) -> Wrench<G, T> {
        let mut product = Wrench::zero();
        for (index, &column) in self.columns[..G::COMPONENTS].iter().enumerate() {
            *product.component_mut(index) = twist.dot(column);
        }
        product
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: Self) {
        for (column, other) in self.columns[..G::COMPONENTS].iter_mut().zip(other.columns) {
            *column += other;
        }
    }
}

/// Changes of the wrench about the origin that a point requires from the rod, relative to the moving
/// material: with its displacement (`w_q Psi`), its velocity (Y) and its acceleration (Z); see `tangent`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response<G: Geometry, T: Scalar> {
    pub(crate) stiffness: Linear<G, T>,
    pub(crate) damping: Linear<G, T>,
    /// Symmetric: part of the mass matrix.
    pub(crate) inertia: Linear<G, T>,
}

impl<G: Geometry, T: Scalar> Response<G, T> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self { stiffness: Linear::zero(), damping: Linear::zero(), inertia: Linear::zero() }
    }

    #[inline(always)]
    pub(crate) fn to(&self, displacement: Twist<G, T>, y: Twist<G, T>, z: Twist<G, T>) -> Wrench<G, T> {
        let wrench = self.stiffness.times_add(displacement, Wrench::zero());
        self.inertia.times_add(z, self.damping.times_add(y, wrench))
    }

    /// Products of the three transposes, in the order of the fields, with a twist.
    #[inline(always)]
    pub(crate) fn transposed_times(&self, psi: Twist<G, T>) -> [Wrench<G, T>; 3] {
        [&self.stiffness, &self.damping, &self.inertia].map(|matrix| matrix.transposed_times(psi))
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: Self) {
        self.stiffness.add(other.stiffness);
        self.damping.add(other.damping);
        self.inertia.add(other.inertia);
    }
}

impl<G: Geometry> Response<G, G::Pack> {
    /// Sum over the lanes.
    #[inline(always)]
    pub(crate) fn sum(&self) -> Response<G, f64> {
        let sum = |matrix: &Linear<G, G::Pack>| {
            let mut total = Linear::zero();
            for (total, column) in total.columns[..G::COMPONENTS].iter_mut().zip(matrix.columns) {
                *total = column.sum();
            }
            total
        };
        Response { stiffness: sum(&self.stiffness), damping: sum(&self.damping), inertia: sum(&self.inertia) }
    }
}
