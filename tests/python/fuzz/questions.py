"""What is asked of a robot: properties that hold whatever it is, judged without lissom's formulas.

Each question takes a `Robot` and returns what is wrong, as text whose numbers do not matter, or None; it
raises `Undecided` if nothing can be said.
"""

import pickle
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import lissom
from fuzz import rendered, transforms
from fuzz.balances import Points

#: Forces that nothing balances, relative to all: of bodies; of rods, whose nodes do not resolve everything;
#: and of rods on floors, where contact ends between the points of `balances`.
BODIES, RODS, FLOORS = 1e-5, 1e-4, 5e-3
#: Gaps of loops relative to the robot.
OPEN = 1e-8
#: Relative differences of numbers that differ in rounding only, and of two runs with tight tolerances.
ROUNDING, RUNS = 1e-7, 1e-5
#: Resistance to a motion relative to its parts: above the first it is one, below the second it is none.
SOME, NONE = 1e-6, 1e-8
#: Duration of runs, seconds, and how much of the random states they start with.
DURATION, START = 0.05, 0.2


class Undecided(Exception):
    """Nothing can be said."""


@dataclass
class Robot:
    """A robot, the question's words, and what is computed once."""

    recipe: dict
    question: dict

    @cached_property
    def model(self) -> lissom.Robot:
        return rendered.by_api(self.recipe)

    @cached_property
    def state(self):
        return rendered.state(self.recipe, self.model)

    @cached_property
    def points(self) -> Points:
        return Points(self.recipe, self.model)

    @property
    def tolerance(self) -> float:
        rods = any("rod" in link for link in self.recipe["link"])
        on_floor = any(isinstance(contact["a"], str) for contact in self.recipe.get("contact", ()))
        return FLOORS if on_floor else RODS if rods else BODIES

    def statics(self, model=None, recipe=None):
        """The equilibrium that the question asks for; and its status, "refused" if it was not looked for."""
        model, recipe = model or self.model, recipe or self.recipe
        method = self.question.get("method", "auto")
        start = rendered.state(recipe, model)[0] if self.question.get("start") else None
        try:
            found = lissom.statics(model, start, method=method, space_error=False)
        except ValueError as error:
            return None, f"refused: {error}"
        return (found if found.success else None), found.status

    @cached_property
    def equilibrium(self):
        found, status = self.statics()
        if found is None:
            raise Undecided(status)
        return found

    @cached_property
    def is_conservative(self) -> bool:
        return not any(
            load.get("frame") == "body" or load.get("moment")
            for link in self.recipe["link"]
            for load in link.get("load", ())
        )


def _far(one, other, size, tolerance) -> float:
    """The largest difference in units of the size, where it is more than the tolerance; or zero."""
    one, other = np.asarray(one, float), np.asarray(other, float)
    off = np.abs(one - other) / np.maximum(size, 1e-300)
    worst = float(off.max(initial=0.0)) if np.isfinite(off).all() else np.inf
    return worst if worst > tolerance else 0.0


# Equilibria.


def balance(robot: Robot) -> str | None:
    """A success of `statics` is in equilibrium: nothing is left of the forces, and loops are closed."""
    found = robot.equilibrium
    rest = robot.points.balance(found.q)
    if rest.error > robot.tolerance:
        return f"out of balance by {rest.error:.2g} of the forces"
    if rest.open > OPEN * np.abs(rest.P).max():
        return f"a loop is open by {rest.open:.2g} m"
    return None


def verdict(robot: Robot) -> str | None:
    """Stability is that of the energy: whether it grows in the direction in which it grows least."""
    found, status = robot.statics()
    q = found.q if found else robot.state[0]
    rest = robot.points.balance(q)
    if not robot.is_conservative or rest.error > robot.tolerance or rest.open > OPEN * np.abs(rest.P).max():
        raise Undecided(f"no equilibrium, or no energy: {status}")
    right = _verdict(rest, robot.tolerance)
    said = {"statics": found.stability} if found else {}
    for who, word in (said | {"modes": lissom.modes(robot.model, q).stability}).items():
        if word != right:
            return f"{who} says {word} where it is {right}"
    return None


