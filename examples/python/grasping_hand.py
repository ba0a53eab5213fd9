"""How does a soft hand hold a ball, and what passes through its fingers?

Inverse kinematics brings three fingertips onto a ball: of all shapes that do it the one with the least
elastic energy. The strain of that shape says how far the fingers bend, the law of their material what it
takes.
"""

import numpy as np

import lissom

RADIUS = 0.045  # of the ball, metres
CENTRE = np.array([0.13, 0.0, 0.0])


def hand() -> lissom.Robot:
    """Three soft fingers on a palm, at the corners of a triangle, that point along x."""
    finger = lissom.Segment(
        length=0.14,
        radius=(0.011, 0.007),
        young_modulus=2.5e5,
        poisson_ratio=0.5,
        density=1070.0,
        modes={"torsion": 1, "bend_y": 3, "bend_z": 3},
    )
    palm = lissom.Link("palm", body=lissom.Body(0.3))
    fingers = [
        lissom.Link(f"finger {i}", rod=[finger], parent="palm", position=0.05 * direction)
        for i, direction in enumerate(directions())
    ]
    return lissom.Robot([palm, *fingers])


def directions() -> np.ndarray:
    """Unit vectors from the middle of the palm to the fingers."""
    angles = 2 * np.pi * np.arange(3) / 3
    return np.column_stack([np.zeros(3), np.cos(angles), np.sin(angles)])


def main() -> None:
    """Grasp, and say what every finger does."""
    robot = hand()
    names = [link.name for link in robot.links[1:]]
    points = {name: CENTRE + RADIUS * way for name, way in zip(names, directions(), strict=True)}
    grasp = robot.reach(points, prefer="energy")
    print(grasp.status)
    if not grasp.success:
        raise SystemExit(grasp.message)
    rest = np.zeros(robot.n)
    print(f"elastic energy {robot.energy(grasp.q, rest).elastic * 1e3:.3f} mJ")
    print("finger    largest bend [1/m]  moment at the palm [mN m]")
    along = np.linspace(0, 0.14, 29)
    for name in names:
        bend = np.linalg.norm(robot.strain(grasp.q, along, link=name)[:, 1:3], axis=1)
        moment = robot.internal_wrench(grasp.q, rest, rest, 0.0, link=name, by="material")[:3]
        print(f"{name:9} {bend.max():18.2f}  {np.linalg.norm(moment) * 1e3:25.2f}")


if __name__ == "__main__":
    main()
