"""How well does a model of a real tendon robot say where its tip is?

Three segments on one wire, nine tendons that servos displace, the tip by motion capture
(examples/data/tendon-robot). Least squares finds what the drawings do not say (where the tendons are, how
they stretch, how tight they were, how much friction there is) on one part of the recording; the error is that
on the other. `docs/tendon_robot.md` has the figures; `--plot paths.png` draws them, `--all` compares models
with and without friction and elongation.
"""

import argparse
import csv
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import lissom

DATA = Path(__file__).parents[1] / "data"
SEGMENT = np.repeat([0, 1, 2], 3)  # in which every tendon ends
RADIUS, POISSON_RATIO, MASS = 0.5e-3, 0.3, 0.05  # of the wire; kilograms: docs/tendon_robot.md on weight
UP = (0.5**0.5, 0.0, -(0.5**0.5), 0.0)  # takes the wire's x axis to the z axis of the motion capture
ERROR = 3e-3  # metres that a tip is off by in one direction: what residuals are weighed against
STILL = 5e-5  # metres: servos that moved less from a row to the next did not change direction


@dataclass(frozen=True)
class Drawn:
    """What the source says of a robot: folder of its data, lengths of segments, Young's modulus, stiffness of
    its tendons times their length; in metres, pascals, newtons."""

    folder: str
    lengths: tuple[float, float, float]
    young: float
    tendon: float

    @property
    def reach(self) -> np.ndarray:
        """Of every tendon, metres."""
        return np.cumsum(self.lengths)[SEGMENT]

    @property
    def stretch(self) -> float:
        """Stiffness of the wire, newtons."""
        return self.young * np.pi * RADIUS**2


ROBOTS = {
    "v4": Drawn("tendon-robot", (0.06, 0.0625, 0.064), 50e9, 7000.0),
    "v6": Drawn("tendon-robot-v6", (0.1, 0.1, 0.022), 10e9, 3000.0),
}


@dataclass(frozen=True)
class Unknown:
    """What is sought: from where on, and how far from there it may be expected (one standard deviation)."""

    name: str
    start: tuple[float, ...]
    spread: float
    unit: str


UNKNOWNS = (
    Unknown(
        "angle", (0.0,) * 9, 0.1, "rad"
    ),  # of the tendons around the wire, from where their pulls show them
    Unknown("distance", (4.5e-3,) * 3, 0.3e-3, "m"),  # of the tendons from the wire
    Unknown("offset", (0.0,) * 9, 0.3e-3, "m"),  # of the servos
    Unknown("pretension", (1.0,) * 3, 1.0, "N"),
    Unknown("curvature", (0.0,) * 6, 1.0, "1/m"),  # of the wire at rest, about y and z of every segment
    Unknown("stiffening", (0.0,) * 2, 0.3, ""),  # logarithm of outer segments' stiffness over the first one's
    Unknown("turn", (0.0,) * 3, 0.2, "rad"),  # of the robot in the motion capture, a rotation vector
    Unknown("tendon", (0.0,), 1.0, "log N"),  # stiffness times length, over a tenth of the source's
    Unknown("stretch", (0.0,), 1.5, "log N"),  # of the wire, over that of the drawings
    Unknown("friction", (0.2,), 0.2, ""),  # coefficient along the tendons
    Unknown("drag", (0.0,), 0.2e-3, "m"),  # what friction in the base takes of a displacement
)
#: What a model without it has instead: tendons as stiff as in the source of the data, no friction.
WITHOUT = {
    "elongation": {"tendon": (np.log(10.0),), "stretch": (0.0,)},
    "friction": {"friction": (0.0,), "drag": (0.0,)},
}


@dataclass(frozen=True)
class Recording:
    """Displacements of the tendons, directions in which they moved last (m, 9), the tip (m, 3), metres."""

    pulled: np.ndarray
    sliding: np.ndarray
    tip: np.ndarray
    pattern: np.ndarray

    def __getitem__(self, rows) -> "Recording":
        return Recording(self.pulled[rows], self.sliding[rows], self.tip[rows], self.pattern[rows])

    def __len__(self) -> int:
        return len(self.tip)


