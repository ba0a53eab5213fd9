"""Correctness of results: comparison with tight runs, exact solutions and invariants."""

from __future__ import annotations

import time
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from ...._lissom import (
    AccuracyWarning,
    Model,
    ModesResult,
    MotionResult,
    Rod,
    StaticsResult,
    modes,
    simulate,
    statics,
)
from ....results.runs import Array
from .cell import SLOW_EVALUATIONS, Outcome, one_line

#: Largest error of a motion: of the tip, relative to the rod's length.
MOTION_TOLERANCE = 1e-2

#: Accuracy requested of ``method="auto"``, and the factor within which it must be met.
REQUEST, REQUEST_MARGIN = 1e-4, 3.0

#: Relative tolerance of adaptive methods in the matrix, and that of their references.
ADAPTIVE_TOLERANCE, REFERENCE_TOLERANCE = 1e-5, 1e-7

#: Approximate stability limit of DOP853, as step times rate (Hairer, Norsett and Wanner 1993, section II.5).
DOP853_LIMIT = 6.0

#: Absolute tolerance relative to these, for curvatures of one radian over the rod's length.
ABSOLUTE = 1e-2

#: Largest defect of the energy balance of a run with adaptive steps, relative to the moved energy.
BALANCE_TOLERANCE = 1e-2

#: Largest unbalanced force of an equilibrium, relative to the forces that balance each other.
FORCE_TOLERANCE = 1e-7

#: Largest error of natural frequencies, relative to the largest.
FREQUENCY_TOLERANCE = 1e-7

#: Eigenvalues below this fraction of the largest one have no reliable sign.
NEUTRAL = 1e-9

#: Maximum number of steps of adaptive methods, and of their references.
MOST_STEPS, MOST_REFERENCE_STEPS = 20_000, 40_000

#: Processor time, in seconds, after which a run is stopped, and a reference: nothing in the matrix may
#: hang, and a busy machine must not decide.
DEADLINE, REFERENCE_DEADLINE = 10.0, 60.0

#: Factor by which the error of a fixed step may exceed its linear estimate.
THEORY_MARGIN = 10.0

#: Factors of tolerances and of fixed steps if a motion turns out to multiply errors.
TIGHTER, SHORTER = 1e-3, 0.1


def run(model: Model, t_end: float, deadline: float = DEADLINE, **options: Any) -> MotionResult:
    """Simulate, but do not compute for longer than the deadline."""
    end = time.thread_time() + deadline
    with warnings.catch_warnings():
        # Errors of unresolved vibrations are judged here.
        warnings.simplefilter("ignore", AccuracyWarning)
        return simulate(model, t_end, progress=lambda t: time.thread_time() > end, **options)


def tolerances(rod: Rod, tolerance: float = ADAPTIVE_TOLERANCE) -> dict[str, Any]:
    """Options of a run with adaptive steps."""
    return {"rtol": tolerance, "atol": ABSOLUTE * tolerance / rod.length, "max_steps": MOST_STEPS}


def reference(rod: Rod, times: Array, **state: Any) -> MotionResult | None:
    """A run of high order with tight tolerances; None if no method reaches the end."""
    tight = tolerances(rod, REFERENCE_TOLERANCE) | {"max_steps": MOST_REFERENCE_STEPS}
    start = np.asarray(state.get("q0", np.zeros(rod.n)))
    rate = float(np.abs(modes(rod, start).eigenvalues).max())
    stiff = rate * float(times[-1]) / DOP853_LIMIT > MOST_REFERENCE_STEPS / 4
    for method in ("radau",) if stiff else ("dop853", "radau"):
        found = run(rod, float(times[-1]), REFERENCE_DEADLINE, method=method, t_eval=times, **tight, **state)
        if found.success:
            return found
    return None


def tip(rod: Rod, motion: MotionResult) -> Array:
    """Positions of the tip, shape (m, 3)."""
    return np.asarray(rod.pose(motion.q, [rod.length], t=motion.t)[:, 0, :3, 3])


def tip_error(rod: Rod, motion: MotionResult, right: MotionResult) -> float:
    """Largest distance between the tips, relative to the rod's length."""
    return float(np.abs(tip(rod, motion) - tip(rod, right)).max()) / rod.length


def failure(found: MotionResult | StaticsResult) -> Outcome:
    """Outcome of a run that reports its own failure."""
    evaluations = found.stats.nfev if isinstance(found, MotionResult) else found.nfev
    if not np.isfinite(found.q).all():
        return Outcome("wrong", f"{found.status}, and the states kept are not finite", None, evaluations)
    if found.status == "interrupted":
        return Outcome("failed", f"not done after {DEADLINE:g} s", None, evaluations)
    return Outcome("failed", f"{found.status}: {one_line(found.message)}", None, evaluations)