def _verdict(rest, tolerance) -> str:
    sided = np.array(rest.points.springs.one_sided, bool)
    s = rest.points.all_springs(rest.q[None], rest.P[None])[0]
    if np.any(sided & (np.abs(s) < 1e-12 * np.abs(rest.P).max(initial=1e-3)) & (rest.pulls == 0)):
        raise Undecided("surfaces that only just touch")
    values, motions = rest.eigenpairs()
    if not len(values):
        return "stable"
    parts = np.array([rest.resistance(motion) for motion in motions.T[:6]])
    ratios = parts[:, 0] / np.maximum(parts[:, 1], 1e-300)
    # Rods are integrated at other points than lissom's.
    some = max(SOME, 0.1 * tolerance if tolerance > BODIES else 0.0)
    if np.any(ratios < -some):
        return "divergence"
    if np.any(np.abs(ratios) < NONE):
        return "neutral"
    if np.all(ratios > some):
        return "stable"
    raise Undecided(f"resistance {ratios.min():.2g} of its parts")


def frequencies(robot: Robot) -> str | None:
    """Frequencies are those of the stiffness and the inertia of points."""
    found = robot.equilibrium
    rest = robot.points.balance(found.q)
    if not robot.is_conservative or rest.error > robot.tolerance:
        raise Undecided("no equilibrium, or no energy")
    if _verdict(rest, robot.tolerance) == "divergence":
        raise Undecided("unstable")
    values, motions = rest.eigenpairs()
    got = np.sort(lissom.modes(robot.model, found.q).angular_frequency)
    right = np.sqrt(np.maximum(values, 0.0))
    if len(got) != len(right):
        return f"{len(got)} frequencies instead of {len(right)}"
    parts = np.array([rest.resistance(motion) for motion in motions.T])
    sure = parts[:, 0] > 1e-4 * parts[:, 1]
    off = np.abs(got / np.maximum(right, 1e-300) - 1)[sure].max(initial=0.0)
    return f"frequencies off by {off:.2g}" if off > 10 * robot.tolerance else None


def reached(robot: Robot) -> str | None:
    """`statics` finds an equilibrium: every robot here has one, because its energy has a lower bound."""
    found, status = robot.statics()
    return None if found else f"finds none: {status}"


# The same robot in other words.

#: Kinds of changes and the changes of each kind. Faults of one kind are one fault.
CHANGES: dict[str, dict[str, Callable]] = {
    "axes": {
        "turned": lambda recipe, rng: transforms.moved(
            recipe, Rotation.random(random_state=rng), np.zeros(3)
        ),
        "shifted": lambda recipe, rng: transforms.moved(recipe, Rotation.identity(), rng.uniform(-2, 2, 3)),
    },
    "units": {
        "in millimetres": lambda recipe, rng: transforms.units(recipe, 1e3, 1.0, 1.0),
        "in kilometres": lambda recipe, rng: transforms.units(recipe, 1e-3, 1.0, 1.0),
        "in grams": lambda recipe, rng: transforms.units(recipe, 1.0, 1e3, 1.0),
        "in tonnes": lambda recipe, rng: transforms.units(recipe, 1.0, 1e-3, 1.0),
        "in milliseconds": lambda recipe, rng: transforms.units(recipe, 1.0, 1.0, 1e3),
        "in powers of two": lambda recipe, rng: transforms.units(recipe, *(2.0 ** rng.integers(-10, 11, 3))),
    },
    "names": {
        "renamed": lambda recipe, rng: transforms.renamed(recipe),
        "reordered": transforms.reordered,
    },
    "others": {
        "beside a rod": transforms.beside_a_rod,
        "beside a body": lambda recipe, rng: transforms.beside_a_body(recipe),
    },
    "floor": {"with a far floor": lambda recipe, rng: transforms.with_a_far_floor(recipe)},
}
#: Changes that leave equilibria alone, and nothing else.
IDLE: dict[str, dict[str, Callable]] = {
    "idle": {
        "with more inertia": lambda recipe, rng: transforms.idle(recipe, 1e6),
        "with less inertia": lambda recipe, rng: transforms.idle(recipe, 1e-6),
    },
}


