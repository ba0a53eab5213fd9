"""Runs as functions of arrays, with vector-Jacobian products, for the bridges to other frameworks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import Model, check_model, simulate_many
from ..methods import Newmark
from .parameters import START, model_with, names_of, resolved
from .sensitivities import NEWMARK, OF_SCHEME, OF_STEPS, number_of_control_steps, sensitivity
from .shorthand import shorthand

Array = NDArray[np.float64]

#: Tolerance for times that must coincide with steps, relative to the step.
OF_STEP = 1e-6


@dataclass(frozen=True)
class Pullback:
    """Runs of a model as functions of parameters and initial states, with their vector-Jacobian products.

    Attributes
    ----------
    model : Model
        The simulated model, with its own values of the parameters.
    names : tuple of str
        Names of the p parameters.
    t : ndarray, shape (m,)
        Times of the returned states, seconds.
    held : (int, int)
        Numbers of control steps and of inputs; zeros if inputs keep their defaults.
    """

    model: Model
    names: tuple[str, ...]
    t: Array
    held: tuple[int, int]
    _steps: NDArray[np.intp] = field(repr=False)
    _control_step: float | None = field(repr=False)
    _options: dict[str, Any] = field(repr=False)

    def run(self, values: ArrayLike, q0: ArrayLike, v0: ArrayLike, u: ArrayLike) -> tuple[Array, Array]:
        """Coordinates and velocities at the times; NaN after a failure.

        Parameters
        ----------
        values : array_like, shape (..., p)
        q0, v0 : array_like, shape (..., n)
        u : array_like, shape (..., steps, inputs)
            All with the same leading axes: a run for each row, in a single `simulate_many`.

        Returns
        -------
        q, v : ndarray, shape (..., m, n)
        """
        values, q0, v0, u, batch = self._rows(values, q0, v0, u)
        if not len(q0):
            return np.empty((2, *batch, len(self.t), self.model.n))  # type: ignore[return-value]
        models: Any = [self._with(row) for row in values] if self.names else self.model
        many = simulate_many(models, q0=q0, v0=v0, **self._inputs(u), **self._options)
        shape = (*batch, len(self.t), self.model.n)
        return many.q[:, self._steps].reshape(shape), many.v[:, self._steps].reshape(shape)

    def pull(
        self, values: ArrayLike, q0: ArrayLike, v0: ArrayLike, u: ArrayLike, on_q: ArrayLike, on_v: ArrayLike
    ) -> tuple[Array, Array, Array, Array]:
        """Vector-Jacobian products by the adjoint method; NaN for failed runs.

        Parameters
        ----------
        values, q0, v0, u : array_like
            As for `run`.
        on_q, on_v : array_like, shape (..., m, n)
            Derivatives of a number with respect to the results of `run`.

        Returns
        -------
        on_values, on_q0, on_v0, on_u : ndarray, shapes (..., p), (..., n), (..., n), (..., steps, inputs)
            Derivatives of the number with respect to the arguments of `run`.
        """
        values, q0, v0, u, batch = self._rows(values, q0, v0, u)
        p, n = len(self.names), self.model.n
        on_q, on_v = (np.asarray(part, float).reshape(len(q0), len(self.t), n) for part in (on_q, on_v))
        found = np.empty((len(q0), p + 2 * n + self.held[0] * self.held[1]))
        for i in range(len(q0)):
            found[i] = self._gradient(values[i], q0[i], v0[i], u[i], on_q[i], on_v[i])
        on_values, on_q0, on_v0, on_u = np.split(found, [p, p + n, p + 2 * n], axis=1)
        return (
            on_values.reshape(*batch, p),
            on_q0.reshape(*batch, n),
            on_v0.reshape(*batch, n),
            on_u.reshape(*batch, *self.held),
        )

    def _gradient(self, values: Array, q0: Array, v0: Array, u: Array, on_q: Array, on_v: Array) -> Array:
        failed = np.full(len(values) + len(q0) + len(v0) + u.size, np.nan)
        # Also for failed runs, whose weights are NaN.
        if not (np.isfinite(on_q).all() and np.isfinite(on_v).all()):
            return failed
        model = self._with(values)
        row = simulate_many(
            model, q0=q0[None], v0=v0[None], keep="final", **self._inputs(u[None]), **self._options
        )
        if not row.success[0]:
            return failed

        def weighted(t: Array, q: Array, v: Array) -> tuple[float, Array, Array]:
            by_q, by_v = np.zeros_like(q), np.zeros_like(v)
            # A time may occur twice.
            np.add.at(by_q, self._steps, on_q)
            np.add.at(by_v, self._steps, on_v)
            return float(np.sum(by_q * q) + np.sum(by_v * v)), by_q, by_v

        names = [*self.names, "q0", "v0", *(["u"] if u.size else [])]
        given = {"q0": q0, "v0": v0} | self._inputs(u) | self._options
        found = sensitivity(model, parameters=names, objective=weighted, **given)
        assert found.gradient is not None
        return found.gradient

    def _inputs(self, u: Array) -> dict[str, Any]:
        return {"u": u, "control_step": self._control_step} if u.size else {}

    def _with(self, values: Array) -> Model:
        return model_with(self.model, dict(zip(self.names, map(float, values), strict=True)))

    def _rows(
        self, values: ArrayLike, q0: ArrayLike, v0: ArrayLike, u: ArrayLike
    ) -> tuple[Array, Array, Array, Array, tuple[int, ...]]:
        rows = []
        batch: tuple[int, ...] = np.shape(q0)[:-1]
        count = int(np.prod(batch))
        shapes = ((len(self.names),), (self.model.n,), (self.model.n,), self.held)
        for name, given, shape in zip(("values", "q0", "v0", "u"), (values, q0, v0, u), shapes, strict=True):
            array = np.asarray(given, float)
            if array.shape != (*batch, *shape):
                raise ValueError(f"{name}: got shape {array.shape}, expected {(*batch, *shape)}")
            rows.append(array.reshape(count, *shape))
        return rows[0], rows[1], rows[2], rows[3], batch


def pullback(
    model: Model,
    t_end: float,
    parameters: Sequence[str],
    *,
    t: ArrayLike | None,
    t0: float,
    dt: float,
    method: str | Newmark,
    control_step: float | None = None,
    **options: Any,
) -> Pullback:
    """Runs of a model as a function of these parameters and the initial state."""
    check_model(model, "model")
    method, options = shorthand(method, options)
    if method not in NEWMARK:
        known = ", ".join(map(repr, NEWMARK))
        raise ValueError(
            f"method: got {method!r}, expected one of {known}: runs by others are not differentiated here"
        )
    for name in options:
        if name not in (*OF_SCHEME, *OF_STEPS) or name == "progress":
            raise TypeError(f"{name}: runs that are differentiated have no such option: leave it out")
    names = [] if isinstance(parameters, Sequence) and len(parameters) == 0 else names_of(parameters)
    for i, name in enumerate(names):
        if START.fullmatch(name):
            raise ValueError(
                f"parameters[{i}]: got {name!r}, expected a number of the model: the start is an argument"
            )
    resolved(model, names, by_adjoint=True)
    times, steps = _steps(t, t0, t_end, dt)
    held = _held(model, control_step, t_end - t0, dt)
    chosen = {"t_end": t_end, "t0": t0, "dt": dt, "method": method} | options
    return Pullback(model, tuple(names), times, held, steps, control_step, chosen)


def _held(model: Model, control_step: float | None, duration: float, dt: float) -> tuple[int, int]:
    """Numbers of control steps and of inputs."""
    if control_step is None:
        return 0, 0
    if not model.inputs:
        raise ValueError(
            "control_step: this model has no inputs: leave it out, or give loads or actuators a lissom.Input"
        )
    # Then all steps have the same size.
    is_whole = control_step > 0.0 and abs(control_step / dt - round(control_step / dt)) <= OF_STEP
    if not is_whole or round(control_step / dt) < 1:
        raise ValueError(f"control_step: got {control_step!r}, expected a whole number of steps of {dt} s")
    return number_of_control_steps(duration, control_step), len(model.inputs)


def _steps(t: ArrayLike | None, t0: float, t_end: float, dt: float) -> tuple[Array, NDArray[np.intp]]:
    if not (np.isfinite([t0, t_end, dt]).all() and dt > 0.0 and t_end > t0):
        raise ValueError(f"t_end: got {t_end} with t0={t0} and dt={dt}, expected t_end > t0 and dt > 0")
    count = round((t_end - t0) / dt)
    if count < 1 or abs(t0 + count * dt - t_end) > OF_STEP * dt:
        raise ValueError(f"dt: got {dt}, expected a whole number of steps from {t0} to {t_end}")
    if t is None:
        steps: NDArray[np.intp] = np.arange(count + 1, dtype=np.intp)
        return np.asarray(t0 + steps * dt, np.float64), steps
    times = np.asarray(t, float)
    if times.ndim != 1 or not len(times):
        raise ValueError(f"t: got shape {times.shape}, expected (m,) with m of 1 at least")
    for i, time in enumerate(times):
        # The first comparison also rejects NaN.
        is_within = t0 - OF_STEP * dt <= time <= t_end + OF_STEP * dt
        if not is_within or abs(t0 + round((time - t0) / dt) * dt - time) > OF_STEP * dt:
            raise ValueError(f"t[{i}]: got {time}, expected the time of a step, {t0} + k {dt} up to {t_end}")
    return times, np.rint((times - t0) / dt).astype(np.intp)
