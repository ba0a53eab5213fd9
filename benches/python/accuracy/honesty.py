"""Reliability of `method="auto"`: random rods, motions and requests compared with references.

    python benches/python/accuracy/honesty.py [--count 300] [--seed 1] [--family NAME ...] [--worst 10]
        [--space]

Each case draws a rod, its excitation, a duration and a requested accuracy. The reference is a run with far
tighter tolerances; with --space, a rod with many modes. Prints a Markdown table with the numbers of
successful runs that satisfy the request and the claimed error, and the worst cases.
"""

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

import lissom

# Number of compared times.
TIMES = 400
# Tolerance of the reference relative to the request; and the tightest tolerance possible in double precision.
TIGHTER = 1e-4
TIGHTEST = 1e-12
# Smaller errors are not significant, because of the error of the reference.
ROUNDING = 1e-10
# Maximum number of steps of each run; longer runs fail, which counts as honest.
MAX_STEPS = 200_000
# Square of the first root of the clamped beam's frequency equation.
CLAMPED = 3.516


@dataclass(frozen=True)
class Case:
    """A rod in motion and the requested accuracy."""

    rod: lissom.Rod
    duration: float
    tolerance: float
    q0: np.ndarray | None = None
    v0: np.ndarray | None = None
    # Maximum step of the reference, so that it does not miss pulses given as functions.
    max_step: float = np.inf
    is_stiff: bool = False
    note: str = ""

    def run(self, **options):
        times = np.linspace(0.0, self.duration, TIMES + 1)
        return lissom.simulate(self.rod, self.duration, q0=self.q0, v0=self.v0, t_eval=times, **options)

    def truth(self):
        tolerance = max(TIGHTER * self.tolerance, TIGHTEST)
        limit = {} if np.isinf(self.max_step) else {"max_step": self.max_step}
        if self.is_stiff:
            return self.run(method="radau", rtol=1e-3 * self.tolerance, atol=1e-5 * self.tolerance, **limit)
        return self.run(method="dop853", rtol=tolerance, atol=1e-2 * tolerance, **limit)


def tips(rod, motion):
    """Positions of the tip relative to the length, shape (m, 3)."""
    return rod.pose(motion.q, [rod.length], t=motion.t)[:, 0, :3, 3] / rod.length


@dataclass
class Material:
    """A slender rod with a known first frequency."""

    rng: np.random.Generator
    stiff_strains: bool = False
    length: float = field(init=False)

    def __post_init__(self):
        rng = self.rng
        self.length = 10 ** rng.uniform(-1.3, 0.3)
        self.radius = self.length * 10 ** rng.uniform(-2.0 if self.stiff_strains else -3.0, -1.4)
        self.density = 10 ** rng.uniform(2.9, 3.95)
        # Deflection under its own weight relative to the length, a measure of softness: 1e-5 to 0.5.
        self.sag = 10 ** rng.uniform(-5.0, -0.3)
        self.young = 9.81 * self.density * self.length**3 / (2.0 * self.sag * self.radius**2)
        self.rate = CLAMPED * self.radius / 2.0 * np.sqrt(self.young / self.density) / self.length**2

    @property
    def period(self):
        return 2.0 * np.pi / self.rate

    @property
    def stiffness(self):
        """Stiffness of the tip against transverse forces, N/m."""
        return 3.0 * self.young * np.pi * self.radius**4 / 4.0 / self.length**3

    def rod(self, damping=0.0, **options):
        rng = self.rng
        modes = {"bend_y": int(rng.integers(1, 4))}
        if self.stiff_strains:
            modes |= {"stretch": 1, "shear_z": 1}
        segment = lissom.Segment(
            self.length,
            self.radius,
            self.young,
            self.young / 2.6,
            self.density,
            modes,
            # The amplitude of the first vibration decreases by the factor exp(-damping) per radian.
            retardation_time=2.0 * damping / self.rate,
            nodes=16,
        )
        return lissom.Rod([segment], **options)


def accuracy(rng):
    return float(rng.choice([1e-1, 1e-2, 1e-3, 1e-4, 1e-6]))


def weak(rng):
    """No damping, or weak damping."""
    return 0.0 if rng.random() < 0.4 else 10 ** rng.uniform(-6.0, -2.0)


def ringing(rng, stiff_strains=False):
    """Released under its weight, for 3 to 400 periods."""
    material = Material(rng, stiff_strains)
    periods = 10 ** rng.uniform(0.5, 2.6 if not stiff_strains else 0.8)
    note = f"{periods:.0f} periods"
    rod = material.rod(weak(rng))
    return Case(rod, periods * material.period, accuracy(rng), is_stiff=stiff_strains, note=note)


