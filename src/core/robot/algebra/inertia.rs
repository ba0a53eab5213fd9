//! Inertia about the origin of the inertial frame, `N = Ad_g^-T M Ad_g^-1`: of sections, of bodies, and of
//! everything beyond a station; and changes of wrenches under rotations of the body.

use crate::numerics::lie::{Cross, Geometry, LANES, Lanes, Scalar, SecondMoment, Twist, VectorSpace, Wrench};

/// Inertia per length of an axisymmetric section, about the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionInertia<G: Geometry, T: Scalar> {
    pub(crate) mass: T,
    /// Rotary inertia about a diameter; about the axis it is twice that, as for every circle.
    pub(crate) rotary: T,
    pub(crate) axis: G::Vector<T>,
    pub(crate) position: G::Vector<T>,
}

/// General inertia: mass, first moment (mass times position of the centre) and second moment about the
/// origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inertia<G: Geometry, T: Scalar> {
    pub(crate) mass: T,
    pub(crate) first_moment: G::Vector<T>,
    pub(crate) second_moment: G::SecondMoment<T>,
}

impl<G: Geometry, T: Scalar> Inertia<G, T> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self { mass: T::splat(0.0), first_moment: VectorSpace::zero(), second_moment: SecondMoment::zero() }
    }

    /// Inertia of an axisymmetric section about its centre, in its axes.
    pub(crate) fn round(frame: G::Frame, mass: T, rotary: T) -> Self {
        let axis = G::rod_axis(frame, &G::unrotated());
        let centre = VectorSpace::zero();
        Self { mass, first_moment: centre, second_moment: G::section(mass, rotary, axis, centre) }
    }

    /// `N z`.
    #[inline(always)]
    pub(crate) fn momentum(&self, z: Twist<G, T>) -> Wrench<G, T> {
        Wrench {
            moment: self
                .first_moment
                .cross_add(z.linear, G::angular_momentum(&self.second_moment, z.angular)),
            force: z.angular.cross_add(self.first_moment, z.linear * self.mass),
        }
    }

    /// Converts from section axes at a position to the axes of the frame and the origin.
    #[inline(always)]
    pub(crate) fn carried(&self, rotation: &G::Rotation<T>, position: G::Vector<T>) -> Self {
        let Self { mass, first_moment, ref second_moment } = *self;
        let first_moment = G::rotate(rotation, first_moment);
        let none = SecondMoment::zero();
        let (zero, nowhere) = (VectorSpace::zero(), VectorSpace::zero());
        Self {
            mass,
            first_moment: first_moment + position * mass,
            // Parallel-axis theorem for the mass and for the offset of its centre.
            second_moment: G::rotate_second_moment(rotation, second_moment)
                + G::section(mass, T::splat(0.0), nowhere, position)
                + G::gyroscopic(&none, position, zero, first_moment),
        }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.second_moment += other.second_moment;
    }
}

/// Packs the values of a function of the node, [`LANES`] per pack.
pub(crate) fn packed<G: Geometry>(
    nodes: usize,
    f: impl Fn(usize) -> Inertia<G, f64>,
) -> Vec<Inertia<G, G::Pack>> {
    let only = |lane: usize| G::Pack::from_lanes(std::array::from_fn(|i| f64::from(u8::from(i == lane))));
    let pack = |pack: usize| {
        let mut sum = Inertia::zero();
        for lane in 0..LANES {
            let Inertia { mass, first_moment, second_moment } = f(pack * LANES + lane);
            sum.add(Inertia {
                mass: only(lane) * mass,
                first_moment: G::map_vector(&first_moment, |&x| only(lane) * x),
                second_moment: G::map_second_moment(&second_moment, |&x| only(lane) * x),
            });
        }
        sum
    };
    (0..nodes / LANES).map(pack).collect()
}

impl<G: Geometry> Inertia<G, G::Pack> {
    /// Sum over the lanes.
    #[inline(always)]
    pub(crate) fn sum(self) -> Inertia<G, f64> {
        Inertia {
            mass: self.mass.sum(),
            first_moment: G::map_vector(&self.first_moment, |pack: &G::Pack| pack.sum()),
            second_moment: G::map_second_moment(&self.second_moment, |pack: &G::Pack| pack.sum()),
        }
    }
}

/// Wrench that is linear in a rotation or an angular velocity of the material: `(B y - h x y; -2 l x y)`.
///
/// Change of the inertial force of a body moving with V under the variation `Y = dV - ad_Psi V`: `C Y = -(N
/// ad_V + ad_V^T N) Y - ad_Y^T N V`. With the momentum `N V = (h; l)` and the moments of N, all terms with
/// the linear part of Y cancel, and `C Y = (B y - h x y; -2 l x y)` with the angular part y of Y and `B = -(J
/// [w] + (J [w])^T) - (c v^T + v c^T) + 2 (c . v) 1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gyroscope<G: Geometry, T: Scalar> {
    symmetric: G::SecondMoment<T>,
    momentum: Wrench<G, T>,
}