def recordings(drawn=ROBOTS["v4"]) -> tuple[Recording, Recording]:
    """For identification, and for validation."""
    rows, sizes = [], []
    for name in ("train", "val"):
        with (DATA / drawn.folder / f"{name}.csv").open(encoding="utf-8") as file:
            rows += list(csv.reader(file))[1:]
        sizes.append(len(rows) - sum(sizes))
    values = 1e-3 * np.array([row[2:] for row in rows], float)
    pulled, sliding = values[:, :9], np.zeros((len(rows), 9))
    for i in range(1, len(rows)):
        change = pulled[i] - pulled[i - 1]
        sliding[i] = np.where(np.abs(change) > STILL, np.sign(change), sliding[i - 1])
    both = Recording(pulled, sliding, values[:, 9:], np.array([row[1] for row in rows]))
    return both[: sizes[0]], both[sizes[0] :]


class Model:
    """A robot as a function of the unknowns; `fixed` holds those that are not sought."""

    def __init__(self, angles, fixed=None, drawn=ROBOTS["v4"]):
        self.angles = angles
        self.drawn = drawn
        self.fixed = {} if fixed is None else fixed
        self.sought = [unknown for unknown in UNKNOWNS if unknown.name not in self.fixed]
        self.start = np.concatenate([unknown.start for unknown in self.sought])
        self.spread = np.concatenate([np.full(len(each.start), each.spread) for each in self.sought])

    def named(self, x) -> dict[str, np.ndarray]:
        """All unknowns by name."""
        ends = np.cumsum([len(unknown.start) for unknown in self.sought])[:-1]
        parts = np.split(np.asarray(x), ends)
        found = {unknown.name: part for unknown, part in zip(self.sought, parts, strict=True)}
        return found | {name: np.asarray(value) for name, value in self.fixed.items()}

    def tendon(self, x) -> float:
        """Stiffness of the tendons times their length, newtons."""
        return 0.1 * self.drawn.tendon * float(np.exp(self.named(x)["tendon"][0]))

    def robot(self, x) -> lissom.Robot:
        """Inputs are the lengths of the tendons, each followed by the direction in which it slides."""
        p = self.named(x)
        bending = self.drawn.young * np.pi * RADIUS**4 / 4 * np.exp([0.0, *p["stiffening"]])
        stretch = self.drawn.stretch * float(np.exp(p["stretch"][0]))
        shear = stretch / (2 * (1 + POISSON_RATIO))
        lengths = self.drawn.lengths
        mass = MASS / sum(lengths)
        segments = [
            lissom.Segment(
                length,
                section=lissom.Section.given(
                    (EI / (1 + POISSON_RATIO), EI, EI, stretch, shear, shear), mass, (1e-9, 5e-10, 5e-10)
                ),
                modes={"bend_y": 2, "bend_z": 2, "stretch": 1},
                reference_strain=(0, *curvature, 1, 0, 0),
            )
            for length, EI, curvature in zip(
                self.drawn.lengths, bending, p["curvature"].reshape(3, 2), strict=True
            )
        ]
        tendons = [self._tendon(x, i) for i in range(9)]
        wire = lissom.Link("wire", rod=segments, orientation=UP)
        return lissom.Robot([wire], actuators=tendons, gravity=(0, 0, 0))

    def _tendon(self, x, i) -> lissom.Tendon:
        p, reach = self.named(x), self.drawn.reach
        angle, distance = self.angles[i] + p["angle"][i], p["distance"][SEGMENT[i]]
        place = (distance * np.cos(angle), distance * np.sin(angle))
        return lissom.Tendon(
            f"tendon {i}",
            [lissom.Along("wire", place, (0.0, reach[i]))],
            length=lissom.Input(f"length {i}", reach[i]),
            stiffness=self.tendon(x) / reach[i],
            friction=abs(p["friction"][0]),  # the search may try negative ones
            sliding=lissom.Input(f"sliding {i}"),
        )

    def inputs(self, x, recording) -> np.ndarray:
        """u of every row, (m, 18)."""
        p, reach = self.named(x), self.drawn.reach
        tightened = p["pretension"][SEGMENT] * reach / self.tendon(x)
        pulled = recording.pulled + p["offset"] - p["drag"] * recording.sliding
        u = np.empty((len(recording), 18))
        u[:, 0::2], u[:, 1::2] = reach - tightened - pulled, recording.sliding
        return u

    def tips(self, x, robot, q) -> np.ndarray:
        """(m, 3)."""
        turn = Rotation.from_rotvec(self.named(x)["turn"])
        return turn.apply(robot.pose(q, link="wire")[:, :3, 3])

    def expected(self, x) -> np.ndarray:
        """How far the unknowns are from where they were expected, in standard deviations."""
        return (x - self.start) / self.spread