def resonance(rng):
    """Excited at or near its first frequency, at the base or at the tip."""
    material = Material(rng)
    frequency = (
        material.rate / (2.0 * np.pi) * rng.choice([1.0, rng.uniform(0.8, 1.2), rng.uniform(0.2, 5.0)])
    )
    periods = 10 ** rng.uniform(0.5, 1.7)
    size = 10 ** rng.uniform(-4.0, -1.5) * material.length / periods * 3
    weight = {} if rng.random() < 0.5 else {"gravity": (0.0, 0.0, 0.0)}
    if rng.random() < 0.5:
        shaken = lissom.BaseMotion(translation=lissom.Harmonic([0.0, 0.0, size], frequency))
        rod = material.rod(weak(rng), base_motion=shaken, **weight)
    else:
        force = lissom.Harmonic([0.0, 0.0, size * material.stiffness], frequency)
        rod = material.rod(weak(rng), loads=[lissom.Load(force=force)], **weight)
    return Case(rod, periods * material.period, accuracy(rng), note=f"{periods:.0f} periods")


def pulse(rng):
    """A load that starts suddenly at any time, permanent or temporary, as a table or a function."""
    material = Material(rng)
    periods = 10 ** rng.uniform(-0.5, 2.0)
    duration = periods * material.period
    size = 10 ** rng.uniform(-3.0, -0.5) * material.length * material.stiffness
    start = duration * rng.uniform(0.0, 0.95)
    width = max(material.period * 10 ** rng.uniform(-2.0, 1.0), 1e-2 * duration)
    kind = rng.choice(["step", "triangle", "function"])
    if kind == "step":
        rise = start + width * 10 ** rng.uniform(-6.0, -1.0)
        force = ([start, rise], [[0.0, 0.0, 0.0], [0.0, 0.0, size]])
    elif kind == "triangle":
        force = (
            [start, start + width / 2, start + width],
            [[0.0, 0.0, 0.0], [0.0, 0.0, size], [0.0, 0.0, 0.0]],
        )
    else:

        def force(t):
            x = (t - start) / width
            return [0.0, 0.0, size * np.sin(np.pi * x) ** 2 if 0 < x < 1 else 0.0]

    weight = {} if rng.random() < 0.3 else {"gravity": (0.0, 0.0, 0.0)}
    rod = material.rod(weak(rng), loads=[lissom.Load(force=force)], **weight)
    step = width / 10 if kind == "function" else np.inf
    return Case(rod, duration, accuracy(rng), max_step=step, note=f"{kind}, {periods:.1f} periods")


def impulse(rng):
    """Motion from initial velocities, as after an impact."""
    material = Material(rng)
    periods = 10 ** rng.uniform(-0.5, 1.7)
    rod = material.rod(weak(rng), gravity=(0.0, 0.0, 0.0))
    v0 = rng.normal(size=rod.n) * 10 ** rng.uniform(-3.0, 0.0) / material.length * material.rate
    return Case(rod, periods * material.period, accuracy(rng), v0=v0, note=f"{periods:.1f} periods")


FAMILIES: dict[str, Callable[[np.random.Generator], Case]] = {
    "ringing": ringing,
    "ringing, stiff strains": partial(ringing, stiff_strains=True),
    "resonance": resonance,
    "pulse": pulse,
    "impulse": impulse,
}


@dataclass(frozen=True)
class Verdict:
    """Result of a case; errors relative to the length."""

    family: str
    number: int
    case: Case
    status: str
    claimed: float
    true: float
    seconds: float
    steps: int
    method: str
    drift: float

    @property
    def success(self):
        return self.status == "finished"

    @property
    def missed(self):
        """True error over requested error."""
        return self.true / self.case.tolerance if self.true > ROUNDING else 0.0

    @property
    def hidden(self):
        """True error over claimed error."""
        return self.true / max(self.claimed, ROUNDING) if self.true > ROUNDING else 0.0

    def __str__(self):
        return (
            f"{self.family} #{self.number}: asked {self.case.tolerance:.0e}, claimed {self.claimed:.1e}, "
            f"true {self.true:.1e}, {self.status}, {self.method}, {self.steps} steps, "
            f"drift {self.drift:.0e}, n {self.case.rod.n}, {self.case.note}, {self.seconds:.2f} s"
        )


def judge(family, number, seed):
    """The verdict on a case, or None if the reference fails."""
    rng = np.random.default_rng([seed, list(FAMILIES).index(family), number])
    case = FAMILIES[family](rng)
    exact = case.truth()
    if not exact.success:
        return None
    began = time.perf_counter()
    found = case.run(method="auto", rtol=case.tolerance, max_steps=MAX_STEPS)
    seconds = time.perf_counter() - began
    true = np.nan
    if len(found.t) == len(exact.t):
        true = np.linalg.norm(tips(found.model, found) - tips(case.rod, exact), axis=1).max()
    claimed = found.stats.time_error
    method = "dop853" if "Method: dop853" in found.message else "radau"
    return Verdict(
        family,
        number,
        case,
        found.status,
        np.nan if claimed is None else claimed,
        true,
        seconds,
        found.stats.steps,
        method,
        found.balance.drift,
    )


