"""Advice on a scene before it is run: what its step, modes and method resolve, and implausible units."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._lissom import (
    DOP853,
    RK45,
    AccuracyWarning,
    Ball,
    Contact,
    LissomError,
    Model,
    Robot,
    Scene,
    Segment,
    SimulationSettings,
    modes,
    statics,
)
from ..model.fibres import STRAINS
from ..model.starts import rest_start
from ..model.views import Link, is_rod, view

FIXED_STEP = ("newmark", "hht", "generalised_alpha")
EXPLICIT: dict[str, type[RK45] | type[DOP853]] = {"rk45": RK45, "dop853": DOP853}

#: A period of this many steps is resolved; average acceleration makes it (2 pi / 10)^2 / 12 (3 %) longer.
STEPS_PER_PERIOD = 10

#: A natural frequency counts as accurate if more modes of every strain change it by less than this.
RIGHT = 0.01

#: This many accurate frequencies are enough: the fastest ones of any model are inaccurate and seldom excited.
ENOUGH = 3

#: Ratio of length to radius below which shear deflection is checked.
SLENDER = 10.0

#: A model counts as stiff if stability needs this many times the steps that resolve the slowest vibration.
STIFF = 30.0

#: Growth in a step that counts as stable: undamped oscillations may grow by the method's own error.
STABLE_GROWTH = 1e-3

#: An impact that lasts this many steps is resolved. Shorter ones are computed without rebound.
STEPS_PER_IMPACT = 3

#: Larger models are not analysed, so that checking stays quick.
MOST_COORDINATES = 100

#: Where a doubt about a run says which steps to take.
_STEPS = re.compile(r"[Tt]ake (steps of|`dt=|shorter steps)")

#: What equilibria say where axial forces would stretch a rod whose stretch has no modes.
_OF_STRETCH = re.compile(r"Stretch has no modes .*? `modes` of stretch\.")

#: The shear strain in the direction in which a bending strain deflects.
SHEAR_OF = {"bend_y": "shear_z", "bend_z": "shear_y"}


def size(model: Model) -> str:
    """Size of a model in words."""
    actuators = len(getattr(model, "actuators", ()))
    moved = f", {actuators} actuator{'' if actuators == 1 else 's'}" if actuators else ""
    return f"{model.n} generalised coordinates{moved}"


def advice(scene: Scene, doubt: str | None = None) -> list[str]:
    """Advice on a scene before it is run, one or two sentences each; often empty.

    Natural frequencies are those about the equilibrium of the model. They are left out if no equilibrium is
    found, and for models of more than 100 coordinates. After a run, whose doubt is given, nothing is said of
    steps if the doubt names some: it follows from what has moved, and other numbers would contradict it.
    """
    names_steps = doubt is not None and _STEPS.search(doubt) is not None
    model = scene.model
    said = about_model(model)
    t0 = scene.simulation.t0
    said += about_inputs(model)
    said += about_slack(scene)
    if not names_steps:
        said += about_impacts(scene)
    found = Vibrations.of(model, t0, rest_start(scene))
    if found is None:
        return said
    said += [found.stretch] if found.stretch else []
    if not names_steps:
        said += about_step(found, scene.simulation)
    said += about_stability(found, scene.simulation)
    # Robots of several links have frequencies of joints, too; with more nodes contacts act elsewhere.
    return said + about_modes(found) if is_rod(model) else said


def about_model(model: Model) -> list[str]:
    """Advice on a model alone: implausible units, and shear that it leaves out."""
    units = implausible_units(model)
    shear = [sentence for link in view(model).links for sentence in about_shear(link)]
    return [*units, *shear]


def implausible_units(model: Model) -> list[str]:
    """Questions about numbers that are probably in other units than SI."""
    return model._implausible_units() if isinstance(model, Robot) else []


def about_inputs(model: Model) -> list[str]:
    """Inputs that keep their defaults without a controller."""
    if not model.inputs:
        return []
    values = ", ".join(f"{name} = {value:g}" for name, value in zip(model.inputs, model.u0, strict=True))
    return [f"Without a controller, inputs keep their defaults: {values}."]


def about_slack(scene: Scene) -> list[str]:
    """Tendons that are slack at the start."""
    if not getattr(scene.model, "actuators", ()):
        return []
    start = scene.q0[None], scene.v0[None], np.array([scene.simulation.t0]), scene.model.u0[None]
    actuators = view(scene.model).glyphs.actuators
    slack = [repr(glyph.name) for glyph in actuators if glyph.is_let_out and not glyph.force(*start).any()]
    if not slack:
        return []
    return [f"Slack at the start, because their paths are shorter than their lengths: {', '.join(slack)}."]


def about_impacts(scene: Scene) -> list[str]:
    """The stiffest contact whose impacts a fixed step does not resolve.

    A rod that lies on a stiffness k per length with the mass m per length is thrown back after
    pi sqrt(m / k); two of them, of the masses m1 and m2, after that of m1 m2 / (m1 + m2).
    """
    settings = scene.simulation
    if settings.method not in FIXED_STEP:
        return []
    model = scene.model
    times = [(impact_time(model, contact), contact.name) for contact in getattr(model, "contacts", ())]
    known = [(time, name) for time, name in times if time is not None]
    if not known:
        return []
    shortest, name = min(known)
    if STEPS_PER_IMPACT * settings.dt <= shortest:
        return []
    needed = shortest / STEPS_PER_IMPACT
    return [
        f"The step of {settings.dt:g} s does not resolve impacts of {name!r}, which last {shortest:.2g} s: "
        "surfaces that collide lose their energy instead of bouncing; "
        f"to see the rebound use steps of {needed:.2g} s."
    ]


def impact_time(model: Model, contact: Contact) -> float | None:
    """Duration of a slow impact of rods, seconds; None if neither surface is a rod."""
    of_rods = {link.name: link for link in view(model).links}
    names = [surface for surface in (contact.a, contact.b) if isinstance(surface, str)]
    rods = [of_rods[name] for name in names if name in of_rods]
    is_on_link = [isinstance(shape, Ball) or getattr(shape, "link", None) for shape in (contact.a, contact.b)]
    if not isinstance(model, Robot) or not rods or any(is_on_link):
        return None
    densities = [min(line_density(segment) for segment in rod.segments) for rod in rods]
    if min(densities) <= 0.0:
        return None
    lightness = sum(1.0 / density for density in densities)
    contacts = [other.name for other in model.contacts]
    stiffness = model._contact_stiffness()[contacts.index(contact.name)]
    return float(np.pi / np.sqrt(stiffness * lightness))


def line_density(segment: Segment) -> float:
    """Smallest mass per length of a segment, kg/m."""
    return float(min(segment.inertia(X)[3, 3] for X in (0.0, segment.length)))


@dataclass(frozen=True)
class Vibrations:
    """Natural frequencies about the equilibrium of a model."""

    #: Natural frequencies of what oscillates, in hertz, the slowest first.
    frequencies: NDArray[np.float64]
    #: Eigenvalue of the fastest motion, in 1/s.
    fastest: complex
    #: Those of the same vibrations with more modes of the rods, if they are known.
    refined: NDArray[np.float64] | None = None
    #: What the message of the equilibrium says of stretch without modes; empty otherwise.
    stretch: str = ""

    @classmethod
    def of(cls, model: Model, t: float = 0.0, q0: NDArray[np.float64] | None = None) -> Vibrations | None:
        """Vibrations about the equilibrium near a shape; None for a large model or without an equilibrium."""
        if not 0 < model.n <= MOST_COORDINATES:
            return None
        with warnings.catch_warnings():
            # Advice on modes says it by frequencies.
            warnings.simplefilter("ignore", AccuracyWarning)
            rest = statics(model, q0, t=t, stability=False)
        if not rest.success:
            return None
        try:
            found = modes(model, rest.q, t=t)
        except LissomError:
            return None
        oscillates = (found.frequency > 0.0) & (np.abs(found.damping_ratio) < 1.0)
        fastest = found.eigenvalues[np.abs(found.eigenvalues).argmax()]
        stretch = _OF_STRETCH.search(rest.message)
        refined = None if found.refined_frequency is None else found.refined_frequency[oscillates]
        return cls(found.frequency[oscillates], complex(fastest), refined, stretch[0] if stretch else "")


def about_step(found: Vibrations, settings: SimulationSettings) -> list[str]:
    """Natural frequencies that a fixed step does not resolve."""
    frequencies, step = found.frequencies, settings.dt
    if settings.method not in FIXED_STEP:
        return []
    resolved = int(np.count_nonzero(frequencies * step * STEPS_PER_PERIOD <= 1.0))
    if resolved == len(frequencies):
        return []
    which, place = (f"the first {resolved}", "next") if resolved else ("none", "first")
    following = frequencies[resolved]
    needed = 1.0 / (STEPS_PER_PERIOD * following)
    return [
        f"The step of {step:g} s resolves {which} of {len(frequencies)} natural frequencies; "
        f"the {place}, {following:.3g} Hz, needs steps of {needed:.2g} s "
        f"({STEPS_PER_PERIOD} per period)."
    ]


def about_stability(found: Vibrations, settings: SimulationSettings) -> list[str]:
    """The stable step of an explicit method, if stability determines the cost."""
    if settings.method not in EXPLICIT or not len(found.frequencies):
        return []
    stable = stable_step(EXPLICIT[settings.method], found.fastest)
    useful = 1.0 / (STEPS_PER_PERIOD * found.frequencies[0])
    if useful < STIFF * stable:
        return []
    steps = (settings.t_end - settings.t0) / stable
    return [
        f'Method "{settings.method}" is stable with steps below {stable:.1e} s only, because of a rate of '
        f"{abs(found.fastest):.3g} per second: {steps:.2g} steps or more, while the slowest vibration, "
        f"{found.frequencies[0]:.3g} Hz, needs steps of {useful:.2g} s. "
        'Methods "radau" and "newmark" have no such limit.'
    ]


def about_modes(found: Vibrations) -> list[str]:
    """Accuracy of the natural frequencies, unless all of them, or three, are accurate."""
    frequencies, right = found.frequencies, found.refined
    count = len(frequencies)
    if count == 0 or right is None:
        return []
    errors = np.abs(frequencies / right - 1.0)
    good = int(np.count_nonzero(errors <= RIGHT))
    if good >= min(ENOUGH, count):
        return []
    worst = int(errors.argmax())
    return [
        f"{good} of {count} natural frequencies are accurate to {RIGHT:.0%}: "
        f"with more modes of every strain the first changes by {errors[0]:.0e}, "
        f"and number {worst + 1}, {frequencies[worst]:.3g} Hz, becomes {right[worst]:.3g} Hz "
        f"({errors[worst]:.0%} off)."
    ]


def about_shear(rod: Link) -> list[str]:
    """Shear deflection that a thick rod without shear modes leaves out."""
    widest = max(rod.half_extents())
    # A given section without inertia has no size.
    slenderness = rod.length / widest if widest > 0.0 else np.inf
    rigid = {
        shear
        for segment in rod.segments
        for bend, shear in SHEAR_OF.items()
        if segment.modes.get(bend, 0) and not segment.modes.get(shear, 0)
    }
    if slenderness >= SLENDER or not rigid:
        return []
    added = max(shear_deflection(segment, rod.length) for segment in rod.segments)
    strains, have = " and ".join(sorted(rigid)), "has" if len(rigid) == 1 else "have"
    is_round = all(segment.section.shape in ("circle", "hollow_circle") for segment in rod.segments)
    size = "its radius" if is_round else "half its width"
    return [
        f"The rod's length is only {slenderness:.2g} times {size}, and {strains} {have} no modes: "
        f"shear would add {added:.1%} to its deflection under a force at the tip."
    ]


def shear_deflection(segment: Segment, length: float) -> float:
    """Deflection by shear over that by bending, of a cantilever of its section under a force at the tip.

    F L / (k G A) over F L^3 / (3 E I), the larger one of both ends and both planes (Timoshenko 1921).
    """
    planes = [
        (STRAINS.index(bend), STRAINS.index(shear))
        for bend, shear in SHEAR_OF.items()
        if segment.modes.get(bend, 0)
    ]
    stiffness = [np.diag(segment.stiffness(X)) for X in (0.0, segment.length)]
    ratios = [H[bend] / H[shear] for H in stiffness for bend, shear in planes if H[shear] > 0.0]
    return 3.0 * max(ratios, default=0.0) / length**2


def stable_step(method: type[RK45] | type[DOP853], eigenvalue: complex) -> float:
    """Largest step up to which an explicit method keeps exp(eigenvalue t) from growing.

    By its stability function R(z) = 1 + z b^T (1 - z A)^-1 e (Hairer and Wanner 1996, section IV.2).
    """
    A, b = np.asarray(method.A), np.asarray(method.B)
    stages = len(b)
    powers = [b @ np.linalg.matrix_power(A[:stages, :stages], k) @ np.ones(stages) for k in range(stages)]
    polynomial = np.array([1.0, *powers])
    sizes = np.linspace(0.0, 2.0 * stages, 1000 * stages)
    growth = np.abs(np.polynomial.polynomial.polyval(sizes * eigenvalue / abs(eigenvalue), polynomial))
    unstable = np.flatnonzero(growth > 1.0 + STABLE_GROWTH)
    return float(sizes[unstable[0]] / abs(eigenvalue))
