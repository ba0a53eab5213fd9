"""Base class of sensors: measurements, noise, bias, sampling rate and delay."""

from __future__ import annotations

import copy
import re
from abc import ABC, abstractmethod
from dataclasses import KW_ONLY, dataclass, field
from reprlib import repr
from typing import TYPE_CHECKING, Any, ClassVar, Self
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import Robot, finite_array, inputs_by_name
from ..common.arguments import explaining, text, whole
from . import states
from .line import Line
from .states import States

if TYPE_CHECKING:
    from ..common.arguments import InputRows, Inputs

Array = NDArray[np.float64]


#: What takes objects that have a state.
OF_OBJECTS = (
    "a state is t, q, v, a and u; `observe(simulation)` reads a simulation, `record(result)` a whole run"
)


@dataclass(frozen=True, eq=False)
class Sensor(ABC):
    """An instrument on a robot: the base class of all sensors.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    name : str, optional
        Name of the sensor; by default made of its kind and place.
    noise : float or array_like
        Standard deviation of white noise in the units of the channels, one number for all or one per channel.
        Every sample has independent noise.
    bias : float or array_like
        Constant added to every sample, one number for all channels or one per channel.
    rate : float, optional
        Samples per second, from the first reading on. Readings between two samples return the earlier one. By
        default every reading is a sample.
    delay : float
        Time from a sample until it can be read, seconds. Before the first sample arrives, readings return it
        as if the robot had been at rest.
    seed : int
        Seed of the noise, which is the same in every run. Sensors with different names have different noise.

    Attributes
    ----------
    channels : tuple of str
        Names of the measured quantities.
    units : tuple of str
        Units of the channels.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    robot: Robot
    _: KW_ONLY
    name: str = ""
    noise: ArrayLike = 0.0
    bias: ArrayLike = 0.0
    rate: float | None = None
    delay: float = 0.0
    seed: int = 0
    _line: Line = field(init=False, repr=False)
    _random: np.random.Generator = field(init=False, repr=False)

    #: Parts of the state that it needs beside time and coordinates: velocities "v", accelerations "a".
    NEEDS: ClassVar[str] = ""

    def __post_init__(self) -> None:
        if not isinstance(self.robot, Robot):
            raise TypeError(f"robot: expected a Robot, got {type(self.robot).__name__}")
        self._check()
        text("name", self.name)
        self._set("name", self.name or self._default_name())
        self._set("noise", self._of_channels(self.noise, "noise"))
        self._set("bias", self._of_channels(self.bias, "bias"))
        if (np.asarray(self.noise) < 0).any():
            raise ValueError(f"noise: got {repr(self.noise)}, expected standard deviations, not negative")
        if self.rate is not None:
            self._set("rate", number(self.rate, "rate"))
            if self.rate <= 0:
                raise ValueError(f"rate: got {self.rate}, expected samples per second, more than zero")
        self._set("delay", number(self.delay, "delay"))
        if self.delay < 0:
            raise ValueError(f"delay: got {self.delay}, expected seconds, not negative")
        self.reset(whole("seed", self.seed))

    @property
    @abstractmethod
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""

    @property
    @abstractmethod
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""

    @explaining(q=OF_OBJECTS)
    def measure(
        self,
        t: ArrayLike,
        q: ArrayLike,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        u: Inputs | None = None,
    ) -> Array:
        """Ideal measurement: without noise, bias, sampling and delay.

        Parameters
        ----------
        t : float or array_like, shape (k,)
            Time of the state, or of each of the k states, seconds.
        q, v, a : array_like, shape (n,) or (k, n)
            Coordinates, velocities and accelerations, as far as the sensor needs them.
        u : array_like, shape (m,) or (k, m), or dict, optional
            Inputs of the robot, or some of them by name.

        Returns
        -------
        values : ndarray, shape (channels,) or (k, channels)

        Raises
        ------
        ValueError, TypeError
            If an argument is invalid.
        """
        given, is_one = self._states(t=t, q=q, v=v, a=a, u=u)
        values = self._ideal(given)
        return values[0] if is_one else values

    @explaining(q=OF_OBJECTS)
    def read(
        self,
        t: float,
        q: ArrayLike,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        u: Inputs | None = None,
    ) -> Array:
        """Current reading of the sensor, for use in a loop.

        Parameters
        ----------
        t : float
            Current time, seconds, not before the last reading. A second reading at the same time returns the
            first one.
        q, v, a : array_like, shape (n,)
            Coordinates, velocities and accelerations, as far as the sensor needs them.
        u : array_like, shape (m,), or dict, optional
            Inputs of the robot, or some of them by name.

        Returns
        -------
        values : ndarray, shape (channels,)

        Raises
        ------
        ValueError, TypeError
            If an argument is invalid; the sensor is unchanged.
        """
        given, is_one = self._states(t=t, q=q, v=v, a=a, u=u)
        if not is_one:
            raise ValueError(f"q: expected one state, got {len(given.q)}: `measure` and `record` take many")
        shown = self._line.read(float(given.t[0]), lambda: self._sampled(given, self._random)[0])
        return shown.copy()

    def observe(self, simulation: Any) -> Array:
        """Reading from an object that has a state: `read` with its `t`, `q`, `v`, `a` and `u`.

        Parameters
        ----------
        simulation : Simulation
            A simulation, or another object with these attributes, as far as the sensor needs them; `u` is
            optional.

        Returns
        -------
        values : ndarray, shape (channels,)

        Raises
        ------
        ValueError, TypeError
            As for `read`.
        """
        return self.read(**self._parts(simulation, "simulation"))

    def record(self, result: Any, u: InputRows | None = None) -> Array:
        """Readings of a new copy of this sensor at each time of a finished run.

        The state of this sensor does not change. Without a `rate`, this takes one evaluation per time, all in
        native code.

        Parameters
        ----------
        result : MotionResult
            Result of `lissom.simulate` with this robot, or another object with `t` (k,), `q`, `v` and `a`
            (k, n), as far as the sensor needs them.
        u : array_like, shape (m,) or (k, m), or dict, optional
            Inputs of the robot, or some of them by name; by default those of the result, if it has any.

        Returns
        -------
        values : ndarray, shape (k, channels)

        Raises
        ------
        ValueError, TypeError
            If an argument is invalid.
        """
        parts = self._parts(result, "result")
        if u is not None:
            parts["u"] = u
        given, is_one = self._states(**parts)
        if is_one:
            raise ValueError("result: expected many states, got one: `observe` takes it")
        if (np.diff(given.t) < 0).any():
            raise ValueError("result.t: expected times that do not decrease")
        taken = self._line.taken(given.t)
        samples = self._sampled(given[taken], self._new_random())
        shown = self._line.shown(given.t, given.t[taken])
        return samples[shown]

    def reset(self, seed: int | None = None) -> None:
        """Discard all samples and restart the noise.

        Parameters
        ----------
        seed : int, optional
            Seed of the noise from now on; by default the current one.
        """
        if seed is not None:
            if whole("seed", seed) < 0:
                raise ValueError(f"seed: got {repr(seed)}, expected a whole number, not negative")
            self._set("seed", whole("seed", seed))
        self._set("_line", Line(self.rate, self.delay))
        self._set("_random", self._new_random())

    def copy(self) -> Self:
        """An independent copy in the same state."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin._set("_line", copy.deepcopy(self._line))
        twin._set("_random", copy.deepcopy(self._random))
        return twin

    def __copy__(self) -> Self:
        return self.copy()

    # To be implemented by each kind of sensor.

    @abstractmethod
    def _check(self) -> None:
        """Check and complete the data of this kind of sensor."""

    @abstractmethod
    def _place(self) -> str:
        """The place, for the default name."""

    @abstractmethod
    def _ideal(self, given: States) -> Array:
        """Ideal measurements (k, channels) of k states; each row must not depend on k."""

    def _errors(self) -> int:
        """Number of noise components."""
        return len(self.channels)

    def _with_errors(self, ideal: Array, errors: Array) -> Array:
        return ideal + errors

    # Derived from these.

    def _default_name(self) -> str:
        kind = re.sub(r"(?<!^)(?=[A-Z])", "_", type(self).__name__).lower()
        return f"{self._place()}.{kind}"

    def _sampled(self, given: States, random: np.random.Generator) -> Array:
        ideal = self._ideal(given)
        noise, bias = np.asarray(self.noise), np.asarray(self.bias)
        if noise.any():
            return self._with_errors(ideal, bias + noise * random.standard_normal((len(ideal), len(noise))))
        if bias.any():
            return self._with_errors(ideal, np.tile(bias, (len(ideal), 1)))
        return ideal

    def _new_random(self) -> np.random.Generator:
        return np.random.default_rng([self.seed, crc32(self.name.encode(errors="surrogatepass"))])

    def _states(self, **given: Any) -> tuple[States, bool]:
        if given.get("u") is not None:
            given["u"] = inputs_by_name(given["u"], [self.robot])
        return states.of(self.robot.n, self.NEEDS, self.name, **given)

    def _parts(self, source: Any, name: str) -> dict[str, Any]:
        """The parts of an object's state that the sensor needs."""
        parts = {}
        for part in ("t", "q", *self.NEEDS):
            parts[part] = getattr(source, part, None)
            if parts[part] is None:
                expected = ", ".join(("t", "q", *self.NEEDS))
                raise TypeError(f"{name}: expected an object with {expected}, got {type(source).__name__}")
        parts["u"] = getattr(source, "u", None)
        return parts

    def _of_channels(self, value: ArrayLike, name: str) -> tuple[float, ...]:
        """One number per channel."""
        array = finite_array(value, name)
        if array.shape not in ((), (self._errors(),)):
            raise ValueError(f"{name}: expected a number or {self._errors()}, got shape {array.shape}")
        return tuple(np.broadcast_to(array, self._errors()).tolist())

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


def number(value: Any, name: str) -> float:
    """A finite number."""
    array = finite_array(value, name)
    if array.ndim:
        raise ValueError(f"{name}: expected a number, got shape {array.shape}")
    return float(array)
