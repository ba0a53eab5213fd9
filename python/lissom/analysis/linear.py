"""Linear state-space models of small motions about an equilibrium: ``x' = A x + B u``, ``y = C x + D u``."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import (
    AccuracyWarning,
    Input,
    LissomError,
    Model,
    Motor,
    Robot,
    Tendon,
    check_model,
    did_you_mean,
    inputs_by_name,
    jacobian,
)
from ..common.arguments import explaining, flag, sequence, suggesting
from ..common.elsewhere import no_attribute
from ..model.views import Frame, View, view
from ..sensors.sensor import Sensor
from .measured import readings, sensors_of

if TYPE_CHECKING:
    from ..common.arguments import Inputs

Array = NDArray[np.float64]

_CONTROL = "`control.ss(*linear)` makes a system of the package `control`, which has this"

#: What to use in place of attributes that a linear model does not have.
INSTEAD: Mapping[str, str] = {
    **dict.fromkeys(
        ("c2d", "discretize", "discretise", "sample", "to_discrete"), "`discrete(dt)` samples it"
    ),
    **dict.fromkeys(
        ("to_ss", "ss", "to_statespace"), "`control.ss(*linear)` or `scipy.signal.StateSpace(*linear)`"
    ),
    **dict.fromkeys(
        ("lqr", "place", "dlqr"), "`control.lqr(linear.A, linear.B, Q, R)` and others take its matrices"
    ),
    **dict.fromkeys(
        ("bode", "nyquist", "step", "impulse", "transfer_function", "tf", "frequency_response"), _CONTROL
    ),
    **dict.fromkeys(("eigenvalues", "eig", "eigs"), "`numpy.linalg.eigvals(linear.A)`"),
    **dict.fromkeys(("dcgain", "poles", "zeros", "damp", "simulate", "lsim"), _CONTROL),
}

#: Axes of the world.
AXES = "xyz"

#: Rows of geometric Jacobians.
ANGULAR, LINEAR = slice(3), slice(3, 6)


#: More names than these are listed by the first and the last one.
LISTED = 6


def _few(names: Sequence[str]) -> str:
    return ", ".join(names if len(names) <= LISTED else (names[0], "...", names[-1]))


@dataclass(frozen=True, repr=False)
class LinearModel:
    """A linear model ``x' = A x + B u``, ``y = C x + D u`` of small motions about an equilibrium.

    All signals are deviations from their values at the equilibrium. ``control.ss(*model)`` and
    ``scipy.signal.StateSpace(*model)`` take it as it is: iterating gives A, B, C, D.

    Attributes
    ----------
    A : ndarray, shape (2 n, 2 n)
        State matrix. The state consists of the n coordinates and the n velocities.
    B : ndarray, shape (2 n, p)
        Input matrix.
    C : ndarray, shape (r, 2 n)
        Output matrix.
    D : ndarray, shape (r, p)
        Feedthrough matrix: zero but for sensors of accelerations and forces.
    states, inputs, outputs : tuple of str
        Names of states, inputs and outputs.
    dt : float or None
        Time between samples of a model in discrete time, seconds: ``x[k+1] = A x[k] + B u[k]``.
    """

    # Pickles refer to the class by this module, whatever moves.
    __module__ = "lissom"

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    dt: float | None = None

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            no_attribute(self, name, INSTEAD)

    def __repr__(self) -> str:
        when = "" if self.dt is None else f", sampled every {self.dt:g} s"
        return (
            f"<LinearModel: {len(self.states)} states, inputs {_few(self.inputs)}, outputs "
            f"{_few(self.outputs)}{when}>"
        )

    @suggesting
    def discrete(self, dt: float, *, delay: float = 0.0) -> LinearModel:
        """The model in discrete time: inputs are held between samples, and act after a delay.

        The result is exact at the samples. ``control.ss(*discrete, dt)`` takes it.

        Parameters
        ----------
        dt : float
            Time between samples, seconds.
        delay : float
            Time from setting the inputs until they act, seconds, up to 1000 samples. Delays of sensors and of
            the computation add to it. What is under way is part of the state: one state for each input and
            sample, named ``pull[-1]`` and so on.

        Returns
        -------
        LinearModel

        Raises
        ------
        ValueError, TypeError
            If an argument is invalid, or the model is in discrete time already.
        ImportError
            If SciPy is not installed (extra `fit`).

        Examples
        --------
        >>> import lissom
        >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 3}, retardation_time=1e-4)
        >>> rod = lissom.Rod([wire])
        >>> linear = lissom.linearise(rod, lissom.statics(rod).q, "tip_force_z", "tip_position_z")
        >>> sampled = linear.discrete(1e-3, delay=1.5e-3)
        >>> sampled.A.shape, sampled.states[-2:], sampled.dt
        ((8, 8), ('tip_force_z[-1]', 'tip_force_z[-2]'), 0.001)
        """
        from .discrete import held

        if self.dt is not None:
            raise ValueError(f"the model is in discrete time already, with dt = {self.dt:g} s")
        matrices, kept = held(self, dt, delay)
        for matrix in matrices:
            matrix.flags.writeable = False
        under_way = (f"{name}[-{age}]" for age in range(1, kept + 1) for name in self.inputs)
        A, B, C, D = matrices
        states = (*self.states, *under_way)
        return LinearModel(A, B, C, D, states, self.inputs, self.outputs, float(dt))

    def __iter__(self) -> Iterator[Array]:
        """A, B, C, D."""
        return iter((self.A, self.B, self.C, self.D))


@explaining(q="the state about which it is linear, such as `lissom.statics(model).q`")
def linearise(
    model: Model,
    q: ArrayLike,
    inputs: str | Sequence[str] = "forces",
    outputs: str | Sensor | Sequence[str | Sensor] = "coordinates",
    *,
    t: float = 0.0,
    u: Inputs | None = None,
    held: bool = False,
) -> LinearModel:
    """Linearise the equations of motion about an equilibrium, with exact tangents.

    Parameters
    ----------
    model : Model
        A `Rod`, a `Robot` or a `SpringPendulum`.
    q : array_like, shape (n,)
        Coordinates of the equilibrium, such as `q` from `statics`. At other shapes the result is the linear
        model about rest with constant generalised forces that hold the shape, and there is a warning.
    inputs : str or sequence of str
        Inputs of the linear model. 'forces' are the n generalised forces. For rods, 'tip_force' and
        'tip_moment' have three components each in world axes; 'tip_force_z' is a single component. For
        robots, the name of a link without children replaces 'tip'. 'inputs' is the whole input vector u of
        the model; a single input goes by its name, such as 'pull', unless that is one of the names above. The
        length of an inextensible tendon cannot be an input, because it sets coordinates, not forces.
    outputs : str, Sensor or sequence of these
        Outputs of the linear model: 'coordinates', 'velocities' (n each); for rods 'tip_position',
        'tip_rotation' (a small rotation vector), 'tip_velocity', 'tip_angular_velocity' (three components
        each in world axes), or a single component such as 'tip_position_z'; for robots named as for `inputs`.
        A sensor of `lissom.sensors` on this robot stands for all its channels, without noise, bias, rate and
        delay. Central differences give derivatives of sensors, and the part of the outputs that is due to
        prescribed motions, which move links at velocities that depend on q.
    t : float
        Time at which time-dependent loads and motions are evaluated, seconds.
    u : array_like, shape (m,), or dict, optional
        Inputs at the equilibrium; by default `u0` of the model.
    held : bool
        Whether constant generalised forces hold the shape if it is no equilibrium, such as those of motors
        that are not part of the model: then there is no warning.

    Returns
    -------
    LinearModel
        `A`, `B`, `C`, `D` and the names of `states`, `inputs`, `outputs`. With closed loops the states belong
        to independent coordinates: the number of coordinates minus the number of independent constraints.
        Robots use the names of their coordinates, with ".rate" for velocities and ".force" for generalised
        forces; other models use `q0`, `v0`, `force0` and so on.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid, `q` is a shape that the model does not resolve, or a load is not finite
        at `t`.
    LissomError
        If the mass matrix is not positive definite, or a value is not finite.

    Warns
    -----
    AccuracyWarning
        If `q` is no equilibrium: at rest there, the model would move by more than a thousandth of its size
        within a second. If a motor is at one of its `limits`, where its input changes nothing.

    Examples
    --------
    >>> import lissom
    >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 3}, retardation_time=1e-4)
    >>> rod = lissom.Rod([wire])
    >>> linear = lissom.linearise(rod, lissom.statics(rod).q, inputs="tip_force_z", outputs="tip_position_z")
    >>> linear.A.shape, linear.B.shape, linear.C.shape
    ((6, 6), (6, 1), (1, 6))
    >>> linear.inputs, linear.outputs
    (('tip_force_z',), ('tip_position_z',))
    """
    check_model(model, "model")
    held = flag("held", held)
    n = model.n
    model.check_shape(q)
    q = np.asarray(q, float)
    values = None if u is None else inputs_by_name(u, [model])
    stiffness, damping, mass = model._tangent_at_rest(q, t=t, u=values)
    seen = view(model)
    force_names, forces = _signals("inputs", inputs, _forces(model, seen, q, t, u), n)
    _check_inputs(model, force_names)
    wanted = (
        outputs if isinstance(outputs, str | Sensor) else sequence("outputs", outputs, "names and sensors")
    )
    groups = _measurements(model, seen, q, t)
    for sensor in sensors_of(model, wanted, force_names):
        groups[sensor.name] = readings(sensor, force_names, q, t, values)
    output_names, rows = _signals("outputs", wanted, groups, 3 * n + len(force_names))
    try:
        np.linalg.cholesky(mass)
    except np.linalg.LinAlgError:
        raise LissomError(
            "the mass matrix at q is not positive definite: no acceleration exists there; look at "
            "numpy.linalg.cond(model.mass_matrix(q))"
        ) from None
    if not all(np.isfinite(part).all() for part in (stiffness, damping, mass, forces, rows)):
        raise LissomError(
            f"stiffness, damping, masses or signals at q and t = {t:g} are NaN or infinite: there is no "
            "linear model; take a smaller q"
        )
    coordinates, velocities, _ = _names(seen, n)
    free_motions = np.eye(n)
    if isinstance(model, Robot) and model.constraints > 0:
        free, within, of_loops = _within_loops(model, q, mass, t, u)
        stiffness = within.T @ (stiffness + of_loops) @ within
        mass, damping = (within.T @ part @ within for part in (mass, damping))
        forces = forces @ within
        rows = np.hstack([*(rows[:, k * n : (k + 1) * n] @ within for k in range(3)), rows[:, 3 * n :]])
        coordinates, velocities = [coordinates[k] for k in free], [velocities[k] for k in free]
        n, free_motions = len(free), within
    if not held and (found := _moves_off(model, seen, q, t, u, (stiffness, mass, free_motions))):
        warnings.warn(found, AccuracyWarning, stacklevel=3)
    if found := _saturated(model, q, t, u):
        warnings.warn(found, AccuracyWarning, stacklevel=3)
    solved = np.linalg.solve(mass, np.hstack([-stiffness, -damping, forces.T]))
    A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), solved[:, : 2 * n]])
    B = np.vstack([np.zeros((n, len(force_names))), solved[:, 2 * n :]])
    # Outputs by coordinates, velocities, accelerations and inputs; accelerations follow from the others.
    by_state, by_acceleration, by_input = np.split(rows, [2 * n, 3 * n], axis=1)
    C = by_state + by_acceleration @ solved[:, : 2 * n]
    D = by_input + by_acceleration @ solved[:, 2 * n :]
    for matrix in (A, B, C, D):
        matrix.flags.writeable = False
    return LinearModel(A, B, C, D, (*coordinates, *velocities), force_names, output_names)


#: Time in seconds, and displacement within it relative to the size of a model, from which on a shape is no
#: equilibrium: that of `statics` is right to about 1e-9, and rounding q to four digits leaves less.
WITHIN, AWAY = 1.0, 1e-3


def _moves_off(
    model: Model,
    seen: View,
    q: Array,
    t: float,
    u: Inputs | None,
    tangents: tuple[Array, Array, Array],
) -> str | None:
    """What is wrong with a shape that is no equilibrium: the model at rest there would move off.

    `tangents` are stiffness and mass of the independent coordinates, and the map from them to all.
    """
    stiffness, mass, within = tangents
    rest = np.zeros(model.n)
    forces = -within.T @ model.inverse_dynamics(q, rest, rest, t=t, u=u)
    # As far as springs let it go, or inertia in this time.
    moved = within @ np.linalg.lstsq(stiffness + mass / WITHIN**2, forces, rcond=None)[0]
    twists = [frame.jacobian(q, t) @ moved for frame in seen.frames]
    turns = [np.linalg.norm(twist[ANGULAR]) for twist in twists]
    places = [np.linalg.norm(twist[LINEAR]) for twist in twists]
    # Without a size: angles in radians, lengths in metres.
    share = max(places) / seen.size if places and seen.size > 0.0 else np.abs(moved).max(initial=0.0)
    # Links that turn where they are, such as pendulums whose bodies are beside the axis.
    share = float(share if share > AWAY or not turns else max(turns))
    if not share > AWAY:
        return None
    largest = int(np.abs(forces).argmax())
    return (
        f"q is no equilibrium: the generalised forces there, up to {abs(forces[largest]):.3g}, would move "
        f"the model by about {share:.2g} of its size, or radians, and the linear model leaves them out. "
        "Take `q` of `lissom.statics(model, u=u)` with the same inputs, or `held=True` if something holds "
        "the shape."
    )


#: A motor this close to a limit, relative to its range, is saturated: saturation is smooth over a thousandth.
AT_LIMIT = 2e-3


def _saturated(model: Model, q: Array, t: float, u: Inputs | None) -> str | None:
    """What is lost because motors are at their limits."""
    rest = np.zeros(model.n)
    names = []
    for motor in (each for each in getattr(model, "actuators", ()) if isinstance(each, Motor)):
        if motor.limits is None:
            continue
        low, high = motor.limits
        force = float(model.actuator_force(motor.name, q, rest, t=t, u=u))  # type: ignore[attr-defined]
        if min(force - low, high - force) <= AT_LIMIT * (high - low):
            names.append(f"{motor.name!r} ({force:.4g}, limits {low:g} and {high:g})")
    if not names:
        return None
    return (
        f"Motors at their limits: {', '.join(names)}. No command changes their force there, so that in the "
        "linear model their inputs have no effect, and their gains give no stiffness and damping. "
        "Linearise about inputs within the limits, or leave `limits` out of the model for this."
    )


def _check_inputs(model: Model, names: Sequence[str]) -> None:
    """Reject inputs that prescribe coordinates instead of forces."""
    tendons = [each for each in getattr(model, "actuators", ()) if isinstance(each, Tendon)]
    for tendon in tendons:
        length = tendon.length
        if tendon.stiffness is None and isinstance(length, Input) and length.name in names:
            raise ValueError(
                f"inputs: got {length.name!r}, the length of the tendon {tendon.name!r} that does not "
                "stretch, expected inputs that act by forces: a length moves a taut tendon at once; give the "
                "tendon a `stiffness`, or name the other inputs"
            )


#: Rows of the constraint Jacobian whose independent part is smaller than this are redundant.
DEPENDENT = 1e-8


def _within_loops(
    robot: Robot, q: Array, mass: Array, t: float, u: Inputs | None
) -> tuple[list[int], Array, Array]:
    """Independent coordinates, the map from them to all coordinates, and the stiffness of loops.

    The dependent coordinates are those that close the loops with the least inertia: Gram-Schmidt
    orthogonalisation of the columns of the gaps' derivative, with the largest remainder first.
    """
    n = robot.n
    parts = robot._loops_at_rest(q, t=t, u=u)
    stiffness, jacobian = parts[:n], parts[n:]
    lengths = np.linalg.norm(jacobian / np.sqrt(np.diag(mass)), axis=1)
    is_moved = lengths > DEPENDENT * lengths.max(initial=0.0)
    jacobian = jacobian[is_moved] / lengths[is_moved, None]
    left = jacobian / np.sqrt(np.diag(mass))
    largest = np.linalg.norm(left, 2) if left.size else 0.0
    dependent: list[int] = []
    for _ in range(min(left.shape)):
        sizes = np.linalg.norm(left, axis=0)
        k = int(np.argmax(sizes))
        if sizes[k] <= DEPENDENT * largest:
            break
        dependent.append(k)
        unit = left[:, k] / sizes[k]
        left = left - np.outer(unit, unit @ left)
        left[:, dependent] = 0.0
    free = [k for k in range(n) if k not in dependent]
    within = np.zeros((n, len(free)))
    within[free, range(len(free))] = 1.0
    if not dependent:
        # All tendons of given length are slack.
        return free, within, stiffness
    within[dependent] = -np.linalg.lstsq(jacobian[:, dependent], jacobian[:, free], rcond=None)[0]
    return free, within, stiffness


def _names(seen: View, n: int) -> tuple[list[str], list[str], list[str]]:
    """Names of coordinates, velocities and generalised forces."""
    names = seen.signals
    if names is not None:
        return list(names), [f"{name}.rate" for name in names], [f"{name}.force" for name in names]
    numbers = range(n)
    return [f"q{i}" for i in numbers], [f"v{i}" for i in numbers], [f"force{i}" for i in numbers]


#: Names of signals of one kind, with the rows of the matrix that belongs to them.
Group = tuple[list[str], Callable[[], Array]]


def _forces(model: Model, seen: View, q: Array, t: float, u: Inputs | None) -> dict[str, Group]:
    """Generalised forces of unit inputs, as rows."""
    n = model.n
    groups: dict[str, Group] = {"forces": (_names(seen, n)[2], lambda: np.eye(n))}
    for frame in seen.frames:
        for name, rows in (("force", LINEAR), ("moment", ANGULAR)):
            groups[f"{frame.name}_{name}"] = (
                _components(f"{frame.name}_{name}"),
                partial(_jacobian, frame, rows, q, t),
            )
    return groups | _inputs(model, q, t, u)


def _inputs(model: Model, q: Array, t: float, u: Inputs | None) -> dict[str, Group]:
    """Generalised forces per unit of each input: all inputs, and the vector inputs among them."""
    names = list(model.inputs)
    if not names:
        return {}

    def forces() -> Array:
        # Opposite sign: inverse dynamics returns the force that balances the inputs.
        return -model.input_tangent(q, t=t, u=u).T

    groups: dict[str, Group] = {"inputs": (names, forces)}
    for name in (name.removesuffix(".x") for name in names if name.endswith(".x")):
        members = _vector(name)
        if members == names[names.index(members[0]) :][:3]:
            groups[name] = (members, partial(_part, forces, names.index(members[0])))
    return groups


def _vector(name: str) -> list[str]:
    """Names of the components of a vector input."""
    return [f"{name}.{axis}" for axis in AXES]


def _part(rows: Callable[[], Array], first: int) -> Array:
    return rows()[first : first + len(AXES)]


def _jacobian(frame: Frame, rows: slice, q: Array, t: float) -> Array:
    return frame.jacobian(q, t)[rows]


def _measurements(model: Model, seen: View, q: Array, t: float) -> dict[str, Group]:
    """Outputs of unit states, as rows."""
    n = model.n
    of_q, of_v = np.eye(2 * n)[:n], np.eye(2 * n)[n:]
    groups: dict[str, Group] = {
        "coordinates": (_names(seen, n)[0], lambda: of_q),
        "velocities": (_names(seen, n)[1], lambda: of_v),
    }
    for frame in seen.frames:
        for name, rows in _motions(frame, seen.carrier_velocity, q, t, of_q, of_v).items():
            groups[f"{frame.name}_{name}"] = (_components(f"{frame.name}_{name}"), rows)
    return groups


def _motions(
    frame: Frame, carrier: Callable[[float], Array] | None, q: Array, t: float, of_q: Array, of_v: Array
) -> dict[str, Callable[[], Array]]:
    """Motion of a frame, as rows; ``carrier`` is the angular velocity of the base."""

    def velocity() -> Array:
        moved = frame.jacobian(q, t)[LINEAR]
        rows = moved @ of_v
        if carrier is not None:
            # The linear velocity depends on the position; the angular velocity does not.
            rows += np.cross(carrier(t), moved, axisb=0, axisc=0) @ of_q
        return rows + carried(LINEAR)

    def carried(rows: slice) -> Array:
        """Derivative of the part of the velocity that is due to prescribed motions."""
        along = frame.carried
        if along is None:
            return np.zeros((3, of_q.shape[1]))
        return jacobian(lambda q: along(q, t), q)[rows] @ of_q

    return {
        "position": lambda: frame.jacobian(q, t)[LINEAR] @ of_q,
        "rotation": lambda: frame.jacobian(q, t)[ANGULAR] @ of_q,
        "velocity": velocity,
        "angular_velocity": lambda: frame.jacobian(q, t)[ANGULAR] @ of_v + carried(ANGULAR),
    }


def _components(name: str) -> list[str]:
    return [f"{name}_{axis}" for axis in AXES]


def _signals(
    argument: str, wanted: str | Sensor | Sequence[str | Sensor], groups: dict[str, Group], width: int
) -> tuple[tuple[str, ...], Array]:
    """Names and rows of the requested signals, groups or single ones; what depends on less is zero beyond."""
    names: list[str] = []
    rows: list[Array] = []
    for each in [wanted] if isinstance(wanted, str | Sensor) else sequence(argument, wanted, "names"):
        name = each.name if isinstance(each, Sensor) else each
        group = next((key for key, (members, _) in groups.items() if name == key or name in members), None)
        if group is None:
            expected = ", ".join(repr(key) for key in groups)
            known = [*groups, *(member for members, _ in groups.values() for member in members)]
            meant = did_you_mean(name, known) if isinstance(name, str) else None
            meant = f"; {meant}" if meant else ""
            raise ValueError(f"{argument}: got {name!r}, expected {expected} or a component of them{meant}")
        members, matrix = groups[group]
        chosen = members if name == group else [name]
        names += chosen
        part = matrix()[[members.index(member) for member in chosen]]
        rows.append(np.pad(part, ((0, 0), (0, width - part.shape[1]))))
    if not rows:
        raise ValueError(f"{argument}: got none, expected at least one")
    return tuple(names), np.vstack(rows)
