"""How far does a steel wire sag, and how many modes does it take to know?

The equilibrium is the root of the inverse dynamics at rest; its exact Jacobian is the model's tangent.
"""

import numpy as np

import lissom

EXACT_TIP = np.array([0.981801548109, -0.177564708339])  # of the differential equation, metres


def wire(modes: int) -> lissom.Rod:
    """One metre of steel wire, 2 mm thick, held out horizontally."""
    segment = lissom.Segment(
        length=1.0,
        radius=1e-3,
        young_modulus=210e9,
        shear_modulus=80e9,
        density=7800.0,
        modes={"bend_y": modes},
    )
    return lissom.Rod([segment])


def equilibrium(rod: lissom.Rod) -> np.ndarray:
    """Coordinates at which gravity and elasticity balance."""
    rest = np.zeros(rod.n)
    result = lissom.root(
        lambda q: rod.inverse_dynamics(q, rest, rest),
        rest,
        jac=lambda q: rod.tangent(q, rest, rest)[0],
        tol=1e-13,
    )
    if not result.success:
        raise SystemExit(result.message)
    return result.x


def main() -> None:
    """Print the tip and its error for more and more modes."""
    print("modes  tip x [m]     tip z [m]     error [m]")
    for modes in range(1, 8):
        rod = wire(modes)
        tip = rod.pose(equilibrium(rod), rod.length)[[0, 2], 3]
        print(f"{modes:5}  {tip[0]:.9f}  {tip[1]:.9f}  {np.linalg.norm(tip - EXACT_TIP):.1e}")


if __name__ == "__main__":
    main()
