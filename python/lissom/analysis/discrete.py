"""Linear models in discrete time, with delays."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from .._lissom import LissomError
from ..common.arguments import number
from ..common.extras import missing

Array = NDArray[np.float64]

#: Delays this close to a multiple of the sampling time are multiples of it, relative to the sampling time.
SAME = 1e-9

#: The longest delay, in samples: each sample is a state of every input.
MOST_SAMPLES = 1000


def held(model: Iterable[Array], dt: float, delay: float) -> tuple[tuple[Array, ...], int]:
    """A, B, C, D of a model (A, B, C, D) whose inputs are held and arrive late, and how many inputs it keeps.

    The exponential of the block matrix [[A, B], [0, 0]] gives both integrals (Van Loan 1978). An input that
    arrives within a sample acts with its predecessor before (Astrom and Wittenmark 1997, section 3.2); what
    has not arrived yet is part of the state.
    """
    _check(dt, delay)
    of_state, of_input, output, through = model
    whole = int(delay / dt + SAME)
    late = delay / dt - whole
    late = 0.0 if late < SAME else late
    rest, new = _moved(of_state, of_input, (1.0 - late) * dt)
    first, old = _moved(of_state, of_input, late * dt)
    transition, earlier = rest @ first, rest @ old
    n, p = of_input.shape
    kept = whole + (late > 0.0)
    A = np.zeros((n + kept * p, n + kept * p))
    B = np.zeros((n + kept * p, p))
    C = np.zeros((len(output), n + kept * p))
    D = np.zeros_like(through)
    A[:n, :n], C[:, :n] = transition, output
    # Kept inputs, the last one first: the input of k samples ago is in block k - 1.
    for age, gain in ((whole, new), (whole + 1, earlier)):
        if age == 0:
            B[:n] = gain
        elif age <= kept:
            A[:n, n + (age - 1) * p : n + age * p] = gain
    if kept == 0:
        D[:] = through
    else:
        C[:, n + (kept - 1) * p :] = through
        B[n : n + p] = np.eye(p)
        A[n + p :, n : n + (kept - 1) * p] = np.eye((kept - 1) * p)
    if not (np.isfinite(A).all() and np.isfinite(B).all()):
        raise LissomError(
            f"the motion within dt = {dt:g} s is not finite: the model is unstable; take a shorter dt"
        )
    return (A, B, C, D), kept


def _check(dt: float, delay: float) -> None:
    for name, value in (("dt", dt), ("delay", delay)):
        number(name, value)
    if not (np.isfinite(dt) and dt > 0.0):
        raise ValueError(f"dt: got {dt}, expected the time between samples, seconds, more than zero")
    if not (np.isfinite(delay) and 0.0 <= delay <= MOST_SAMPLES * dt):
        raise ValueError(
            f"delay: got {delay}, expected seconds, from zero to {MOST_SAMPLES} samples "
            f"({MOST_SAMPLES * dt:g} s)"
        )
    if missing("scipy"):
        raise ImportError("discrete needs SciPy: pip install 'lissom[fit]'")


def _moved(of_state: Array, of_input: Array, h: float) -> tuple[Array, Array]:
    """What a time h makes of the state, and of a constant input from then on."""
    from scipy.linalg import expm

    n, p = of_input.shape
    block = np.zeros((n + p, n + p))
    block[:n, :n], block[:n, n:] = of_state, of_input
    # What overflows is refused by name.
    with np.errstate(over="ignore", invalid="ignore"):
        moved = expm(block * h)
    return moved[:n, :n], moved[:n, n:]
