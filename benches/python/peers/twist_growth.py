"""What the experiment `twist` of cosseratbench measures: of the exact linear rod, and of lissom rod by rod.

    pip install 'lissom[cosseratbench]' cosseratbench
    python benches/python/peers/twist_growth.py [--lissom] [--tangent]

The exact rod, between clamps, obeys rho A (w'' + c w') + B w'''' - i M w''' - T w'' = 0 (primes of time in
the brackets). Its rates of growth come from Galerkin's method with polynomials, not from the benchmark's
determinant. `--lissom` runs the adaptor's rods one by one without self-contact, `--tangent` with the first
clamp along the tangent of the centreline in place of its first chord.
"""

import argparse
import dataclasses
from types import SimpleNamespace

import numpy as np
from cosseratbench.experiments import twist
from numpy.polynomial import legendre
from scipy.linalg import eigh
from scipy.optimize import brentq

import lissom
from lissom.cli.evidence import cosseratbench as adaptor

#: Polynomials of the exact rod.
POLYNOMIALS = 24
#: Held twists that are run with lissom, as indices of the benchmark's levels: those that grow or just do not.
GROWING = (2, 3, 4, 5)
#: Seconds after the ramp until which they are run: further on they are past what the fit looks at.
HELD = (10.0, 10.0, 10.0, 8.0)
FRAMES_A_SECOND = 20
STEP = 2e-3


def forms(n: int = POLYNOMIALS) -> list[np.ndarray]:
    """Mass, bending, tension and twist of clamped polynomials on [0, 1] (Shen 1994)."""
    x, w = legendre.leggauss(n + 20)
    shapes = []
    for k in range(n):
        c = np.zeros(k + 5)
        c[[k, k + 2, k + 4]] = 1.0, -2.0 * (2 * k + 5) / (2 * k + 7), (2 * k + 3) / (2 * k + 7)
        derivatives = [c, legendre.legder(c), legendre.legder(c, 2)]
        shapes.append([legendre.legval(x, d) * 2.0**i for i, d in enumerate(derivatives)])
    values = np.array(shapes)
    pairs = [(0, 0), (2, 2), (1, 1), (1, 2)]
    return [(values[:, a] * w / 2.0) @ values[:, b].T for a, b in pairs]


FORMS = forms()


def growth(moment: float, tension: float) -> float:
    """s² + c s of the fastest motion, for B = rho A = L = 1."""
    mass, bending, pull, turn = FORMS
    stiffness = bending + tension * pull + 1j * moment * turn
    return -float(eigh((stiffness + stiffness.conj().T) / 2.0, mass, eigvals_only=True)[0])


def critical(tension: float) -> float:
    """The smallest moment at which the straight rod is unstable."""
    low = 2.0 * np.sqrt(tension)
    return float(brentq(lambda moment: growth(moment, tension), low, low + 12.0, xtol=1e-13))


def fitted(rates: np.ndarray) -> float:
    """The benchmark's fit of three rates."""
    growing = np.flatnonzero(np.isfinite(rates) & (rates > twist.GROWING))[:3]
    s, level = rates[growing], np.array(twist.LEVELS)[growing]
    (_, a, b), *_ = np.linalg.lstsq(np.stack([-s, level, np.ones_like(s)], axis=1), s**2, rcond=None)
    return float(-b / a)


def exact(tension: float) -> np.ndarray:
    """Rates of the exact rod at the levels of the benchmark."""
    scenario = twist.build(tension)
    rod, c = scenario.rods[0], adaptor.damping_rate(scenario)
    scale = rod.material.youngs_modulus * rod.second_moment_of_area / (rod.material.density * rod.area)
    moment = critical(tension)
    squares = [growth(level * moment, tension) * scale for level in twist.LEVELS]
    return np.array([((-c + np.sqrt(complex(c * c + 4.0 * square))) / 2.0).real for square in squares])


def tangent_axes(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Axes along the tangent of the parabola through the first three points."""
    chords = np.diff(points[:3], axis=0)
    lengths = np.linalg.norm(chords, axis=1, keepdims=True)
    slopes = chords / lengths
    along = slopes[0] - (slopes[-1] - slopes[0]) * lengths[0] / lengths.sum()
    along = along / np.linalg.norm(along)
    across = normal - (normal @ along) * along
    across = across / np.linalg.norm(across)
    return np.column_stack([along, across, np.cross(along, across)])


def by_lissom(tension: float) -> np.ndarray:
    """Rates of the adaptor's rods, one after the other."""
    scenario = twist.build(tension)
    times = np.arange(round(twist.DURATION * FRAMES_A_SECOND) + 1) / FRAMES_A_SECOND
    n = 50
    places = [np.repeat(rod.nodes(n)[None], len(times), axis=0) for rod in scenario.rods]
    for i, held in zip(GROWING, HELD, strict=True):
        rod = scenario.rods[i]
        alone = dataclasses.replace(scenario, rods=(rod,), self_contact=False)
        robot, q0 = adaptor.robot_of(alone, adaptor.segments_of(n))
        seen = times[times <= twist.RAMP + held + 1e-9]
        result = lissom.simulate(robot, float(seen[-1]), q0=q0, dt=STEP, t_eval=seen)
        nodes, _ = adaptor.seen_of(robot, result, adaptor.name_of(0), rod.length, n)
        rest = np.repeat(nodes[-1:], len(times) - len(nodes), axis=0)
        places[i] = np.concatenate([nodes, rest])
    return twist.growth_rates(scenario, SimpleNamespace(times=times, positions=tuple(places)))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lissom", action="store_true")
    parser.add_argument("--tangent", action="store_true")
    parser.add_argument("--tension", type=float, action="append")
    options = parser.parse_args()
    if options.tangent:
        adaptor.base_axes = tangent_axes
    for tension in options.tension or (1.0, 10.0, 30.0):
        rates = by_lissom(tension) if options.lissom else exact(tension)
        moment = critical(tension)
        print(f"tension {tension:g}: M L / B {moment:.10f}, rates {rates}, fitted twist {fitted(rates):.5f}")


if __name__ == "__main__":
    main()
