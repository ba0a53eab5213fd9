"""The table of the gallery: lines for a terminal, cells for pages, Markdown for the documentation."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from itertools import groupby

import numpy as np

from ...._lissom import __version__
from ....drawing.report.text import quantity
from .case import Array, Case, Outcome

#: Number of significant digits.
DIGITS = 8

#: Columns on a terminal: name, width, alignment.
TERMINAL = (
    ("case", 30, "<"),
    ("wanted", 14, ">"),
    ("lissom", 14, ">"),
    ("error", 8, ">"),
    ("tolerance", 9, ">"),
    ("time", 8, ">"),
    ("source", 0, "<"),
)

#: Text of the documentation around the table.
BEFORE = """# Validation gallery

Questions with known answers, asked of lissom. This page is made by

    make validate        # lissom validate --update-docs docs/validation.md

and every number on it comes from that run: lissom {version}, {machine}. `lissom validate` also writes an
HTML report with a plot for each case and the same numbers as JSON, and ends with exit code 3 if a case is
outside its tolerance.

**Error** is the largest difference between lissom's values and the wanted ones, divided by the largest of
these or by the size of the rod. **Time** is that of lissom's answer, model included, as a Python caller sees
it (median of some runs). Wanted values are *exact* (a formula), *computed* (the same equations solved by
means that share nothing with lissom: Chebyshev collocation, Runge-Kutta shooting, an independent prototype,
other codes) or *published*. Except the prototype's and Exudyn's they are computed anew in every run, by
`exact*.py` in `python/lissom/cli/evidence/validation`, with NumPy alone, and by PyElastica. **Others** are
errors of other codes in the same case, from the values that their authors published.

{verdict}
"""

AFTER = """
## What is missing

No easier case is substituted silently.

- Friction in equilibria: `statics` is without it. Lines 1 and 3 of MoorPy's table are line 2 with friction of
  the floor of 5 and 0.1. The force on B is the same to 7e-8, but the anchor A would be pulled with 96.6 kN in
  lissom where MoorPy has 0 and 80.4 kN. (Motions have friction, also those without inertia,
  `method="quasi_static"`; what a line on a floor is pulled with then depends on how it was laid.)
- Rods that shear, without rotary inertia: their mass matrix is singular, and `modes` refuses them. The soft
  beam between clamps has a rotary inertia of 1e-8.
- Lines without bending stiffness: lissom's rods have some. That of the lines above changes their forces by
  1e-6 or less.
- Published curves of the follower force and of the right-angle frame in motion: they are known to us as
  drawings only, so that these cases stand beside the same equations solved by other means and by another
  code. (The points that AeroBeams has under "rightAngledFrame" are of another frame, the bent one above.)
- Why the first mode of the rotor was measured 8 to 10 % above every theory that is here.
- Other modes of the turbine. Blades on edge were measured at 1.81 Hz at rest, falling to 1.57 Hz; lissom has
  1.56 and 1.72 Hz, rising to 1.60 and 1.74 Hz. The tower's 2.5 Hz are not there at all: its top is held
  rigidly, and that of the real one by cables. The masses of its blades, as GXBeam has them, have their offset
  across the blade, which makes their matrix indefinite; here it is along the chord.
- Friction in knots. The published tension of a knot that is drawn tight, F h² / B = ε⁴ / 2 + 0.492 μ ε³, is a
  limit for thin ropes, as the contact force above shows: at ε = 0.25 lissom's ropes have 0.64 ε⁴ + 1.1 μ ε³,
  beyond which a motion with friction 0.025, 0.05 and 0.1 comes to rest (a test has one).
- Plies of 15 degrees and less: they need tails that are longer than this rod.
- The rope over the drum with all its bending stiffness, which the equation leaves out: with friction 0.6 it
  slides by 15.5 mm where with a hundredth of it it slides by 14.9 mm.
- The third motion of the jumper, up and down: its upper end is out of the water for a third of the time, and
  the fluid has no surface. Rods with given sections are refused in fluids, so that the jumper is a round rod
  of its bending stiffness that does not stretch. Waves are not asked for.
- The motions of MoorDyn's chains: they are in water, which given sections are refused in.
- Concentric tubes (measured poses of CRL-Dataset-CTCR-Pose, tubes of ConcentricTubeMexLibrary), bundles of
  flagella that move each other by the fluid between them, and cables whose bending has hysteresis (Newton's
  example_cable_dahl_hysteresis): lissom has no models of these.
- Creep. On the ground with friction the default `slip_velocity` of 0.1 mm/s moves the anchor's tension of the
  chain above by 0.05 of the largest within the 40 s; the case has 1 µm/s.
