"""A catheter is pushed through a vessel of five bends.

A wire of 0.25 m with a soft tip is fed by a prescribed motion of its base, through a straight sheath, into
the vessel. The force that this takes grows with each bend: friction adds up as on a capstan.
"""

import argparse

import numpy as np

import lissom

#: Lengths of the shaft and of the soft tip, radius, clearance in the vessel, metres.
SHAFT, TIP, RADIUS, CLEARANCE = 0.22, 0.03, 0.8e-3, 1.2e-3
#: Amplitude and length of a bend, metres, and number of bends.
SWING, BEND, BENDS = 8e-3, 36e-3, 5
#: Seconds that the motion takes, and friction.
TIME, FRICTION = 5.0, 0.1


def centre_line() -> np.ndarray:
    """Points of a straight sheath along x, and of the vessel behind it, whose bends turn about x."""
    sheath = np.linspace(-SHAFT - TIP - 0.01, 0.0, 8, endpoint=False)
    x = np.linspace(0.0, BENDS * BEND, 10 * BENDS + 1)
    phase = np.pi * x / BEND
    growth = np.minimum(x / BEND, 1.0) ** 2 * (3.0 - 2.0 * np.minimum(x / BEND, 1.0))
    side = SWING * growth * np.sin(phase)
    turn = 0.3 * np.pi * x / (BENDS * BEND)
    vessel = np.column_stack([x, side * np.cos(turn), side * np.sin(turn)])
    return np.vstack([np.column_stack([sheath, 0 * sheath, 0 * sheath]), vessel])


def catheter() -> lissom.Robot:
    """The catheter in the sheath, fed by the motion of its base."""
    modes = {"bend_y": 3, "bend_z": 3, "torsion": 1}
    material = {"poisson_ratio": 0.4, "density": 1500.0, "retardation_time": 0.02}
    shaft = lissom.Segment(SHAFT / 6, RADIUS, young_modulus=2e9, modes=modes, **material)
    tip = lissom.Segment(TIP, RADIUS, young_modulus=2e8, modes=modes, **material)
    fed = ([0.0, TIME], [0.0, BENDS * BEND])
    base = lissom.Prismatic((1, 0, 0), motion=(*fed, "monotone"))
    wire = lissom.Link("wire", rod=[shaft] * 6 + [tip], joint=base, position=(-SHAFT - TIP, 0, 0))
    vessel = lissom.Tube(centre_line(), RADIUS + CLEARANCE, wall=2e-3)
    wall = lissom.Contact("wire", vessel, stiffness=2e6, friction=FRICTION, slip_velocity=1e-3)
    return lissom.Robot([wire], contacts=[wall], gravity=(0, 0, 0))


def main() -> None:
    """Print how hard the base is pushed, and how deep the wall is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dt", type=float, default=5e-3)
    parser.add_argument("--quasi-static", action="store_true", help="leave inertia out")
    parser.add_argument("--plot", help="picture of the catheter in the vessel")
    parser.add_argument("--report", help="page with the motion")
    options = parser.parse_args()
    robot = catheter()
    method = "quasi_static" if options.quasi_static else "newmark"
    motion = lissom.simulate(robot, TIME, dt=options.dt, method=method)
    print(motion.message)
    if not motion.success:
        raise SystemExit(1)
    print("fed [mm]  push [N]  pressed with [N]")
    for t in np.linspace(0.0, TIME, 11):
        k = int(np.argmin(np.abs(motion.t - t)))
        q, v = motion.q[k], motion.v[k]
        touches = robot.touches(q, v, t=motion.t[k])
        push = -sum(touch.force[0] for touch in touches)
        pressed = sum(abs(touch.force @ touch.normal) for touch in touches)
        place = robot.pose(q, 0.0, link="wire", t=motion.t[k])[0, 3] + SHAFT + TIP
        print(f"{1e3 * place:8.1f}  {push:8.3f}  {pressed:8.3f}")
    print(f"deepest overlap: {motion.deepest}")
    if options.plot:
        motion.picture(options.plot, times=[0.0, 0.5 * TIME, TIME])
    if options.report:
        motion.report(options.report)


if __name__ == "__main__":
    main()