def _changed(robot: Robot) -> transforms.Changed:
    kind, change = robot.question["change"]
    rng = np.random.default_rng(robot.question["seed"])
    return (CHANGES | IDLE)[kind][change](robot.recipe, rng)


def same_forces(robot: Robot) -> str | None:
    """Forces, inertia, tangents and energies do not depend on units, axes, names and unrelated parts."""
    changed = _changed(robot)
    model, other = robot.model, rendered.by_api(changed.recipe)
    q, v = robot.state
    place, scale = changed.place, changed.scale

    def there(x, rate):
        found = np.zeros(other.n)
        found[place] = x * scale / changed.time**rate
        return found

    a = v[::-1] * np.abs(v).max(initial=1.0)
    q2, v2, a2 = there(q, 0), there(v, 1), there(a, 2)
    force, mass = changed.energy / scale, changed.mass * changed.length**2 / np.outer(scale, scale)
    K, M = model.tangent(q, v, a)[0], model.mass_matrix(q)
    size = np.abs(K) @ np.abs(q) + np.abs(M) @ np.abs(a) + np.abs(model.inverse_dynamics(q, 0 * v, 0 * a))
    size = size + 1e-9 * size.max(initial=0.0) + 1e-12
    tau = other.inverse_dynamics(q2, v2, a2)[place] / force
    if off := _far(tau, model.inverse_dynamics(q, v, a), size, ROUNDING):
        return f"forces off by {off:.2g}"
    if off := _far(other.mass_matrix(q2)[np.ix_(place, place)] / mass, M, _sizes(M), ROUNDING):
        return f"inertia off by {off:.2g}"
    stiff = np.abs(K) + size[:, None] / np.maximum(np.abs(q), 1e-3)
    tangent = other.tangent(q2, v2, a2)[0][np.ix_(place, place)] * np.outer(scale, scale) / changed.energy
    if off := _far(tangent, K, stiff, 10 * ROUNDING):
        return f"tangent off by {off:.2g}"
    kinetic = [model.energy(q, v).kinetic, other.energy(q2, v2).kinetic / changed.energy]
    if off := _far(kinetic[1], kinetic[0], abs(kinetic[0]), ROUNDING):
        return f"kinetic energy off by {off:.2g}"
    return None


def same_equilibrium(robot: Robot) -> str | None:
    """Success of `statics` and stability do not depend on units, axes, names and unrelated parts."""
    changed = _changed(robot)
    other = rendered.by_api(changed.recipe)
    (found, status), (beside, other_status) = robot.statics(), robot.statics(other, changed.recipe)
    if (found is None) != (beside is None):
        if robot.question.get("method") in ("newton", "load_path"):
            raise Undecided("rounding decides where a search without a guard ends")
        return f"found in one of two: {status}, {other_status} {robot.question['change'][1]}"
    if found is None:
        raise Undecided(status)
    there, here = Points(changed.recipe, other).balance(beside.q), robot.points.balance(found.q)
    if (there.error > robot.tolerance) != (here.error > robot.tolerance):
        return f"out of balance in one of two: by {here.error:.2g} and {there.error:.2g} of the forces"
    P = robot.points.positions(beside.q[changed.place] / changed.scale)[0]
    if np.abs(P - here.P).max(initial=0.0) > 1e-3 * np.abs(here.P).max(initial=1e-3):
        raise Undecided("another equilibrium")
    if found.stability != beside.stability:
        return f"{found.stability}, and {beside.stability} {robot.question['change'][1]}"
    return None


def saved(robot: Robot) -> str | None:
    """Scenes, pickles and saved results are the same robot and the same result."""
    model, (q, v) = robot.model, robot.state
    right = model.inverse_dynamics(q, v, 0 * v)
    scene = rendered.by_scene(robot.recipe)
    for how, copy in {"scene": scene, "pickle": pickle.loads(pickle.dumps(model))}.items():
        if not np.array_equal(copy.inverse_dynamics(q, v, 0 * v), right):
            return f"another robot from a {how}"
    found = robot.equilibrium
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "equilibrium.nc"
        found.save(path, model)
        if not np.array_equal(lissom.load(path).q, found.q):
            return "another result from a file"
    if not np.array_equal(robot.statics(scene)[0].q, found.q):
        return "another equilibrium of the scene"
    return None