def angles_of_pulls(recording) -> np.ndarray:
    """Where the tendons are around the wire: the tip moves to the side of the one that is pulled, (9,)."""
    angles = np.empty(9)
    for i in range(9):
        rows = recording[np.char.startswith(recording.pattern, f"rep1_tendon{i}_")]
        least, most = np.argmin(rows.pulled[3:, i]) + 3, np.argmax(rows.pulled[:, i])
        x, y, _ = rows.tip[most] - rows.tip[least]
        angles[i] = np.arctan2(-x, y)  # the wire's y and z axes are y and -x
    return angles


def equilibria(robot, u, q=None) -> np.ndarray:
    """Of every row, (m, n): each from the one before, or from those in `q`. RuntimeError if there is none."""
    shapes, shape = np.empty((len(u), robot.n)), None
    for i, row in enumerate(u):
        found = lissom.statics(robot, shape if q is None else q[i], u=row)
        if not found.success:  # tendons that hardly stretch, and which are slack where the search begins
            found = lissom.statics(robot, u=row)
        if not found.success:
            raise RuntimeError(f"row {i}: {found.message}")
        shapes[i] = shape = found.q
    return shapes


class Fit:
    """Residuals of a model on a recording, and their derivatives."""

    def __init__(self, model, recording):
        self.model, self.recording = model, recording
        self.q, self.robot = None, None

    def residuals(self, x) -> np.ndarray:
        self.robot = self.model.robot(x)
        self.q = equilibria(self.robot, self.model.inputs(x, self.recording), self.q)
        error = self._centred(self.model.tips(x, self.robot, self.q)) - self._centred(self.recording.tip)
        return np.concatenate([error.ravel() / ERROR, self.model.expected(x)])

    def jacobian(self, x) -> np.ndarray:
        """One Newton step from an equilibrium follows a small change of the unknowns exactly."""
        rest, u = np.zeros(self.robot.n), self.model.inputs(x, self.recording)
        stiffness = np.array(
            [self.robot.tangent(q, rest, rest, u=row)[0] for q, row in zip(self.q, u, strict=True)]
        )
        tips = self._centred(self.model.tips(x, self.robot, self.q))
        columns = []
        for k, spread in enumerate(self.model.spread):
            step = 1e-4 * spread
            ahead = x + step * np.eye(len(x))[k]
            robot, u = self.model.robot(ahead), self.model.inputs(ahead, self.recording)
            forces = [robot.inverse_dynamics(q, rest, rest, u=row) for q, row in zip(self.q, u, strict=True)]
            q = self.q - np.linalg.solve(stiffness, np.array(forces)[:, :, None])[:, :, 0]
            change = (self._centred(self.model.tips(ahead, robot, q)) - tips) / step
            columns.append(np.concatenate([change.ravel() / ERROR, np.eye(len(x))[k] / self.model.spread]))
        return np.column_stack(columns)

    @staticmethod
    def _centred(tips):
        return tips - tips.mean(axis=0)


def identify(model, recording) -> np.ndarray:
    """The unknowns that fit best."""
    fit = Fit(model, recording)
    found = least_squares(
        fit.residuals, model.start, fit.jacobian, x_scale=model.spread, xtol=1e-4, ftol=1e-4
    )
    return found.x