- The helical tendon robot of Lorenzen, Fabiansen and Møller (Aarhus 2026): its data (Apache 2.0) are pixels
  of two cameras; neither the cameras' calibration nor the tendons' lengths by row are among them.

The cases beside PyElastica need it (`pip install pyelastica`, which takes 20 s to compile itself when it is
used first) and are left out where it is not installed. How long both take has its own benchmark:
[benchmarks](benchmarks.md).
"""


def worst(outcome: Outcome) -> tuple[float, float]:
    """The reference value with the largest error, and lissom's value."""
    if outcome.found.shape != outcome.wanted.shape or not np.isfinite(outcome.found).all():
        return float(outcome.wanted[0]), float("nan")
    at = int(np.argmax(np.abs(outcome.found - outcome.wanted)))
    return float(outcome.wanted[at]), float(outcome.found[at])


def number(value: float) -> str:
    """A value with the digits needed for comparison."""
    return "–" if not np.isfinite(value) else f"{value:.{DIGITS}g}"


def numbers(values: Array) -> str:
    """Several values."""
    return ", ".join(number(value) for value in values)


def error(outcome: Outcome) -> str:
    """The error with its significant digits."""
    return "none" if outcome.error == 0.0 else f"{outcome.error:.0e}"


def head() -> str:
    """The table's header on a terminal."""
    return _line([name for name, _, _ in TERMINAL])


def line(outcome: Outcome) -> str:
    """A case as a line on a terminal; of several values the one with the largest error."""
    if outcome.not_run:
        return f"{outcome.case.name:<{TERMINAL[0][1]}}  not run: {outcome.not_run}"
    wanted, found = worst(outcome)
    case = outcome.case
    cells = [case.name, number(wanted), number(found), error(outcome), f"{case.tolerance:.0e}"]
    return _line([*cells, quantity(outcome.seconds, "s"), source(case)])


def _line(cells: Sequence[str]) -> str:
    padded = (f"{cell:{side}{width}}" for cell, (_, width, side) in zip(cells, TERMINAL, strict=True))
    return "  ".join(padded).rstrip()


def source(case: Case) -> str:
    """Source of the reference values."""
    return f"{case.source} ({case.origin})"


def verdict(outcomes: Sequence[Outcome]) -> str:
    """Summary in one sentence."""
    bad = [outcome.case.name for outcome in outcomes if outcome.outside]
    left_out = sum(bool(outcome.not_run) for outcome in outcomes)
    asked = len(outcomes) - left_out
    rest = f" Not run: {left_out}." if left_out else ""
    if bad:
        return f"{len(bad)} of {asked} cases are outside their tolerance: {', '.join(bad)}.{rest}"
    return f"All {asked} cases are within their tolerance.{rest}"


def markdown(outcomes: Sequence[Outcome]) -> str:
    """The page of the documentation."""
    machine = f"Python {platform.python_version()}, {platform.machine()}"
    if hasattr(os, "getloadavg"):
        # Of the last quarter of an hour: how much else ran beside the timed answers.
        machine += f", load {os.getloadavg()[2]:.1f}"
    parts = [BEFORE.format(version=__version__, machine=machine, verdict=verdict(outcomes))]
    for theme, group in groupby(outcomes, key=lambda outcome: outcome.case.theme):
        members = list(group)
        parts.append(f"\n## {theme}\n\n")
        parts.append(
            "| case | source | wanted | lissom | error | tolerance | time |\n|---|---|---|---|---|---|---|\n"
        )
        parts += [_row(outcome) for outcome in members]
        parts.append("\n")
        parts += [_setting(outcome.case) for outcome in members]
    return "".join(parts) + AFTER


def _row(outcome: Outcome) -> str:
    case = outcome.case
    mark = " **outside**" if outcome.outside else ""
    asked = (f"{case.name}{mark}", f"{case.source}; *{case.origin}*")
    found: tuple[str, ...]
    if outcome.not_run:
        found = ("–", f"not run: {outcome.not_run}", "–", f"{case.tolerance:.0e}", "–")
    else:
        found = (
            numbers(outcome.wanted),
            outcome.failure or numbers(outcome.found),
            error(outcome),
            f"{case.tolerance:.0e}",
            quantity(outcome.seconds, "s"),
        )
    cells = (*asked, *found)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def _setting(case: Case) -> str:
    others = f" Others: {case.others}." if case.others else ""
    return f"- **{case.name}** {case.setting} Values: {case.quantity}.{others}\n"
