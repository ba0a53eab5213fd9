//! Forces between two magnetic dipoles (Jackson 1998, sections 5.6 and 5.7), and their derivatives.
//!
//! With the way r from b to a and n = r / |r|, the field of b at a and the force on a are
//!
//! ```text
//! B = c (3 n (n . m_b) - m_b) / r^3,      F = grad (m_a . B)
//!   = 3 c ((n . m_a) m_b + (n . m_b) m_a + (m_a . m_b) n - 5 (n . m_a) (n . m_b) n) / r^4
//! ```

use crate::numerics::lie::Vector;

/// Magnetic permeability of the vacuum over 4 pi, in N/A^2 (CODATA 2022: 1.25663706127e-6 over 4 pi).
const PERMEABILITY: f64 = 1.256_637_061_27e-6 / (4.0 * std::f64::consts::PI);

/// A dipole: its moment and its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dipole {
    pub(super) moment: Vector<f64>,
    pub(super) position: Vector<f64>,
}

impl Dipole {
    pub(super) fn none() -> Self {
        Self { moment: Vector::zero(), position: Vector::zero() }
    }
}

/// Fields of two dipoles at each other, and the force on the first one; or the changes of these.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    pub(super) fields: [Vector<f64>; 2],
    pub(super) force: Vector<f64>,
}

/// Products of two dipoles at a distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    way: Vector<f64>,
    moments: [Vector<f64>; 2],
    /// c / r^3, and 1 / r^2.
    strength: f64,
    inverse_square: f64,
}

impl Pair {
    #[inline(always)]
    pub(super) fn of([a, b]: [&Dipole; 2]) -> Self {
        let way = a.position - b.position;
        let inverse_square = way.dot(way).recip();
        let strength = PERMEABILITY * inverse_square * inverse_square.sqrt();
        Self { way, moments: [a.moment, b.moment], strength, inverse_square }
    }

    /// Field of one of them at the other.
    #[inline(always)]
    fn field(&self, source: usize) -> Vector<f64> {
        let Self { way, moments, strength, inverse_square } = *self;
        let along = 3.0 * way.dot(moments[source]) * inverse_square;
        (way * along - moments[source]) * strength
    }

    #[inline(always)]
    pub(super) fn between(&self) -> Between {
        let Self { way, moments: [a, b], strength, inverse_square } = *self;
        let [of_a, of_b] = [way.dot(a), way.dot(b)];
        let along = a.dot(b) - 5.0 * of_a * of_b * inverse_square;
        let force = (b * of_a + a * of_b + way * along) * (3.0 * strength * inverse_square);
        Between { fields: [self.field(1), self.field(0)], force }
    }

    pub(super) fn energy(&self) -> f64 {
        -self.moments[0].dot(self.field(1))
    }

    /// Changes for a change of the vector between the dipoles and of both moments.
    #[inline(always)]
    pub(super) fn change(&self, way_by: Vector<f64>, [a_by, b_by]: [Vector<f64>; 2]) -> Between {
        let Self { way, moments: [a, b], strength, inverse_square } = *self;
        // Relative changes of 1/r, to which all powers belong.
        let nearer = -way.dot(way_by) * inverse_square;
        let field = |moment: Vector<f64>, by: Vector<f64>| {
            let along = 3.0 * way.dot(moment) * inverse_square;
            let along_by = 3.0 * (way_by.dot(moment) + way.dot(by)) * inverse_square;
            let of_distance = (way * (5.0 * along) - moment * 3.0) * nearer;
            (way_by * along + way * along_by - by + of_distance) * strength
        };
        let [of_a, of_b] = [way.dot(a), way.dot(b)];
        let [of_a_by, of_b_by] = [way_by.dot(a) + way.dot(a_by), way_by.dot(b) + way.dot(b_by)];
        let both = a.dot(b);
        let cross = 5.0 * of_a * of_b * inverse_square;
        let cross_by = 5.0 * (of_a_by * of_b + of_a * of_b_by) * inverse_square;
        let along_by = a_by.dot(b) + a.dot(b_by) - cross_by;
        let of_distance = (b * of_a + a * of_b + way * both) * 5.0 - way * (7.0 * cross);
        let force = b_by * of_a
            + b * of_a_by
            + a_by * of_b
            + a * of_b_by
            + way_by * (both - cross)
            + way * along_by
            + of_distance * nearer;
        Between { fields: [field(b, b_by), field(a, a_by)], force: force * (3.0 * strength * inverse_square) }
    }
}