def right_motion(error: float, evaluations: int, what: str) -> Outcome:
    """Outcome of a correct run."""
    if evaluations > SLOW_EVALUATIONS:
        return Outcome("slow", f"{evaluations:,} evaluations", error, evaluations)
    return Outcome("accurate", what, error, evaluations)


def requested(rod: Rod, times: Array, right: MotionResult | None, **state: Any) -> Outcome:
    """``method="auto"``: success claims that the tip is accurate."""
    motion = run(rod, float(times[-1]), method="auto", rtol=REQUEST, t_eval=times, **state)
    if isinstance(motion.model, Rod) and motion.model.nodes != rod.nodes:
        # More nodes were chosen: another discretisation, which needs its own reference.
        rod = motion.model
        right = reference(rod, times, **state)
    outcome = _compared(rod, motion, right)
    if (
        outcome.kind in ("accurate", "slow")
        and right is not None
        and (outcome.error or 0.0) > REQUEST_MARGIN * REQUEST
    ):
        reason = (
            f"the tip is off by {outcome.error:.1e} of the length, {motion.stats.time_error:.1e} is claimed"
        )
        return replace(outcome, kind="wrong", reason=reason)
    return outcome


def adaptive(rod: Rod, times: Array, right: MotionResult | None, method: str, **options: Any) -> Outcome:
    """Adaptive steps: success claims that the local errors are small.

    A run may be inaccurate if the motion multiplies errors; then tighter tolerances must restore accuracy.
    """
    t_end = float(times[-1])
    motion = run(rod, t_end, method=method, t_eval=times, **(tolerances(rod) | options))
    outcome = _compared(rod, motion, right)
    if outcome.kind != "wrong" or outcome.error is None or right is None:
        return outcome
    tight = tolerances(rod, TIGHTER * ADAPTIVE_TOLERANCE) | {"max_steps": MOST_REFERENCE_STEPS}
    better = _compared(rod, run(rod, t_end, method=method, t_eval=times, **(tight | options)), right)
    if better.kind == "wrong":
        return outcome
    reason = f"the motion multiplies local errors: the tip is off by {outcome.error:.1e} of the length"
    return replace(outcome, kind="failed", reason=f"{reason}; tighter tolerances bring it back")


def _compared(rod: Rod, motion: MotionResult, right: MotionResult | None) -> Outcome:
    if not motion.success:
        return failure(motion)
    cost = motion.stats.nfev
    if not np.isfinite(motion.q).all():
        return Outcome("wrong", "the states are not finite", None, cost)
    if right is None:
        drift = defect(motion)
        if not drift <= BALANCE_TOLERANCE:
            return Outcome("wrong", f"the energy balance is off by {drift:.1e}", drift, cost)
        return right_motion(drift, cost, "no reference gets to the end; by the energy balance")
    error = tip_error(rod, motion, right)
    if not error <= MOTION_TOLERANCE:
        return Outcome("wrong", f"the tip is off by {error:.1e} of the length", error, cost)
    return too_coarse(right, cost) or right_motion(error, cost, "tip, beside a tight run")


def defect(motion: MotionResult) -> float:
    """Defect of the energy balance; zero if nothing moves."""
    return motion.balance.drift if motion.balance is not None and motion.balance.moves else 0.0


def too_coarse(right: MotionResult, evaluations: int) -> Outcome | None:
    """With steps as tight as the reference's, only the quadrature of flows leaves a defect of the balance."""
    drift = defect(right)
    if drift <= BALANCE_TOLERANCE:
        return None
    reason = f"too few nodes for such bends: with any step the energy balance is off by {drift:.1e}"
    return Outcome("failed", reason, drift, evaluations)


def fixed(
    rod: Rod, times: Array, right: MotionResult | None, method: str, dt: float, **state: Any
) -> Outcome:
    """Fixed steps: success claims only that every step is solved.

    An inaccurate run is wrong only if its step is short enough by the linear theory of the method and shorter
    steps do not improve it.
    """
    t_end = float(times[-1])
    motion = run(rod, t_end, method=method, dt=dt, t_eval=times, **state)
    if right is None and motion.success:
        return Outcome("failed", "no reference gets to the end, and fixed steps have no error estimate")
    outcome = _compared(rod, motion, right)
    if outcome.kind != "wrong" or outcome.error is None or right is None:
        return outcome
    reason = f"the step is too long: the tip is off by {outcome.error:.1e} of the length"
    expected = expected_error(rod, t_end, dt, np.asarray(state.get("q0", np.zeros(rod.n))))
    if THEORY_MARGIN * expected >= MOTION_TOLERANCE:
        return replace(outcome, kind="failed", reason=f"{reason}, linear theory says {expected:.1e}")
    shorter = run(rod, t_end, method=method, dt=SHORTER * dt, t_eval=times, **state)
    if shorter.success and tip_error(rod, shorter, right) < 0.5 * outcome.error:
        return replace(outcome, kind="failed", reason=f"{reason}; shorter ones bring it nearer")
    return outcome


