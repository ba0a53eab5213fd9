"""What `method="auto"` is asked for and reaches, for random robots, beside ODEPACK.

    python benches/python/accuracy/independent.py [--count 13] [--first 0] [--seed 1] [--family NAME ...]
        [--requests 1e-2 1e-3 1e-4] [--verbose]

The reference is LSODA (Petzold 1983) by SciPy, of the accelerations that the model has for a state
(`forward_dynamics`): it shares the equations of motion with what is judged, and neither integrator, nor error
estimate, nor search for impacts. It starts anew where loads jump. A robot of which two such runs with
different tolerances disagree is not judged. Errors are those of tips and of four points of every body at 100
times, relative to the length. Prints a Markdown table and every success that misses what was asked; ends with
status 1 if there is one.
"""

import argparse
import sys
import time
import warnings
from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
from families import FAMILIES, TIMES, error, places
from scipy.integrate import solve_ivp

import lissom

# Relative tolerances of the reference, until two runs agree.
TOLERANCES = (1e-6, 1e-8, 1e-9, 1e-10)
# Absolute tolerances of coordinates and of velocities, over the relative one: tighter ones are below the
# rounding of stiff forces.
ATOL = (0.1, 10.0)
# They do if they differ by less than this share of what is asked.
SURE = 0.05
# Rotation vectors are singular at a revolution: longer ones than this are replaced by those of the other way.
FAR_TURNED = 1.5 * np.pi
# A run that takes longer than this many seconds ends with a status.
PATIENCE = 20.0
# A reference that takes more evaluations than this is given up.
MOST_EVALUATIONS = 150_000


class TooSlow(Exception):
    """A reference takes too many evaluations."""


def turned_back(state, n):
    """A state whose first joint is free, of a rotation vector that is shorter by a revolution."""
    turn, rate = state[3:6], state[n + 3 : n + 6]
    angle = np.linalg.norm(turn)
    axis = turn / angle
    moved = state.copy()
    moved[3:6] -= 2 * np.pi * axis
    moved[n + 3 : n + 6] -= 2 * np.pi / angle * (rate - axis * (axis @ rate))
    return moved


def by_lsoda(case, robot, start, rtol):
    """States at the compared times, from coordinates and velocities that satisfy the constraints."""
    n, count = robot.n, 0
    is_free = isinstance(robot.links[0].joint, lissom.Free)

    def is_far_turned(t, x):
        return np.linalg.norm(x[3:6]) - FAR_TURNED

    is_far_turned.terminal = True
    state, times = np.concatenate(start), case.times
    q = np.empty((len(times), n))
    q[0] = state[:n]
    edges = [0.0, *sorted(t for t in case.jumps if 0 < t < case.duration), case.duration]
    for begin, end in pairwise(edges):
        # A load that jumps at the end of a piece has not done so within it.
        before = np.nextafter(end, 0.0)

        def rates(t, x, before=before):
            nonlocal count
            count += 1
            if count > MOST_EVALUATIONS:
                raise TooSlow
            return np.r_[x[n:], robot.forward_dynamics(x[:n], x[n:], t=min(t, before))]

        t = begin
        while t < end:
            options = {"events": is_far_turned} if is_free else {}
            found = solve_ivp(
                rates,
                (t, end),
                state,
                "LSODA",
                dense_output=True,
                rtol=rtol,
                atol=rtol * np.repeat(ATOL, n),
                **options,
            )
            if not found.success:
                return None
            inside = (times > t) & (times <= found.t[-1])
            q[inside] = found.sol(times[inside])[:n].T
            t, state = found.t[-1], found.y[:, -1]
            if t < end:
                state = turned_back(state, n)
    return SimpleNamespace(q=q, t=times)