# Forces of given states.


def _sizes(matrix) -> np.ndarray:
    """Sizes of the entries of an inertia matrix: geometric means of its diagonal."""
    return np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))


def _newton(robot: Robot, a: np.ndarray):
    """Generalised forces of a motion by Newton's second law of all points, and the sizes of their parts."""
    points, (q, v) = robot.points, robot.state
    dP, ds, _ = points.differences(q, turned=False)
    P, _, accelerations = points.motion(q, v, a)
    pulls = points.spring_forces(points.all_springs(q[None], P[None])[0])
    if any(contact.get("dissipation", 1.0) for contact in robot.recipe.get("contact", ())) and np.any(
        (pulls != 0) & np.array(points.springs.one_sided, bool)
    ):
        raise Undecided("dissipation where surfaces touch")
    forces = points.forces(P)
    inertia = np.zeros_like(P)
    for number, mass in points.masses:
        inertia[number] = mass * accelerations[number]
    tau = np.einsum("inc,nc->i", dP, inertia - forces) + ds @ pulls
    size = np.linalg.norm(dP, axis=-1) @ np.linalg.norm(np.abs(inertia) + np.abs(forces), axis=-1)
    return tau, size + np.abs(ds) @ np.abs(pulls)


def _accelerations(robot: Robot) -> np.ndarray:
    return 0.5 * robot.state[1]


def forces(robot: Robot) -> str | None:
    """Inverse dynamics is Newton's second law of all points, and the inverse of forward dynamics."""
    model, (q, v), a = robot.model, robot.state, _accelerations(robot)
    tau, size = _newton(robot, a)
    size = size + 1e-6 * size.max(initial=0.0) + 1e-12
    if off := _far(model.inverse_dynamics(q, v, a), tau, size, robot.tolerance):
        return f"inverse dynamics off by {off:.2g} of the forces"
    if robot.recipe.get("loop"):
        return None
    # Forces of the accelerations that forward dynamics finds without forces.
    M = model.mass_matrix(q)
    conditioned = np.linalg.cond(M / _sizes(M)) if model.n else 1.0
    left = model.inverse_dynamics(q, v, model.forward_dynamics(q, v))
    if off := _far(left, 0 * left, size, ROUNDING * max(1.0, 1e-4 * conditioned)):
        return f"forward dynamics is not its inverse: {off:.2g} of the forces are left"
    return None


def inertia(robot: Robot) -> str | None:
    """Inertia, kinetic energy and momentum are those of all points."""
    model, points, (q, v) = robot.model, robot.points, robot.state
    dP, _, _ = points.differences(q, turned=False)
    P, speeds, _ = points.motion(q, v, 0 * v)
    numbers, masses = map(np.array, zip(*points.masses, strict=True))
    dP, P, speeds = dP[:, numbers], P[numbers], speeds[numbers]
    M = np.einsum("inc,jnc,n->ij", dP, dP, masses)
    if off := _far(model.mass_matrix(q), M, _sizes(M), robot.tolerance):
        return f"the mass matrix is off by {off:.2g}"
    momenta = masses[:, None] * speeds
    kinetic = float(np.sum(momenta * speeds) / 2)
    if off := _far(model.energy(q, v).kinetic, kinetic, kinetic, robot.tolerance):
        return f"the kinetic energy is off by {off:.2g}"
    expected = np.append(np.cross(P, momenta).sum(axis=0), momenta.sum(axis=0))
    size = np.linalg.norm(momenta, axis=1)
    sizes = np.repeat([size @ np.linalg.norm(P, axis=1), size.sum()], 3)
    if off := _far(model.momentum(q, v), expected, sizes, robot.tolerance):
        return f"the momentum is off by {off:.2g}"
    return None