def expected_error(rod: Rod, t_end: float, dt: float, q0: Array) -> float:
    """Tip error of average acceleration, relative to the length, by linear theory.

    The periods of all modes about the equilibrium increase by the fraction (omega dt)²/12 (Hughes 1987,
    section 9.3), so that a mode of amplitude a has the error a omega t (omega dt)²/12, at most 2 a.
    """
    rest = statics(rod, space_error=False)
    if not rest.success:
        return np.inf
    found = modes(rod, rest.q)
    omega = np.abs(found.eigenvalues.imag)
    shapes = np.real(found.shapes)
    amplitude = np.linalg.lstsq(shapes, q0 - rest.q, rcond=None)[0]
    deflection = np.abs(rod.jacobian(rest.q, rod.length, t=0.0)[3:] @ shapes).max(axis=0) * np.abs(amplitude)
    late = np.minimum(omega * t_end * (omega * dt) ** 2 / 12.0, 2.0)
    return float(deflection @ late) / rod.length


def equilibrium(rod: Rod, found: StaticsResult) -> Outcome:
    """Judge an equilibrium by its forces, and its stability by the eigenvalues of its stiffness."""
    if not found.success:
        return failure(found)
    if not np.isfinite(found.q).all():
        return Outcome("wrong", "the shape is not finite", None, found.nfev)
    rest = np.zeros(rod.n)
    stiffness = rod.tangent(found.q, rest, rest, t=0.0)[0]
    # Work of the unbalanced forces on the way to equilibrium, relative to the elastic energy scale.
    size = scales(rod)
    unbalanced = np.abs(rod.inverse_dynamics(found.q, rest, rest, t=0.0) * size)
    balanced = np.abs(stiffness * np.outer(size, size)) @ (1.0 + np.abs(found.q / size))
    error = float((unbalanced / balanced).max())
    if not error <= FORCE_TOLERANCE:
        return Outcome("wrong", f"forces are off balance by {error:.1e}", error, found.nfev)
    claimed = found.is_stable
    if np.allclose(stiffness, stiffness.T, rtol=1e-6, atol=1e-9 * np.abs(stiffness).max()):
        lowest = lowest_eigenvalue(stiffness)
        if (claimed and lowest < -NEUTRAL) or (claimed is False and lowest > NEUTRAL):
            return Outcome("wrong", f"called {found.stability}, eigenvalue {lowest:.1e}", error, found.nfev)
    return right_motion(error, found.nfev, f"balance of forces; {found.stability}")


def lowest_eigenvalue(matrix: Array) -> float:
    """Smallest eigenvalue of a matrix scaled to a diagonal of magnitude one."""
    root = np.sqrt(np.abs(np.diag(matrix)))
    return float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T) / np.outer(root, root)).min())


def vibrations(rod: Rod, q: Array, found: ModesResult) -> Outcome:
    """Judge undamped natural frequencies by eigenvalues computed with NumPy from the same matrices."""
    rest = np.zeros(rod.n)
    stiffness, _, mass = rod.tangent(q, rest, rest, t=0.0)
    root = np.sqrt(np.diag(mass))
    lower = np.linalg.cholesky(mass / np.outer(root, root))
    half = np.linalg.solve(lower, stiffness / np.outer(root, root))
    squares = np.linalg.eigvalsh(np.linalg.solve(lower, half.T))
    right = np.sort(np.sqrt(np.abs(squares)))
    omega = np.sort(np.abs(found.eigenvalues))
    if not np.isfinite(omega).all():
        return Outcome("wrong", "frequencies are not finite")
    error = float(np.abs(omega - right).max() / right.max())
    if not error <= FREQUENCY_TOLERANCE:
        return Outcome("wrong", f"frequencies are off by {error:.1e}", error)
    return Outcome("accurate", "frequencies, beside numpy.linalg", error)


def scales(rod: Rod) -> Array:
    """Sizes of the coordinates: one radian over the rod for curvatures, one for stretch and shear."""
    curvature = {"torsion", "bend_y", "bend_z"}
    return np.array(
        [
            1.0 / rod.length if strain in curvature else 1.0
            for segment in rod.segments
            for strain in ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
            for _ in range(segment.modes.get(strain, 0))
        ]
    )