impl<G: Geometry, T: Scalar> Gyroscope<G, T> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self { symmetric: SecondMoment::zero(), momentum: Wrench::zero() }
    }

    /// For a body with this inertia, velocity and momentum.
    #[inline(always)]
    pub(crate) fn new(inertia: &Inertia<G, T>, velocity: Twist<G, T>, momentum: Wrench<G, T>) -> Self {
        let Twist { angular, linear } = velocity;
        let symmetric = G::gyroscopic(&inertia.second_moment, inertia.first_moment, angular, linear);
        Self { symmetric, momentum }
    }

    /// Change of the wrench that balances a dead load, relative to the rotating material: for a force p and a
    /// moment m at r and a rotation by y, `-(r x (p x y) + m x y; p x y)`. The symmetric part of the moment
    /// is that of `p r^T - r . p`.
    #[inline(always)]
    pub(crate) fn of_dead_load(load: Wrench<G, T>, position: G::Vector<T>) -> Self {
        let half_force = load.force * T::splat(0.5);
        Self {
            symmetric: G::gyroscopic(&SecondMoment::zero(), position, VectorSpace::zero(), half_force),
            momentum: Wrench { moment: load.moment + position.cross(half_force), force: half_force },
        }
    }

    /// `C Y`, from the angular part of Y.
    #[inline(always)]
    pub(crate) fn times(&self, y: G::Axial<T>) -> Wrench<G, T> {
        Wrench {
            moment: y.cross_add(self.momentum.moment, G::angular_momentum(&self.symmetric, y)),
            force: y.cross(self.momentum.force + self.momentum.force),
        }
    }

    /// Angular part of `C^T psi`; its linear part is zero.
    #[inline(always)]
    pub(crate) fn transposed_times(&self, psi: Twist<G, T>) -> G::Axial<T> {
        let force = self.momentum.force + self.momentum.force;
        force.cross_add(
            psi.linear,
            self.momentum.moment.cross_add(psi.angular, G::angular_momentum(&self.symmetric, psi.angular)),
        )
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: Self) {
        self.symmetric += other.symmetric;
        self.momentum += other.momentum;
    }
}

impl<G: Geometry> Gyroscope<G, G::Pack> {
    /// Sum over the lanes.
    #[inline(always)]
    pub(crate) fn sum(self) -> Gyroscope<G, f64> {
        Gyroscope {
            symmetric: G::map_second_moment(&self.symmetric, |pack: &G::Pack| pack.sum()),
            momentum: self.momentum.sum(),
        }
    }
}

/// Inertia per length of the sections of a segment.
pub(crate) trait Sections<G: Geometry> {
    type AboutOrigin: InertiaAboutOrigin<G, G::Pack>;

    /// Inertia about the origin of one pack of nodes with this rotation and position.
    fn about_origin(
        &self,
        frame: G::Frame,
        pack: usize,
        rotation: &G::Rotation<G::Pack>,
        position: G::Vector<G::Pack>,
    ) -> Self::AboutOrigin;
}

/// Inertia about the origin.
pub(crate) trait InertiaAboutOrigin<G: Geometry, T: Scalar> {
    /// Momentum of a twist, `N V`.
    fn momentum(&self, twist: Twist<G, T>) -> Wrench<G, T>;
    /// The inertia times `weight`, in a form that can be summed.
    fn weighted(&self, weight: T) -> Inertia<G, T>;
}

/// Axisymmetric sections: mass and rotary inertia.
pub(crate) struct Round<'a, G: Geometry> {
    pub(crate) mass: &'a [G::Pack],
    pub(crate) rotary: &'a [G::Pack],
}

impl<G: Geometry> Sections<G> for Round<'_, G> {
    type AboutOrigin = SectionInertia<G, G::Pack>;

    #[inline(always)]
    fn about_origin(
        &self,
        frame: G::Frame,
        pack: usize,
        rotation: &G::Rotation<G::Pack>,
        position: G::Vector<G::Pack>,
    ) -> Self::AboutOrigin {
        let (mass, rotary) = (self.mass[pack], self.rotary[pack]);
        SectionInertia { mass, rotary, axis: G::rod_axis(frame, rotation), position }
    }
}

impl<G: Geometry, T: Scalar> InertiaAboutOrigin<G, T> for SectionInertia<G, T> {
    #[inline(always)]
    fn momentum(&self, twist: Twist<G, T>) -> Wrench<G, T> {
        let Twist { angular, linear } = twist;
        let momentum = angular.cross_add(self.position, linear) * self.mass;
        let spin = G::spin(self.rotary, self.axis, angular);
        Wrench { moment: self.position.cross_add(momentum, spin), force: momentum }
    }

    #[inline(always)]
    fn weighted(&self, weight: T) -> Inertia<G, T> {
        let (mass, rotary) = (self.mass * weight, self.rotary * weight);
        Inertia {
            mass,
            first_moment: self.position * mass,
            second_moment: G::section(mass, rotary, self.axis, self.position),
        }
    }
}

/// General sections: inertia about the rod's axis, in section axes.
pub(crate) struct General<'a, G: Geometry>(pub(crate) &'a [Inertia<G, G::Pack>]);

impl<G: Geometry> Sections<G> for General<'_, G> {
    type AboutOrigin = Inertia<G, G::Pack>;

    #[inline(always)]
    fn about_origin(
        &self,
        _: G::Frame,
        pack: usize,
        rotation: &G::Rotation<G::Pack>,
        position: G::Vector<G::Pack>,
    ) -> Self::AboutOrigin {
        self.0[pack].carried(rotation, position)
    }
}

impl<G: Geometry, T: Scalar> InertiaAboutOrigin<G, T> for Inertia<G, T> {
    #[inline(always)]
    fn momentum(&self, twist: Twist<G, T>) -> Wrench<G, T> {
        self.momentum(twist)
    }

    #[inline(always)]
    fn weighted(&self, weight: T) -> Self {
        Self {
            mass: self.mass * weight,
            first_moment: self.first_moment * weight,
            second_moment: self.second_moment * weight,
        }
    }
}
