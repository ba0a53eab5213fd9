"""Cost of `method="auto"` over that of the cheapest fixed steps that are as accurate, for random robots.

    python benches/python/accuracy/cost.py [--count 7] [--seed 1] [--family NAME ...] [--verbose]

Each case draws a robot of a family and is asked for 1e-2, 1e-3 and 1e-4. Cost is processor time: of the
whole request, over that of one run by Newmark's method (the default of `lissom.simulate`) with the longest
steps of a series for which this run and the next finer one are as accurate as was asked. Such an expert knows
the step beforehand. Errors are those of the measured places, relative to the length, against Radau's method
with far tighter tolerances. Prints a Markdown table; ends with status 1 if more than one success in a
thousand misses what was asked.
"""

import argparse
import sys
import time
import warnings
from dataclasses import dataclass

import numpy as np
from families import FAMILIES, error, places

import lissom

REQUESTS = (1e-2, 1e-3, 1e-4)
# Ratio of neighbouring steps of the series, its first number of steps and the most steps that are tried.
FINER = 1.5
FEWEST_STEPS = 20
MOST_STEPS = 30_000
# Runs shorter than this, in seconds, are timed several times.
SHORT = 0.05
REPEATS = 3
# Share of successes that may miss what was asked.
MISSED = 1e-3


@dataclass(frozen=True)
class Verdict:
    """What a request took and reached; errors relative to the length, times in seconds."""

    family: str
    number: int
    asked: float
    status: str
    reached: float
    claimed: float
    seconds: float
    expert: float
    steps: int
    expert_steps: int
    message: str

    @property
    def success(self):
        return self.status == "finished"

    @property
    def cost(self):
        return self.seconds / self.expert

    @property
    def missed(self):
        return self.success and self.reached > self.asked

    def __str__(self):
        method = "dop853" if "Method: dop853" in self.message else "radau"
        return (
            f"{self.family} #{self.number} asked {self.asked:.0e} reached {self.reached:.1e} "
            f"claimed {self.claimed:.1e} {self.status} {method} steps {self.steps}, "
            f"{1e3 * self.seconds:.1f} ms; "
            f"expert {self.expert_steps} steps, {1e3 * self.expert:.1f} ms; cost {self.cost:.2f}"
            f"{' MISSED' if self.missed else ''}"
        )


def timed(run):
    """A result and its processor time, the least of several runs if it is short."""
    least = np.inf
    for _ in range(REPEATS):
        began = time.process_time()
        found = run()
        least = min(least, time.process_time() - began)
        if least > SHORT:
            break
    return found, least


def expert(case, right):
    """The least number of fixed steps for each request, of which it and the next larger one reach it."""
    steps, wanted, model = float(FEWEST_STEPS), list(REQUESTS), case.make()
    found, errors = {}, []
    while wanted and steps < MOST_STEPS:
        motion = case.run(model, method="newmark", dt=case.duration / int(steps))
        reached = error(model, motion, right) if motion.success and len(motion.t) == len(right) else np.inf
        errors.append((int(steps), reached))
        while wanted and len(errors) > 1 and max(errors[-1][1], errors[-2][1]) <= wanted[0]:
            asked = wanted.pop(0)
            found[asked] = errors[-2][0]
        # An order of two: no need to try what cannot do.
        far = np.sqrt(min(reached, 1.0) / wanted[0]) / 3.0 if wanted else 1.0
        steps *= max(FINER, FINER ** np.floor(np.log(max(far, 1.0)) / np.log(FINER)))
    return found


def judge(family, number, seed):
    """The verdicts on the requests of a case; none if the reference fails."""
    case = FAMILIES[family](np.random.default_rng([seed, list(FAMILIES).index(family), number]))
    exact = case.truth()
    if not exact.success:
        print(f"{family} #{number}: no reference: {exact.message}", file=sys.stderr)
        return
    right = places((case.exact or case.make)(), exact)
    steps = expert(case, right)
    for asked in REQUESTS:
        if asked not in steps:
            print(f"{family} #{number}: no fixed steps reach {asked}", file=sys.stderr)
            continue
        # Each run of a robot of its own: nothing may be known from the run before.
        dt = case.duration / steps[asked]
        _, of_expert = timed(lambda: case.run(method="newmark", dt=dt))  # noqa: B023
        found, seconds = timed(lambda: case.run(method="auto", rtol=asked))  # noqa: B023
        complete = len(found.t) == len(right)
        yield Verdict(
            family,
            number,
            asked,
            found.status,
            error(found.model, found, right) if complete else np.nan,
            np.nan if found.stats.time_error is None else found.stats.time_error,
            seconds,
            of_expert,
            found.stats.steps,
            steps[asked],
            found.message,
        )


def table(verdicts):
    yield (
        "| family | asked | requests | success | missed | reached / asked, median | largest "
        "| cost, median | 95th percentile | largest |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    groups = [(name, asked) for name in FAMILIES for asked in REQUESTS]
    groups += [("all", asked) for asked in REQUESTS] + [("all", "all")]
    for name, asked in groups:
        of_group = [v for v in verdicts if name in (v.family, "all") and asked in (v.asked, "all")]
        won = [v for v in of_group if v.success]
        if not won:
            continue
        reached = np.array([v.reached / v.asked for v in won])
        cost = np.array([v.cost for v in won])
        yield (
            f"| {name} | {asked if asked == 'all' else f'{asked:.0e}'} | {len(of_group)} | {len(won)} "
            f"| {sum(v.missed for v in won)} | {np.median(reached):.2g} | {reached.max():.2g} "
            f"| {np.median(cost):.1f} | {np.percentile(cost, 95):.1f} | {cost.max():.1f} |"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=7, help="robots of each family")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--family", nargs="*", choices=list(FAMILIES))
    parser.add_argument("--number", type=int, help="only this case of the families")
    parser.add_argument("--verbose", action="store_true", help="every request, as it comes")
    options = parser.parse_args()
    # Coarse steps of the series are meant.
    warnings.simplefilter("ignore", lissom.AccuracyWarning)
    numbers = range(options.count) if options.number is None else [options.number]
    verdicts = []
    for family in options.family or FAMILIES:
        for number in numbers:
            for verdict in judge(family, number, options.seed):
                verdicts.append(verdict)
                if options.verbose:
                    print(verdict, file=sys.stderr, flush=True)
    print("\n".join(table(verdicts)))
    for verdict in verdicts:
        if verdict.missed or not verdict.success:
            print("-", verdict, "" if verdict.success else verdict.message)
    if sum(v.missed for v in verdicts) > MISSED * len(verdicts):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
