"""The wire of the lab is let go: Newmark steps of several sizes, and what they do to the energy.

Without damping the average-acceleration scheme (beta = 1/4, gamma = 1/2) has no numerical dissipation; what
is left is an error that falls with the square of the step.
"""

import numpy as np

import lissom


def wire() -> lissom.Rod:
    """One metre of steel wire without damping, clamped at the origin along world x."""
    segment = lissom.Segment(
        length=1.0,
        radius=1e-3,
        young_modulus=210e9,
        shear_modulus=80e9,
        density=7800.0,
        modes={"bend_y": 3},
    )
    return lissom.Rod([segment])


def main() -> None:
    """Print where the tip is after one second and how much energy went astray."""
    rod = wire()
    print("step [ms]  tip x [m]  tip z [m]  largest energy error [µJ]")
    for dt in (1e-2, 5e-3, 2.5e-3, 1.25e-3):
        motion = lissom.simulate(rod, t_end=1.0, dt=dt)
        if not motion.success:
            raise SystemExit(motion.message)
        energy = np.array([rod.energy(q, v).total for q, v in zip(motion.q, motion.v, strict=True)])
        tip = rod.pose(motion.q[-1], rod.length)[:3, 3]
        astray = 1e6 * np.abs(energy - energy[0]).max()
        print(f"{1e3 * dt:9.2f}  {tip[0]:9.5f}  {tip[2]:9.5f}  {astray:25.3f}")


if __name__ == "__main__":
    main()