def table(verdicts):
    yield (
        "| family | cases | success | beyond what was asked | beyond the claim | true / asked, worst "
        "| true / claimed, worst | claimed / true, median | time |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    groups = [[name, [v for v in verdicts if v.family == name]] for name in FAMILIES]
    for name, of_family in [*groups, ["all", verdicts]]:
        won = [v for v in of_family if v.success]
        if not won:
            continue
        missed, hidden = np.array([v.missed for v in won]), np.array([v.hidden for v in won])
        slack = np.median([v.claimed / v.true for v in won if v.true > ROUNDING] or [np.nan])
        yield (
            f"| {name} | {len(of_family)} | {len(won)} | {(missed > 1).sum()} | {(hidden > 1).sum()} "
            f"| {missed.max():.2g} | {hidden.max():.2g} | {slack:.2g} "
            f"| {sum(v.seconds for v in of_family):.0f} s |"
        )


@dataclass(frozen=True)
class Coarse:
    """A rod with few modes, the same rod with many, and the requested accuracy."""

    rod: lissom.Rod
    fine: lissom.Rod
    duration: float
    tolerance: float
    note: str = ""


# Numbers of modes of the reference, for strains that the coarse rod has or that matter.
TRUE_MODES = 16
TRUE_STRAINS = {"torsion": 6, "bend_y": TRUE_MODES, "bend_z": 8}


def coarse(rng, change, fine_modes=None, **options):
    """A rod that is hard to resolve because of `change`."""
    material = Material(rng)
    modes = {"bend_y": int(rng.integers(2, 6))}
    damping = 10 ** rng.uniform(-2.0, -0.5)
    keywords, of_rod, note = change(material)
    keywords = {
        "radius": material.radius,
        "young_modulus": material.young,
        "shear_modulus": material.young / 2.6,
        "density": material.density,
        "retardation_time": 2.0 * damping / material.rate,
        **keywords,
    }
    few, many = (
        lissom.Rod([lissom.Segment(material.length, modes=modes, **keywords)], **of_rod)
        for modes in (modes, fine_modes or {"bend_y": TRUE_MODES})
    )
    duration = material.period * rng.uniform(0.5, 2.0)
    return Coarse(few, many, duration, float(rng.choice([1e-2, 1e-3])), note)


def place(rng, length):
    """A random arc length, mostly near the base."""
    return length * 10 ** rng.uniform(-1.7, -0.05)


def kink(rng):
    def change(material):
        x = place(rng, material.length)
        size = material.radius * rng.uniform(0.4, 0.9)
        after = min(x * 1.01, 0.5 * (x + material.length))
        radius = ([0.0, x, after, material.length], [material.radius, material.radius, size, size])
        return {"radius": radius}, {}, f"kink at {x / material.length:.2f}"

    return coarse(rng, change)


def point_load(rng):
    def change(material):
        x = place(rng, material.length)
        size = (
            0.3
            * material.stiffness
            * material.length
            * min(10.0, (material.length / x) ** 2)
            * rng.uniform(0.1, 1)
        )
        load = lissom.Load(force=(0.0, 0.0, size), at=x)
        return {}, {"loads": [load]}, f"load at {x / material.length:.2f}"

    return coarse(rng, change)


def spring(rng):
    def change(material):
        x = place(rng, material.length)
        size = material.stiffness * (material.length / x) ** 3 * 10 ** rng.uniform(-1.0, 2.0)
        support = lissom.Support(stiffness=(0.0, 0.0, size), at=x)
        return {}, {"supports": [support]}, f"spring at {x / material.length:.2f}"

    return coarse(rng, change)


def offset(rng):
    def change(material):
        mass = material.density * np.pi * material.radius**2 * material.length * 10 ** rng.uniform(-1.5, 0.0)
        arm = material.length * 10 ** rng.uniform(-2.0, -0.5)
        body = lissom.Body(mass, centre=(0.0, arm, 0.0))
        return {}, {"bodies": [body]}, f"mass aside by {arm / material.length:.2f}"

    return coarse(rng, change, TRUE_STRAINS)


def plain(rng):
    return coarse(rng, lambda material: ({}, {}, "plain"))


SPACE_FAMILIES = {
    "plain": plain,
    "kink": kink,
    "point load": point_load,
    "spring": spring,
    "offset mass": offset,
}


@dataclass(frozen=True)
class SpaceVerdict:
    family: str
    number: int
    case: Coarse
    status: str
    claimed: float
    true: float
    time_error: float
    seconds: float
    nodes: tuple

    @property
    def hidden(self):
        return self.true / max(self.claimed, ROUNDING) if self.true > ROUNDING else 0.0

    @property
    def alarm(self):
        """Claimed error over true error, if only the true error satisfies the request; otherwise zero."""
        is_alarm = self.claimed > self.case.tolerance > self.true
        return self.claimed / max(self.true, ROUNDING) if is_alarm else 0.0

    def __str__(self):
        return (
            f"{self.family} #{self.number}: asked {self.case.tolerance:.0e}, space error {self.claimed:.1e}, "
            f"true {self.true:.1e}, time error {self.time_error:.0e}, {self.status}, n {self.case.rod.n}, "
            f"nodes {self.case.rod.nodes} to {self.nodes}, {self.case.note}, {self.seconds:.2f} s"
        )


def judge_space(family, number, seed):
    rng = np.random.default_rng([seed, 100 + list(SPACE_FAMILIES).index(family), number])
    case = SPACE_FAMILIES[family](rng)
    times = np.linspace(0.0, case.duration, 101)
    exact = lissom.simulate(case.fine, case.duration, method="radau", rtol=1e-5, atol=1e-6, t_eval=times)
    if not exact.success:
        return None
    began = time.perf_counter()
    found = lissom.simulate(case.rod, case.duration, method="auto", rtol=case.tolerance, t_eval=times)
    seconds = time.perf_counter() - began
    if len(found.t) < len(times):
        return None
    true = np.linalg.norm(tips(found.model, found) - tips(case.fine, exact), axis=1).max()
    # The time error is not an error of the modes.
    true = max(true - (found.stats.time_error or 0.0), 0.0)
    claimed = np.nan if found.stats.space_error is None else found.stats.space_error
    return SpaceVerdict(
        family,
        number,
        case,
        found.status,
        claimed,
        true,
        found.stats.time_error or np.nan,
        seconds,
        found.model.nodes,
    )


def space_table(verdicts):
    yield (
        "| family | cases | unknown | beyond the claim | by more than 3 | true / claimed, worst "
        "| claimed / true, median | false alarms | time |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, of_family in [
        *((name, [v for v in verdicts if v.family == name]) for name in SPACE_FAMILIES),
        ("all", verdicts),
    ]:
        known = [v for v in of_family if not np.isnan(v.claimed)]
        if not known:
            continue
        hidden = np.array([v.hidden for v in known])
        slack = np.median([v.claimed / v.true for v in known if v.true > ROUNDING] or [np.nan])
        alarms = sum(v.alarm > 0 for v in known)
        yield (
            f"| {name} | {len(of_family)} | {len(of_family) - len(known)} | {(hidden > 1).sum()} "
            f"| {(hidden > 3).sum()} | {hidden.max():.2g} | {slack:.2g} | {alarms} "
            f"| {sum(v.seconds for v in of_family):.0f} s |"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--worst", type=int, default=10)
    parser.add_argument(
        "--space", action="store_true", help="the error by few modes instead of that of the steps"
    )
    parser.add_argument("--family", nargs="*", choices=[*FAMILIES, *SPACE_FAMILIES])
    parser.add_argument("--number", type=int, help="only this case of the families")
    parser.add_argument("--verbose", action="store_true", help="every case, as it comes")
    options = parser.parse_args()
    families = options.family or list(SPACE_FAMILIES if options.space else FAMILIES)
    judged = judge_space if options.space else judge
    numbers = range(options.count) if options.number is None else [options.number]
    verdicts = []
    for number in numbers:
        for family in families if options.number is not None else [families[number % len(families)]]:
            verdict = judged(family, number, options.seed)
            if verdict is None:
                print(f"{family} #{number}: no truth", file=sys.stderr)
                continue
            verdicts.append(verdict)
            if options.verbose:
                print(verdict, file=sys.stderr, flush=True)
    if options.space:
        print("\n".join(space_table(verdicts)))
        print("\nWorst:\n")
        for verdict in sorted(verdicts, key=lambda v: -v.hidden)[: options.worst]:
            print("-", verdict)
        print("\nFalse alarms:\n")
        for verdict in [v for v in verdicts if v.alarm][: options.worst]:
            print("-", verdict)
        return
    print("\n".join(table(verdicts)))
    won = [v for v in verdicts if v.success]
    for name, key in (
        ("asked", lambda v: v.missed),
        ("claimed", lambda v: v.hidden),
        ("seconds", lambda v: v.seconds),
    ):
        print(f"\nWorst, {name}:\n")
        for verdict in sorted(won, key=key, reverse=True)[: options.worst]:
            print("-", verdict)
    print("\nRefused:\n")
    for verdict in [v for v in verdicts if not v.success][: options.worst]:
        print("-", verdict)


if __name__ == "__main__":
    main()