@dataclass(frozen=True)
class Verdict:
    """A request; errors relative to the length."""

    family: str
    number: int
    asked: float
    status: str
    reached: float
    claimed: float
    seconds: float
    message: str

    @property
    def success(self):
        return self.status == "finished"

    @property
    def missed(self):
        return self.success and self.reached > self.asked

    def __str__(self):
        return (
            f"{self.family} #{self.number} asked {self.asked:.0e} reached {self.reached:.1e} "
            f"claimed {self.claimed:.1e} {self.status} {self.seconds:.2f} s"
            f"{' MISSED' if self.missed else ''}"
        )


def judge(family, number, seed, requests):
    """The verdicts on the requests of a robot; none without a reference."""
    case = FAMILIES[family](np.random.default_rng([seed, list(FAMILIES).index(family), number]))
    references = {}
    for asked in requests:
        began = time.process_time()
        found = case.run(method="auto", rtol=asked, max_seconds=PATIENCE)
        seconds = time.process_time() - began
        reached = np.nan
        if len(found.t) == TIMES + 1:
            # Requests may have doubled the nodes.
            nodes = getattr(found.model, "nodes", None)
            if nodes not in references:
                references[nodes] = reference(case, found, requests)
            right, doubt = references[nodes]
            if right is None or doubt > SURE * asked:
                print(f"{family} #{number} asked {asked:.0e}: no reference ({doubt:.1e})", file=sys.stderr)
                continue
            reached = error(found.model, found, right)
        claimed = np.nan if found.stats.time_error is None else found.stats.time_error
        yield Verdict(family, number, asked, found.status, reached, claimed, seconds, found.message)


def reference(case, found, requests):
    """Places at the compared times, and how much the last two runs of different tolerances differ."""
    robot, start = found.model, (found.q[0], found.v[0])
    right, doubt = None, np.inf
    for rtol in TOLERANCES:
        try:
            run = by_lsoda(case, robot, start, rtol)
        except (TooSlow, ValueError, lissom.LissomError):
            run = None
        if run is None:
            break
        right, before = places(robot, run), right
        if before is not None:
            doubt = float(np.linalg.norm(right - before, axis=2).max())
        if doubt < SURE * min(requests):
            break
    return right, doubt


def table(verdicts):
    """Rows of a Markdown table: by family, and of all by request."""
    yield "| family | requests | finished | missed | reached / asked, median | largest | time, median |"
    yield "|---|---|---|---|---|---|---|"
    groups = [(name, [v for v in verdicts if v.family == name]) for name in FAMILIES]
    groups += [
        (f"all, {asked:.0e}", [v for v in verdicts if v.asked == asked])
        for asked in sorted({v.asked for v in verdicts}, reverse=True)
    ]
    for name, of_group in [*groups, ("all", verdicts)]:
        won = [v for v in of_group if v.success]
        if not won:
            continue
        share = np.array([v.reached / v.asked for v in won])
        yield (
            f"| {name} | {len(of_group)} | {len(won)} | {sum(v.missed for v in won)} "
            f"| {np.median(share):.2g} | {share.max():.2g} "
            f"| {1e3 * np.median([v.seconds for v in won]):.0f} ms |"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=13, help="robots of each family")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--family", nargs="*", choices=list(FAMILIES))
    parser.add_argument("--requests", type=float, nargs="*", default=[1e-2, 1e-3, 1e-4])
    parser.add_argument("--verbose", action="store_true", help="every request, as it comes")
    options = parser.parse_args()
    warnings.simplefilter("ignore", lissom.AccuracyWarning)
    verdicts = []
    for family in options.family or FAMILIES:
        for number in range(options.first, options.first + options.count):
            for verdict in judge(family, number, options.seed, options.requests):
                verdicts.append(verdict)
                if options.verbose:
                    print(verdict, file=sys.stderr, flush=True)
    print("\n".join(table(verdicts)))
    for verdict in verdicts:
        if verdict.missed or not verdict.success:
            print("-", verdict, "" if verdict.success else verdict.message)
    if any(verdict.missed for verdict in verdicts):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