def error(model, x, recording) -> float:
    """Root of the mean square of the tip's distances, means aligned, metres."""
    robot = model.robot(x)
    tips = model.tips(x, robot, equilibria(robot, model.inputs(x, recording)))
    off = (tips - tips.mean(axis=0)) - (recording.tip - recording.tip.mean(axis=0))
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def repeatability(recording, near=2e-4, slack=-3e-3) -> float:
    """How far tips are off their mean where displacements agree, metres: what no map from these can mend."""
    told = np.maximum(recording.pulled, slack)
    squares = []
    for i in range(len(recording)):
        rows = np.arange(i + 4, len(recording))  # not those just behind
        same = rows[np.linalg.norm(told[rows] - told[i], axis=1) < near]
        squares += np.sum((recording.tip[same] - recording.tip[i]) ** 2, axis=1).tolist()
    return float(np.sqrt(np.mean(squares) / 2))


def main() -> None:
    """Identify on every third row, and say how far the tips are off on all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", action="store_true", help="also without friction, without elongation")
    parser.add_argument("--robot", choices=ROBOTS, default="v4")
    parser.add_argument("--plot", help="picture of the paths of the tip")
    arguments = parser.parse_args()
    drawn = ROBOTS[arguments.robot]
    training, validation = recordings(drawn)
    angles = angles_of_pulls(training)
    print("tendons at", *np.rad2deg(angles).round().astype(int), "degrees around the wire")
    print(f"rows of the same displacements differ by {repeatability(training) * 1e3:.1f} mm")
    variants = [("friction", "elongation")]
    if arguments.all:
        variants = [(), ("friction",), ("elongation",), *variants]
    print("with                      training  validation")
    for variant in variants:
        left_out = [values for name, values in WITHOUT.items() if name not in variant]
        fixed = {name: value for values in left_out for name, value in values.items()}
        model = Model(angles, fixed, drawn)
        try:
            x = identify(model, training[::3])
        except RuntimeError as failure:  # tendons that hardly stretch ask for shapes that there are not
            print(f"{' and '.join(variant) or 'neither':24} {failure}")
            continue
        errors = [error(model, x, recording) * 1e3 for recording in (training, validation)]
        print(f"{' and '.join(variant) or 'neither':24} {errors[0]:6.2f} mm  {errors[1]:7.2f} mm")
    named = model.named(x)
    for unknown in UNKNOWNS:
        print(f"{unknown.name:11} {unknown.unit:6}", *(f"{each:10.3g}" for each in named[unknown.name]))
    robot = model.robot(x)
    u = [model.inputs(x, recording) for recording in (training, validation)]
    start = time.process_time()
    shapes = [equilibria(robot, each) for each in u]
    duration = time.process_time() - start
    print(
        f"{sum(map(len, shapes))} equilibria of {robot.n} coordinates in {duration:.2f} s of processor time"
    )
    if arguments.plot:
        tips = [model.tips(x, robot, q) for q in shapes]
        draw(arguments.plot, validation, tips[1] - tips[0].mean(axis=0) + training.tip.mean(axis=0))


def draw(path, recording, tips) -> None:
    """The paths of the tip from above, recorded and computed, one picture a kind of pattern."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    kinds = {"same": "all bend alike", "scurve": "S curves", "spiral": "spirals"}
    figure, axes = pyplot.subplots(1, 3, figsize=(12, 4.8), sharex=True, sharey=True, layout="constrained")
    for axis, (kind, title) in zip(axes, kinds.items(), strict=True):
        patterns = dict.fromkeys(name.removesuffix("_hold") for name in recording.pattern if kind in name)
        for i, pattern in enumerate(patterns):
            rows = np.char.startswith(recording.pattern, pattern)
            axis.plot(*1e3 * recording.tip[rows, :2].T, ".", color=f"C{i}", markersize=4)
            axis.plot(*1e3 * tips[rows, :2].T, "-", color=f"C{i}", linewidth=1)
        axis.set(title=title, xlabel="x [mm]", aspect="equal")
    axes[0].set_ylabel("y [mm]")
    figure.suptitle("Tip in validation: recorded (dots), computed (lines)")
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main()
