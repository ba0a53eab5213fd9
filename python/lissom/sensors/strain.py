"""Instruments of strain: fibres and strain gauges."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import finite_array
from ..common.arguments import suggesting
from . import places
from .sensor import Sensor
from .states import States

Array = NDArray[np.float64]

#: Maximum number of sections.
MOST_SECTIONS = 10_000


@dataclass(frozen=True, eq=False)
class OnRod(Sensor):
    """An instrument at one or more sections of a rod."""

    link: str | None = None
    at: ArrayLike | None = None
    _where: str = field(init=False, repr=False)
    #: Suffixes of the channels' names, one per section.
    _sections: tuple[str, ...] = field(init=False, repr=False)

    def _check(self) -> None:
        sections: tuple[str, ...] = ("",)
        if self.at is not None:
            at = finite_array(self.at, "at")
            if at.ndim > 1 or not 1 <= at.size <= MOST_SECTIONS:
                raise ValueError(f"at: expected 1 to {MOST_SECTIONS} numbers, got shape {at.shape}")
            if at.ndim == 1:
                sections = tuple(f"[{i}]" for i in range(at.size))
            self._set("at", tuple(at.tolist()) if at.ndim else float(at))
        self._set("_where", places.check(self.robot, self.link, self.at, of_rod=True))
        self._set("_sections", sections)

    def _place(self) -> str:
        return self._where

    def _strains(self, q: Array) -> Array:
        """Strains of k states, shape (k, sections, 6): torsion, bend_y, bend_z, stretch, shear_y, shear_z."""
        return self.robot.strain(q, self.at, link=self.link).reshape(len(q), len(self._sections), 6)


@suggesting
@dataclass(frozen=True, eq=False)
class CurvatureSensor(OnRod):
    """A curvature sensor, such as fibres with Bragg gratings.

    It measures torsion and bending about y and z, radians per metre, in the axes of the section, including
    the reference strain.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float or array_like, shape (s,), optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres, or s of them; channels are
        ordered by place. By default the tip.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    """

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        about = ("torsion", "bend_y", "bend_z")
        return tuple(f"{self.name}{section}.{each}" for section in self._sections for each in about)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("rad/m",) * len(self.channels)

    def _ideal(self, given: States) -> Array:
        return self._strains(given.q)[:, :, :3].reshape(len(given.q), len(self.channels))


@suggesting
@dataclass(frozen=True, eq=False)
class StrainGauge(OnRod):
    """A strain gauge along a rod: the relative change of length.

    It is attached at an offset from the axis and therefore measures bending, too. Temperature and the width
    of the gauge are not modelled.

    Parameters
    ----------
    robot : Robot
        Robot that carries the sensor.
    link : str, optional
        Name of the link; optional if the robot has only one.
    at : float or array_like, shape (s,), optional
        Arc length of the link's unstretched rod, 0 <= at <= length, metres, or s of them, one channel each.
        By default the tip.
    offset : array_like, shape (2,)
        Position in the section along y and z, metres; by default on the axis.
    name, noise, bias, rate, delay, seed
        Those of every `Sensor`.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.

    Notes
    -----
    A fibre at the offset d has the tangent ``u = gamma + kappa x d`` with the strains kappa and gamma of the
    rod. The gauge measures ``|u| / |u_0| - 1``, where u_0 is u at the reference strain.
    """

    offset: ArrayLike = (0.0, 0.0)
    _at_rest: Array = field(init=False, repr=False)

    def _check(self) -> None:
        super()._check()
        offset = finite_array(self.offset, "offset")
        if offset.shape != (2,):
            raise ValueError(f"offset: expected 2 numbers, along y and z, got shape {offset.shape}")
        self._set("offset", tuple(offset.tolist()))
        self._set("_at_rest", self._stretches(np.zeros((1, self.robot.n))))

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured quantities."""
        return tuple(f"{self.name}{section}" for section in self._sections)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the channels."""
        return ("1",) * len(self.channels)

    def _ideal(self, given: States) -> Array:
        return self._stretches(given.q) / self._at_rest - 1

    def _stretches(self, q: Array) -> Array:
        """``|u|`` for k states, shape (k, sections)."""
        torsion, bend_y, bend_z, stretch, shear_y, shear_z = np.moveaxis(self._strains(q), -1, 0)
        y, z = np.asarray(self.offset)
        along = stretch + bend_y * z - bend_z * y
        across = (shear_y - torsion * z, shear_z + torsion * y)
        stretches: Array = np.sqrt(along * along + across[0] * across[0] + across[1] * across[1])
        return stretches