def tangent(robot: Robot) -> str | None:
    """The tangent is what forces change by."""
    model, (q, v), a = robot.model, robot.state, _accelerations(robot)
    K, size = model.tangent(q, v, a)[0], _newton(robot, a)[1]
    for i, h in enumerate(1e-4 * robot.points.sizes):
        e = h * np.eye(model.n)[i]
        up, down, up2, down2 = (model.inverse_dynamics(q + f * e, v, a) for f in (1, -1, 2, -2))
        slope = (8 * (up - down) - (up2 - down2)) / (12 * h)
        if off := _far(K[:, i], slope, np.abs(slope) + size / robot.points.sizes[i], 1e-5):
            return f"the tangent is off by {off:.2g}"
    return None


def cut(robot: Robot) -> str | None:
    """The wrench inside a rod is what acts beyond the cut, contact and friction included."""
    rods = [link for link in robot.recipe["link"] if "rod" in link]
    if not rods or robot.recipe.get("loop"):
        raise Undecided("no rod, or forces of loops")
    rng = np.random.default_rng(robot.question["seed"])
    link = rods[int(rng.integers(len(rods)))]
    length = sum(part["length"] for part in link["rod"]["segment"])
    X = float(rng.choice([0.0, 0.13, 0.31, 0.77])) * length
    name, model, (q, v) = link["name"], robot.model, robot.state
    points = Points(robot.recipe, model, cut=(name, X))
    P, speeds, accelerations = points.motion(q, v, 0 * v)
    acting = points.forces(P) + points.cord_forces(P)
    for number, mass in points.masses:
        acting[number] -= mass * accelerations[number]
    places, pressed = points.contact_forces(P, speeds)
    beyond = points.beyond(name, X)
    touching = beyond[[numbers[0] for numbers, *_ in points.pressed]]
    here = model.pose(q, X, link=name)
    wrench, size = np.zeros((2, 3)), np.zeros(2)
    for place, force, on in ((P, acting, beyond), (places, pressed, touching)):
        arms, force = place[on] - here[:3, 3], force[on]
        wrench -= np.cross(arms, force).sum(axis=0), force.sum(axis=0)
        norms = np.linalg.norm(force, axis=1)
        size += np.linalg.norm(arms, axis=1) @ norms, norms.sum()
    got = model.internal_wrench(q, v, 0 * v, X, link=name)
    if off := _far(got, (wrench @ here[:3, :3]).ravel(), np.repeat(size, 3) + 1e-12, robot.tolerance):
        return f"off by {off:.2g} of the forces beyond the cut"
    return None


# Runs.


def runs(robot: Robot) -> str | None:
    """Undamped runs keep their energy, and methods with tight tolerances end at one place."""
    model, (q, v) = robot.model, robot.state
    q, v, end = START * q, START * v, DURATION
    tight = {"rtol": 1e-8, "atol": 1e-10, "t_eval": [0.0, end], "max_steps": 20_000}
    found = {
        method: lissom.simulate(model, end, q0=q, v0=v, method=method, **tight)
        for method in ("radau", "dop853")
    }
    if not all(each.success for each in found.values()):
        raise Undecided(
            "; ".join(f"{name}: {each.status}" for name, each in found.items() if not each.success)
        )
    places = {name: robot.points.positions(each.q[-1])[0] for name, each in found.items()}
    way = np.abs(places["radau"] - robot.points.positions(q)[0]).max(initial=0.0)
    if off := _far(places["radau"], places["dop853"], max(way, 1e-6), RUNS):
        return f"radau and dop853 apart by {off:.2g} of the way"
    if robot.recipe.get("contact"):
        return None
    for method, each in found.items():
        energies = [model.energy(each.q[i], each.v[i]) for i in (0, -1)]
        scale = max(abs(energies[1].kinetic), abs(energies[0].kinetic), abs(energies[1].elastic), 1e-9)
        if robot.is_conservative and (off := _far(energies[1].total, energies[0].total, scale, RUNS)):
            return f"{method} changes the energy by {off:.2g}"
    return None


QUESTIONS = {
    question.__name__: question
    for question in (
        *(balance, verdict, frequencies, reached, same_forces, same_equilibrium, saved),
        *(forces, inertia, tangent, cut, runs),
    )
}
