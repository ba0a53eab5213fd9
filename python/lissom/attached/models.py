"""Methods of models and scenes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from .._lissom import Model, Scene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def scene_of(
    self: Model,
    *,
    t_end: float = 1.0,
    name: str = "model",
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    **simulation: Any,
) -> Scene:
    """The model as a scene: a text that describes all of it, and how to simulate it.

    `scene.model` is an equal model, and `scene.save(path)` writes a file for `lissom run`. Loads, bodies
    and supports stand in it in the order of their links, and actuators by their kinds, so that
    `scene.model.inputs` can have another order.

    Parameters
    ----------
    t_end : float
        End of the simulation, seconds.
    name : str
        Name of the scene.
    q0, v0 : array_like, shape (n,), optional
        Initial coordinates and velocities; by default zero.
    **simulation
        Further keys of ``[simulation]``, such as ``dt=1e-3`` or ``method="radau"``.

    Returns
    -------
    Scene

    Raises
    ------
    ValueError
        If the model contains functions of time in Python, which no file holds; the message names the part. If
        a key of the simulation is unknown or invalid.

    Examples
    --------
    >>> import lissom
    >>> body = lissom.Body(1.0, centre=(0, 0, -0.5))
    >>> pendulum = lissom.Link("bob", body=body, joint=lissom.Revolute((0, 1, 0)))
    >>> print(lissom.Robot([pendulum]).to_scene(t_end=2.0, dt=1e-3, q0=[0.1]).text)
    version = 1
    <BLANKLINE>
    [scene]
    name = "model"
    gravity = [0.0, 0.0, -9.81]
    <BLANKLINE>
    [[link]]
    name = "bob"
    q0 = [0.1]
    <BLANKLINE>
    [link.joint]
    type = "revolute"
    axis = [0.0, 1.0, 0.0]
    <BLANKLINE>
    [link.body]
    mass = 1.0
    centre = [0.0, 0.0, -0.5]
    <BLANKLINE>
    [simulation]
    t_end = 2.0
    dt = 0.001
    <BLANKLINE>
    """
    from ..model import scenes

    return scenes.to_scene(self, t_end=t_end, name=name, q0=q0, v0=v0, **simulation)


def advice_of_model(self: Model) -> list[str]:
    """Questions about the model: sizes, moduli, densities and gravity that are probably in other units.

    Also shear that a thick rod leaves out. `Scene.advice` asks more: steps, modes and the method. Reports
    show the same.

    Returns
    -------
    advice : list of str
        One or two sentences each; empty where nothing is questionable.

    Examples
    --------
    >>> import lissom
    >>> in_millimetres = lissom.Segment(80.0, 4.0, 0.3, 0.1, 1e-6, modes={"bend_y": 3})
    >>> for sentence in lissom.Rod([in_millimetres]).advice():
    ...     print(sentence)
    A Young's modulus of 0.3 Pa is softer than any gel; in pascals rubber has 1e6 and steel 2.1e11.
    A density of 1e-6 kg/m³ is lighter than foam; water has 1000 and steel 7800.
    "rod" is 8 m wide; lengths are in metres.
    """
    from ..analysis.advice import about_model

    return about_model(self)


def advice_of_scene(self: Scene) -> list[str]:
    """Questions about the scene before it is run, as `lissom check` asks them.

    What its step, its modes and its method can resolve, by the natural frequencies about the equilibrium
    (left out if there is none, and for models of more than 100 coordinates), and implausible units. Takes as
    long as `statics` and two `modes`.

    Returns
    -------
    advice : list of str
        One or two sentences each; often empty.
    """
    from ..analysis.advice import advice

    return advice(self)


def save_scene(self: Scene, path: str | os.PathLike[str]) -> None:
    """Write the scene to a file, and beside it what it imports and arrays of 1000 numbers and more.

    These have names such as ``finger-heights.csv``.

    Parameters
    ----------
    path : path-like
        A file, usually ``.toml``; an existing one is replaced.

    Raises
    ------
    FileExistsError
        If another file is there of a name that these need, unless it is of an earlier version of this scene.
    OSError
        If the file cannot be written.
    """
    from ..model import scenes

    scenes.save(self, path)
