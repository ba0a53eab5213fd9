"""Derivatives of equilibria and of natural frequencies with respect to model parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import LissomError, Model, Robot, StaticsResult, check_model, statics
from ..common.arguments import keywords, suggesting, takes, whole
from ..common.interruption import Keeping
from .base import ParameterResult
from .parameters import OfModel, names_of, place_derivative, resolved

if TYPE_CHECKING:
    from ..common.arguments import Inputs

Array = NDArray[np.float64]

#: Objective of a gradient: a number, and its derivative with respect to the coordinates.
Objective = Callable[[Array], tuple[float, ArrayLike]]

#: Keywords of `equilibrium_sensitivity`, and the options of `statics` among them.
OF_STATICS = ("method", "load_steps", "tol", "max_iter", "max_steps")
KEYWORDS = ("q0", "objective", "frequencies", "t", "u", *OF_STATICS)

#: Frequencies with a smaller relative difference have no separate derivatives: a small change
#: of a parameter may turn one mode into the other.
DISTINCT = 1e-6

#: Largest asymmetry of a stiffness that counts as symmetric, relative to its largest entry.
SYMMETRIC = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class EquilibriumSensitivityResult(ParameterResult):
    """An equilibrium and its derivatives.

    It can be copied, pickled and saved, and has plots, reports and datasets.

    Attributes
    ----------
    names : tuple of str
        Names of the p parameters.
    q : ndarray, shape (n,)
        Coordinates of the equilibrium.
    dq : ndarray, shape (n, p), or None
        Derivatives with respect to the parameters; None if an objective was given.
    value : float or None
        Value of the objective.
    gradient : ndarray, shape (p,), or None
        Derivatives of the objective with respect to the parameters.
    frequencies : ndarray, shape (k,)
        The lowest undamped natural frequencies about the equilibrium, hertz.
    dfrequencies : ndarray, shape (k, p)
        Derivatives of the frequencies. NaN if a frequency is zero or agrees with another one to one part in a
        million.
    statics : StaticsResult
        The equilibrium with its stability and the solver's statistics.
    """

    # Pickles refer to the class by this module, where it has its methods.
    __module__ = "lissom"

    names: tuple[str, ...]
    q: Array
    dq: Array | None
    value: float | None
    gradient: Array | None
    frequencies: Array
    dfrequencies: Array
    statics: StaticsResult
    _model: Model
    _parameters: tuple[OfModel, ...]
    _t: float

    def __repr__(self) -> str:
        frequencies = f", {len(self.frequencies)} frequencies" if len(self.frequencies) else ""
        return (
            f"<EquilibriumSensitivityResult: with respect to {len(self.names)} parameters, "
            f"n = {len(self.q)}{frequencies}>"
        )

    def position(self, X: float | None = None, *, link: str | None = None) -> tuple[Array, Array]:
        """Position of a point of the robot, and its derivatives with respect to the parameters.

        Parameters
        ----------
        X : float, optional
            Arc length, metres; by default the tip.
        link : str, optional
            Name of the link; by default the last one.

        Returns
        -------
        position : ndarray, shape (3,)
            World position, metres.
        derivative : ndarray, shape (3, p)
            Metres per unit of each parameter.

        Raises
        ------
        ValueError, TypeError
            If the model has no places, or the derivatives were not computed.
        """
        if not isinstance(self._model, Robot):
            raise TypeError(
                f"model: expected a Rod or a Robot, got {type(self._model).__name__}, which has no places"
            )
        if self.dq is None:
            raise ValueError(
                "objective: with one, only derivatives of its value exist: leave it out for those of places"
            )
        place: dict[str, Any] = {"link": self._model.links[-1].name if link is None else link}
        position = self._model.pose(self.q, X, t=self._t, **place)[..., :3, 3]
        derivative = self._model.jacobian(self.q, X, t=self._t, **place)[3:] @ self.dq
        for i, parameter in enumerate(self._parameters):
            by_itself = place_derivative(parameter, self.q[None], X, np.array([self._t]), place)
            if by_itself is not None:
                derivative[:, i] += by_itself[0]
        return np.asarray(position), np.asarray(derivative)


@suggesting
def equilibrium_sensitivity(
    model: Model,
    parameters: Sequence[str],
    q0: ArrayLike | None = None,
    *,
    objective: Objective | None = None,
    frequencies: int = 0,
    t: float = 0.0,
    u: Inputs | None = None,
    **options: Any,
) -> EquilibriumSensitivityResult:
    """Differentiate an equilibrium and its natural frequencies with respect to model parameters.

    `statics` finds the equilibrium. The implicit function theorem gives
    ``dq/dp = -solve(dtau/dq, dtau/dp)``, which takes one factorisation and a few force evaluations per
    parameter.

    Parameters
    ----------
    model : Model
        A model without closed loops and inextensible tendons.
    parameters : sequence of str
        Model parameters by the names that `sweep` uses, such as 'rod[0].segment[0].young_modulus',
        'gravity[2]', 'link[1].joint.stiffness', or 'segments[*].radius' for a value that all segments share.
        All other numbers are held constant.
    q0 : array_like, shape (n,), optional
        As for `statics`.
    objective : callable, optional
        Scalar function of the shape. It is called once as ``objective(q)`` and returns its value and its
        derivative with respect to `q`, shape (n,). The gradient is then computed by the adjoint method, with
        one linear solve for any number of parameters.
    frequencies : int
        Number of undamped natural frequencies to differentiate, from the lowest. The derivatives include the
        change of the equilibrium. Each parameter costs about four tangents.
    t, u : optional
        As for `statics`.
    **options
        `method`, `load_steps`, `tol`, `max_iter`, `max_steps` as for `statics`.

    Returns
    -------
    EquilibriumSensitivityResult
        `q`, `dq` of shape (n, p), or `value` and `gradient` of shape (p,); `frequencies` and `dfrequencies`.

    Raises
    ------
    ValueError, TypeError
        Before the search, if an argument is invalid, a name is unknown, or nothing depends on a parameter.
    LissomError
        If no equilibrium is found, or its stiffness is singular; the message says so.
    KeyboardInterrupt
        On Ctrl-C. Its attribute `result` is the StaticsResult, complete or as `statics` keeps it.

    Examples
    --------
    >>> import lissom
    >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 4})
    >>> found = lissom.equilibrium_sensitivity(
    ...     lissom.Rod([wire]), ["segments[0].young_modulus", "segments[0].radius"], frequencies=1
    ... )
    >>> position, derivative = found.position()
    >>> derivative.shape, found.dfrequencies.shape
    ((3, 2), (1, 2))
    """
    check_model(model, "model")
    if objective is not None and not callable(objective):
        raise TypeError(f"objective: expected a callable, got {type(objective).__name__}")
    if objective is not None:
        takes("objective", objective, "q", "the coordinates of the equilibrium (n,)")
    whole("frequencies", frequencies)
    if not 0 <= frequencies <= model.n:
        raise ValueError(
            f"frequencies: got {frequencies}, expected 0 to {model.n}, the number of coordinates"
        )
    wanted = numbers_of(model, parameters)
    return differentiated(
        model, wanted, q0, objective=objective, frequencies=frequencies, t=t, u=u, **options
    )


def numbers_of(model: Model, parameters: Sequence[str]) -> list[OfModel]:
    """The parameters with these names, of a model whose equilibria are differentiated."""
    if getattr(model, "constraints", 0):
        raise ValueError(
            "model: expected one without closed loops and tendons that do not stretch, whose equilibria are "
            f"not differentiated; got one with {model.constraints} constraints"  # type: ignore[attr-defined]
        )
    wanted = []
    for parameter in resolved(model, names_of(parameters)):
        if not isinstance(parameter, OfModel):
            raise ValueError(
                f"parameters: got {parameter.name!r}, expected numbers of the model: equilibria have no start"
            )
        wanted.append(parameter)
    return wanted


def differentiated(
    model: Model,
    wanted: Sequence[OfModel],
    q0: ArrayLike | None,
    *,
    objective: Objective | None = None,
    frequencies: int = 0,
    t: float = 0.0,
    u: Inputs | None = None,
    **options: Any,
) -> EquilibriumSensitivityResult:
    """An equilibrium and its derivatives; the parameter data are shared by all equilibria of a model."""
    keywords("equilibrium_sensitivity", options, KEYWORDS)
    found = statics(model, q0, t=t, u=u, space_error=False, **options)
    if not found.success:
        raise LissomError(f"no equilibrium was found: {found.message}")
    with Keeping(found):
        return _derivatives(model, wanted, found, objective, frequencies, t, u)


def _derivatives(
    model: Model,
    wanted: Sequence[OfModel],
    found: StaticsResult,
    objective: Objective | None,
    frequencies: int,
    t: float,
    u: Inputs | None,
) -> EquilibriumSensitivityResult:
    q, rest = found.q, np.zeros(model.n)
    at: dict[str, Any] = {"t": t, "u": u}
    stiffness = model._tangent_at_rest(q, **at)[0]
    pushed = np.empty((model.n, len(wanted)))
    for i, parameter in enumerate(wanted):
        material = parameter.material
        if material is not None and material.section is None:
            of_segment = slice(material.first, material.first + len(material.stiffness))
            pushed[:, i] = 0.0
            pushed[of_segment, i] = material.stiffness @ q[of_segment]
            continue
        terms = [weight * other.inverse_dynamics(q, rest, rest, **at) for other, weight in parameter.terms]
        pushed[:, i] = np.sum(terms, axis=0)
    dq, value, gradient = None, None, None
    if objective is not None:
        value, weight = _value(objective, q)
        gradient = -_solved(stiffness.T, weight) @ pushed
    if objective is None or frequencies:
        dq = -_solved(stiffness, pushed)
    own, changes = np.empty(0), np.empty((0, len(wanted)))
    if frequencies:
        assert dq is not None
        own, changes = _frequencies(model, wanted, q, dq, frequencies, at)
    return EquilibriumSensitivityResult(
        names=tuple(parameter.name for parameter in wanted),
        q=q,
        dq=None if objective is not None else dq,
        value=value,
        gradient=gradient,
        frequencies=own,
        dfrequencies=changes,
        statics=found,
        _model=model,
        _parameters=tuple(wanted),
        _t=t,
    )


def _solved(stiffness: Array, right: Array) -> Array:
    # If the robot can move freely, the stiffness is singular and the derivative does not exist.
    if np.linalg.cond(stiffness) * np.finfo(float).eps > 1e-3:
        raise LissomError("the equilibrium is not determined by the parameters: its stiffness is singular")
    return np.asarray(np.linalg.solve(stiffness, right))


def _value(objective: Objective, q: Array) -> tuple[float, Array]:
    returned = objective(q)
    if not isinstance(returned, tuple) or len(returned) != 2:
        raise TypeError(f"objective: returned {type(returned).__name__}, expected (value, dvalue/dq)")
    weight = np.asarray(returned[1], float)
    if weight.shape != q.shape:
        raise ValueError(f"objective: dvalue/dq has shape {weight.shape}, expected {q.shape}")
    if not np.isfinite(weight).all():
        raise ValueError("objective: dvalue/dq is not finite, expected finite numbers")
    return float(returned[0]), weight


def _frequencies(
    model: Model, parameters: Sequence[OfModel], q: Array, dq: Array, count: int, at: dict[str, Any]
) -> tuple[Array, Array]:
    """The lowest frequencies and their derivatives (Fox and Kapoor 1968, equation 5), in hertz."""
    rest = np.zeros_like(q)
    stiffness, _, mass = model._tangent_at_rest(q, **at)
    if np.abs(stiffness - stiffness.T).max() > SYMMETRIC * np.abs(stiffness).max():
        raise LissomError(
            "frequencies: the stiffness is not symmetric, as under follower loads; only frequencies of "
            "symmetric ones are differentiated"
        )
    lower = np.linalg.cholesky(mass)
    halved = np.linalg.solve(lower, np.linalg.solve(lower, 0.5 * (stiffness + stiffness.T)).T)
    squares, vectors = np.linalg.eigh(0.5 * (halved + halved.T))
    # Normalised to unit mass.
    shapes = np.linalg.solve(lower.T, vectors)
    own = np.sqrt(np.maximum(squares[:count], 0.0)) / (2 * np.pi)
    changes = np.full((count, len(parameters)), np.nan)
    for i, parameter in enumerate(parameters):
        stiffness_change, mass_change = np.zeros((2, len(q), len(q)))
        for (other, value), weight in parameter.nearby:
            moved = q + dq[:, i] * (value - parameter.value)
            of_other, _, inertia = other.tangent(moved, rest, rest, **at)
            stiffness_change += weight * of_other
            mass_change += weight * inertia
        for k in range(count):
            gaps = np.abs(np.delete(squares, k) - squares[k])
            if gaps.size and gaps.min() <= 2 * DISTINCT * squares[k]:
                continue
            shape = shapes[:, k]
            push = shape @ (stiffness_change - squares[k] * mass_change) @ shape
            if own[k] > 0.0:
                changes[k, i] = push / (8 * np.pi**2 * own[k])
    return own, changes
