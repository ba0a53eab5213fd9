"""Derivatives of runs with respect to the initial state and to model parameters."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import (
    LissomError,
    Model,
    Robot,
    check_model,
    finite_array,
    inputs_by_name,
    sensitivities,
    simulate,
)
from ..common.arguments import keywords, suggesting, takes, text
from ..common.interruption import Keeping
from ..methods import Auto, Newmark, Radau
from .accurate import found_options, of_rows
from .base import ParameterResult
from .parameters import OfInput, OfModel, OfStart, Parameter, names_of, place_derivative, resolved
from .shorthand import shorthand

if TYPE_CHECKING:
    from ..common.arguments import InputRows

Array = NDArray[np.float64]

#: Objective of a gradient: a number, and its derivatives with respect to coordinates and velocities.
Objective = Callable[[Array, Array, Array], tuple[float, ArrayLike, ArrayLike]]

#: Members of the Newmark family.
NEWMARK = (
    "newmark",
    "average_acceleration",
    "linear_acceleration",
    "fox_goodwin",
    "central_difference",
    "hht",
    "generalised_alpha",
)

#: Methods whose runs are differentiated.
METHODS = (*NEWMARK, "radau", "auto")

#: A remainder of less than this fraction of a control step is rounding, as in `simulate`.
ROUNDING_OF_STEPS = 1e-9

#: Keywords of `sensitivity` itself.
OWN = ("t0", "q0", "v0", "u", "control_step", "method", "dt", "objective")

#: Options of `simulate` that define the scheme, and those that control its steps and their solution.
OF_SCHEME = ("beta", "gamma", "alpha", "rho_inf")
OF_STEPS = (
    "rtol",
    "atol",
    "predictor",
    "reuse_jacobian",
    "max_step",
    "min_step",
    "max_steps",
    "jac",
    "progress",
)


@dataclass(frozen=True, eq=False, repr=False)
class SensitivityResult(ParameterResult):
    """A run and its derivatives.

    It can be copied, pickled and saved, and has plots, reports and datasets.

    Attributes
    ----------
    names : tuple of str
        Names of the p parameters. 'q0' and 'v0' are expanded into 'q0[0]', 'q0[1]' and so on, 'u' into
        'u[0][0]', 'u[0][1]', then 'u[1][0]' and so on.
    t : ndarray, shape (m,)
        Times of all steps, seconds.
    q, v : ndarray, shape (m, n)
        Coordinates and velocities.
    dq, dv : ndarray, shape (m, n, p), or None
        Derivatives with respect to the parameters; None if an objective was given.
    value : float or None
        Value of the objective.
    gradient : ndarray, shape (p,), or None
        Derivatives of the objective with respect to the parameters.
    """

    # Pickles refer to the class by this module, where it has its methods.
    __module__ = "lissom"

    names: tuple[str, ...]
    t: Array
    q: Array
    v: Array
    dq: Array | None
    dv: Array | None
    value: float | None
    gradient: Array | None
    _model: Model
    _parameters: tuple[Parameter, ...]

    def __repr__(self) -> str:
        what = "gradient" if self.dq is None else f"{len(self.t)} states"
        return (
            f"<SensitivityResult: {what} with respect to {len(self.names)} parameters, n = {self.q.shape[1]}>"
        )

    def position(
        self, X: float | None = None, *, link: str | None = None, t: ArrayLike | None = None
    ) -> tuple[Array, Array]:
        """Position of a point of the robot, and its derivatives with respect to the parameters.

        Parameters
        ----------
        X : float, optional
            Arc length, metres; by default the tip.
        link : str, optional
            Name of the link; by default the last one.
        t : array_like, shape (k,), optional
            Times within the run, seconds; all steps by default. Between steps the coordinates are cubic.

        Returns
        -------
        position : ndarray, shape (k, 3)
            World position, metres.
        derivative : ndarray, shape (k, 3, p)
            Metres per unit of each parameter.

        Raises
        ------
        ValueError, TypeError
            If the model has no places, a time is not within the run, or the derivatives were not computed.
        """
        if not isinstance(self._model, Robot):
            raise TypeError(
                f"model: expected a Rod or a Robot, got {type(self._model).__name__}, which has no places"
            )
        if self.dq is None or self.dv is None:
            raise ValueError(
                "objective: with one, only derivatives of its value exist: leave it out for those of places"
            )
        times, q, dq = self._between(t)
        place: dict[str, Any] = {"link": self._model.links[-1].name if link is None else link}
        positions = self._model.pose(q, X, t=times, **place)[..., :3, 3]
        derivative = self._model.jacobian(q, X, t=times, **place)[:, 3:] @ dq
        for i, parameter in enumerate(self._parameters):
            if not isinstance(parameter, OfModel):
                continue
            # Lengths, placements and prescribed motions also move places directly.
            by_itself = place_derivative(parameter, q, X, times, place)
            if by_itself is not None:
                derivative[:, :, i] += by_itself
        return positions, derivative

    def _between(self, t: ArrayLike | None) -> tuple[Array, Array, Array]:
        assert self.dq is not None
        assert self.dv is not None
        if t is None:
            return self.t, self.q, self.dq
        times = np.atleast_1d(np.asarray(t, float))
        is_wrong = ~((times >= self.t[0]) & (times <= self.t[-1]))
        if is_wrong.any():
            first = int(np.argmax(is_wrong))
            raise ValueError(
                f"t[{first}]: got {times[first]}, expected a time in [{self.t[0]}, {self.t[-1]}]"
            )
        if len(self.t) == 1:
            return times, np.repeat(self.q, len(times), 0), np.repeat(self.dq, len(times), 0)
        k = np.clip(np.searchsorted(self.t, times, "right") - 1, 0, len(self.t) - 2)
        h = self.t[k + 1] - self.t[k]
        s = (times - self.t[k]) / h
        weights = ((1 + 2 * s) * (1 - s) ** 2, h * s * (1 - s) ** 2, s**2 * (3 - 2 * s), h * s**2 * (s - 1))

        def cubic(x: Array, rate: Array) -> Array:
            a, b, c, d = (w.reshape(-1, *[1] * (x.ndim - 1)) for w in weights)
            return np.asarray(a * x[k] + b * rate[k] + c * x[k + 1] + d * rate[k + 1])

        return times, cubic(self.q, self.v), cubic(self.dq, self.dv)


@suggesting
def sensitivity(
    model: Model,
    t_end: float,
    parameters: Sequence[str],
    *,
    t0: float = 0.0,
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    u: InputRows | None = None,
    control_step: float | None = None,
    method: str | Newmark | Radau | Auto = "newmark",
    dt: float = 1e-2,
    objective: Objective | None = None,
    **options: Any,
) -> SensitivityResult:
    """Differentiate a run with respect to its initial state and parameters of the model.

    The derivatives are exact for the discrete solution: for every step size they agree with finite
    differences of runs with the same steps. They are as accurate as the solution of each step, which `rtol`
    controls for fixed steps.

    Parameters
    ----------
    model : Model
        A model without closed loops. Runs with contact are differentiated with `method="radau"` only.
    t_end : float
        End of the run, seconds.
    parameters : sequence of str
        Parameters to differentiate with respect to: 'q0' and 'v0' (all initial coordinates and velocities) or
        a single one such as 'q0[2]'; 'u' (all inputs of all control steps), 'u[3]' (all inputs of one control
        step) or 'u[3][0]' (one input); and model parameters by the names that `sweep` uses, such as
        'rod[0].segment[0].young_modulus', 'gravity[2]', 'link[1].joint.damping', or 'segments[*].radius' for
        a value that all segments share. All other numbers are held constant.
    t0, q0, v0 : optional
        As for `simulate`.
    u : array_like, shape (inputs,) or (steps, inputs), or dicts, optional
        Inputs, constant for the whole run or one row per control step. By default the defaults of the inputs.
    control_step : float, optional
        Duration of a control step, seconds; by default `dt`.
    method : str, or Newmark, Radau or Auto of lissom.methods
        A member of the Newmark family, as for `simulate`, with steps of fixed size; or 'radau', which chooses
        its step sizes by `rtol` and `atol`. The derivatives hold these step sizes constant. 'auto' is 'radau'
        with tolerances for a time error of at most `rtol` of the length, which some runs find beforehand.
    dt : float
        Step size of the Newmark family, seconds.
    objective : callable, optional
        Scalar function of the run. It is called once as ``objective(t, q, v)`` with arrays of shapes (m,),
        (m, n), (m, n), and returns its value and its derivatives with respect to `q` and `v`, both of shape
        (m, n). The gradient is then computed by the adjoint method, at a cost that hardly depends on the
        number of parameters.
    **options
        `beta`, `gamma`, `alpha`, `rho_inf`, `rtol`, `atol`, `jac`, `predictor`, `reuse_jacobian`, `max_step`,
        `min_step`, `max_steps`, `progress` as for `simulate`.

    Returns
    -------
    SensitivityResult
        `t`, `q`, `v` of the run; `dq`, `dv` of shape (m, n, p), or `value` and `gradient` of shape (p,).

    Raises
    ------
    ValueError, TypeError
        Before the run, if an argument is invalid, a name is unknown, or nothing depends on a parameter.
    LissomError
        If the run fails, or a spherical or free joint passes half a turn, where its coordinates change; the
        message says why.
    KeyboardInterrupt
        On Ctrl-C. Its attribute `result` is the run as a MotionResult, complete or up to there.

    Examples
    --------
    >>> import lissom
    >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 3}, retardation_time=1e-4)
    >>> rod = lissom.Rod([wire])
    >>> found = lissom.sensitivity(rod, 0.5, ["segments[0].young_modulus", "q0"])
    >>> found.dq.shape, found.names
    ((51, 3, 4), ('segments[0].young_modulus', 'q0[0]', 'q0[1]', 'q0[2]'))
    >>> position, derivative = found.position(t=[0.1, 0.25])
    >>> derivative.shape
    (2, 3, 4)
    """
    check_model(model, "model")
    of_method, options = shorthand(method, options)
    _check(model, of_method, options, objective, t_end=t_end, t0=t0, dt=dt)
    held, control_step = held_rows(model, u, control_step, t_end - t0, dt)
    shape = None if held is None else held.shape
    wanted = resolved(model, names_of(parameters), shape, by_adjoint=objective is not None)
    motion = {"t0": t0, "q0": q0, "v0": v0, "dt": dt, **of_rows(held, control_step, t0)}
    of_method, options = found_options(of_method, options, model, t_end, motion)
    scheme = {name: options[name] for name in OF_SCHEME if options.get(name) is not None}
    # Unsupported features are rejected before the run; the run reports whether there are accelerations.
    rest, none = np.zeros((1, model.n)), np.zeros((model.n, 0))
    with contextlib.suppress(LissomError):
        sensitivities(model, [t0], rest, rest, rest, [], none, none, method=of_method, **scheme)
    chosen: Any = {"method": of_method} | options
    if of_method == "radau":
        chosen["t_eval"] = "steps"
    begun: list[float] = []
    if held is not None:
        rows = iter(held)

        def next_inputs(t: float, _q: Array, _v: Array) -> Array:
            begun.append(t)
            return next(rows)

        chosen |= {"control": next_inputs, "control_step": control_step}
    run = simulate(model, t_end, t0=t0, q0=q0, v0=v0, dt=dt, **chosen)
    if not run.success:
        raise LissomError(f"the run did not come to its end: {run.message}")
    with Keeping(run):
        value, weights = None, None
        if objective is not None:
            value, weights = _weights(objective, run.t, run.q, run.v)
        dq0, dv0 = np.zeros((2, model.n, len(wanted)))
        for i, parameter in enumerate(wanted):
            if isinstance(parameter, OfStart):
                (dq0 if parameter.which == "q0" else dv0)[parameter.index, i] = 1.0
        intervals = None if held is None else list(zip(np.searchsorted(run.t, begun), held, strict=True))
        forces = [_on_forces(parameter, weights is not None) for parameter in wanted]
        found = sensitivities(
            model,
            run.t,
            run.q,
            run.v,
            run.a,
            forces,
            dq0,
            dv0,
            method=of_method,
            **scheme,
            intervals=intervals,
            weights=weights,
        )
    dq, dv, gradient = (*found, None) if weights is None else (None, None, *found)
    return SensitivityResult(
        names=tuple(parameter.name for parameter in wanted),
        t=run.t,
        q=run.q,
        v=run.v,
        dq=dq,
        dv=dv,
        value=value,
        gradient=gradient,
        _model=model,
        _parameters=tuple(wanted),
    )


def _check(model: Model, method: str, options: Mapping[str, Any], objective: Any, **times: Any) -> None:
    """Reject what cannot be differentiated."""
    if text("method", method) not in METHODS:
        known = ", ".join(map(repr, METHODS))
        raise ValueError(
            f"method: got {method!r}, expected one of {known}: runs by others are not differentiated"
        )
    keywords("sensitivity", options, (*OWN, *OF_SCHEME, *OF_STEPS))
    if objective is not None and not callable(objective):
        raise TypeError(f"objective: expected a callable, got {type(objective).__name__}")
    if objective is not None:
        takes(
            "objective", objective, "t, q, v", "the whole run: times (m,), coordinates and velocities (m, n)"
        )
    if getattr(model, "constraints", 0):
        raise ValueError(
            "model: expected one without closed loops and tendons that do not stretch, whose runs are not "
            f"differentiated yet; got one with {model.constraints} constraints"  # type: ignore[attr-defined]
        )
    for name, given in times.items():
        if finite_array(given, name).ndim:
            raise ValueError(f"{name}: got {given!r}, expected a number of seconds")


def _on_forces(parameter: Parameter, by_adjoint: bool) -> Any:
    """Dependence of the forces on a parameter. For sections, only the adjoint needs no further models."""
    if isinstance(parameter, OfInput):
        return parameter.step, parameter.input
    if isinstance(parameter, OfStart):
        return []
    if parameter.length_of is not None:
        return parameter.length_of
    material = parameter.material
    if material is None or (material.section is not None and not by_adjoint):
        return list(parameter.terms)
    of_stiffness = material.first, material.stiffness, material.damping
    if material.section is None:
        return of_stiffness
    return *of_stiffness, material.section.segment, list(material.section.nearby)


def number_of_control_steps(duration: float, control_step: float) -> int:
    """Number of control steps in a run; the last one may be shorter."""
    return max(1, math.ceil(duration / control_step * (1.0 - ROUNDING_OF_STEPS)))


def held_rows(
    model: Model, u: InputRows | None, control_step: float | None, duration: float, dt: float
) -> tuple[Array | None, float | None]:
    """Inputs of all control steps, and the duration of a control step."""
    if u is None:
        if control_step is not None:
            raise ValueError(
                f"control_step: got {control_step!r} without `u`, whose rows it holds: leave it out"
            )
        return None, None
    count = len(model.inputs)
    if not count:
        raise ValueError(
            "u: this model has no inputs: leave `u` out, or give loads or actuators a lissom.Input"
        )
    given = finite_array(inputs_by_name(u, [model]), "u")
    if given.ndim == 1 and control_step is None:
        given, control_step = given[None], duration
    step = dt if control_step is None else control_step
    if finite_array(step, "control_step").ndim or step <= 0.0:
        raise ValueError(f"control_step: got {step!r}, expected a number of seconds > 0")
    steps = number_of_control_steps(duration, step)
    if given.shape != (steps, count):
        expected = (
            f"({count},): one number per input" if steps == 1 else f"{steps, count}: (control steps, inputs)"
        )
        raise ValueError(f"u: got shape {given.shape}, expected {expected}")
    return given, step


def _weights(objective: Objective, t: Array, q: Array, v: Array) -> tuple[float, tuple[Array, Array]]:
    returned = objective(t, q, v)
    if not isinstance(returned, tuple) or len(returned) != 3:
        raise TypeError(
            f"objective: returned {type(returned).__name__}, expected (value, dvalue/dq, dvalue/dv): a "
            f"number of the whole run, and its derivatives by all states, each of the shape of q, {q.shape}"
        )
    on_q, on_v = (np.ascontiguousarray(part, float) for part in returned[1:])
    for name, part in (("q", on_q), ("v", on_v)):
        if part.shape != q.shape:
            raise ValueError(f"objective: dvalue/d{name} has shape {part.shape}, expected {q.shape}")
        if not np.isfinite(part).all():
            raise ValueError(f"objective: dvalue/d{name} is not finite, expected finite numbers")
    return float(returned[0]), (on_q, on_v)
