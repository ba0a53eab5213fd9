"""What the recording of a real tendon robot says about its wire and its tendons, by `lissom.fit`.

The robot is that of `tendon_robot.py`, without friction and with tendons of a given stiffness: its static
shapes under known displacements of nine tendons determine the moduli of the three segments, where the
tendons run, and where the robot stands. Needs SciPy; takes about 35 s of processor time.
"""

import argparse

import numpy as np
from tendon_robot import (
    POISSON_RATIO,
    RADIUS,
    ROBOTS,
    UP,
    Recording,
    angles_of_pulls,
    equilibria,
    recordings,
)

import lissom

DRAWN = ROBOTS["v4"]
REACH = DRAWN.reach
DISTANCE = 4.5e-3  # of the tendons from the wire, by the drawings, metres
PRETENSION = 1.0  # newtons
STIFFNESS = 700.0  # of the tendons, times their lengths, newtons


def robot(angles) -> lissom.Robot:
    """The robot as it is drawn; its inputs are the lengths of the tendons."""
    wire = [
        lissom.Segment(
            length,
            RADIUS,
            DRAWN.young,
            poisson_ratio=POISSON_RATIO,
            density=7800.0,
            modes={"bend_y": 2, "bend_z": 2},
        )
        for length in DRAWN.lengths
    ]
    tendons = [
        lissom.Tendon(
            f"tendon {i}",
            [lissom.Along("wire", (DISTANCE * np.cos(angle), DISTANCE * np.sin(angle)), (0.0, REACH[i]))],
            length=lissom.Input(f"length {i}", REACH[i]),
            stiffness=STIFFNESS / REACH[i],
        )
        for i, angle in enumerate(angles)
    ]
    return lissom.Robot([lissom.Link("wire", rod=wire, orientation=UP)], actuators=tendons, gravity=(0, 0, 0))


def lengths(recording: Recording) -> np.ndarray:
    """The inputs of every row."""
    return REACH * (1.0 - PRETENSION / STIFFNESS) - recording.pulled


def error(model: lissom.Robot, recording: Recording) -> float:
    """Root of the mean square of the tip's distances, metres."""
    shapes = equilibria(model, lengths(recording))
    off = model.pose(shapes, link="wire")[:, :3, 3] - recording.tip
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def main() -> None:
    """Fit, and say how far tips are off in both recordings."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=12, help="fit every so many rows")
    parser.add_argument("--runs", type=int, default=100, help="most evaluations of the model")
    parser.add_argument("--report", help="page with values, intervals, correlations and residuals")
    arguments = parser.parse_args()
    training, validation = recordings()
    drawn = robot(angles_of_pulls(training))
    sought = {f"link[0].rod.segment[{i}].young_modulus": (5e9, DRAWN.young, 2e11) for i in range(3)}
    for i, tendon in enumerate(drawn.actuators):
        for k, place in enumerate(tendon.path[0].offset):
            sought[f"actuators[{i}].path[0].offset[{k}]"] = (-0.01, place, 0.01)
    sought |= {f"link[0].position[{k}]": 0.0 for k in range(3)}
    rows = training[:: arguments.every]
    found = lissom.fit(drawn, lissom.StaticShapes(rows.tip, lengths(rows)), sought, max_runs=arguments.runs)
    for name, value, (low, high) in zip(found.names, found.values, found.intervals, strict=True):
        print(f"{name:40} {value:11.4g}   {low:11.4g} to {high:.4g}")
    print(f"{len(rows)} shapes, {found.runs} runs of all of them: {found.message}")
    print("tip, root mean square (mm)  training  validation")
    for name, model in (("as drawn", drawn), ("fitted", found.model)):
        errors = [1e3 * error(model, recording) for recording in (training, validation)]
        print(f"{name:27} {errors[0]:8.2f} {errors[1]:11.2f}")
    if arguments.report:
        found.report(arguments.report, title="Tendon robot")


if __name__ == "__main__":
    main()
