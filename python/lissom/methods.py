"""What results can do with other packages: methods of the compiled classes that are written in Python.

The classes get them when the package is first asked for a name. The stubs in ``_lissom.pyi`` say the same; a
test compares them. Matplotlib, xarray and h5py are imported by what needs them, when it is called.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from ._lissom import (
    ActuateResult,
    ContinuationResult,
    EnsembleResult,
    Model,
    ModesResult,
    MotionResult,
    ReachResult,
    Simulation,
    StaticsResult,
)
from .shown import Shown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray
    from numpy.typing import ArrayLike, NDArray

    from .contact_events import ContactEvent
    from .live.server import LiveView

_SAVE = """Write the result to a file from which `lissom.load` gives it back with equal bits.

Parameters
----------
path : path-like
    {kinds}. A file that is there is replaced.
{model}
Raises
------
ValueError
    Where the suffix is unknown, or a model has functions of Python, which files cannot keep.
OSError
    Where the file cannot be written.
ImportError
    Where an extra is not installed; the message says how to install it.
"""
_ALL_KINDS = (
    "``.lissom`` (the smallest), ``.npz`` (NumPy reads its arrays) or ``.nc`` (NetCDF, extra `files`)"
)
_MODEL = """model : Model or None
    What rests or vibrates: names and units of the coordinates in NetCDF. The file does not keep the model.
"""
_DATASET = """The result as an ``xarray.Dataset`` with named dimensions and units (extra `files`).
{model}
Returns
-------
data : xarray.Dataset
    {holds}

Raises
------
ImportError
    Where xarray is not installed.
"""
_NAMES = """
Parameters
----------
model : Model or None
    Names and units of the coordinates; without it they are numbered.
"""
_AXES = """
Returns
-------
axes : ndarray of matplotlib.axes.Axes
    One below the other, in a new figure of `pyplot`.

Raises
------
ValueError
    Where the result has nothing to show.
ImportError
    Where Matplotlib is not installed (extra `plot`).
"""


_REPORT = """Write the report of {what}: one HTML file, as the command line writes it for scenes.

Parameters
----------
path : path-like
    The file to write; one that is there is replaced.
model : Model
    {role}
{about}title : str
    Heading of the page.
t : float
    The time at which loads that depend on it are shown, seconds.
u : array_like, shape (m,), optional
    The inputs; by default as `u0` of the model{own}.

Raises
------
ValueError, TypeError
    Where an argument is invalid, or the result has nothing to show.
OSError
    Where the file cannot be written.
"""
_ANIMATE = """Write {what} as an animation (extra `plot`).

Parameters
----------
path : path-like
    ``.gif``, or ``.mp4`` or ``.webm``, which need the program ffmpeg. A file that is there is replaced.
model : Model
    {role}
{about}fps : float
    Pictures per second of the animation, 1 to 100; at most 3000 pictures in all. GIF counts hundredths of
    a second: rates that do not divide 100 are rounded.
duration : float
    {lasts}
t : float
    The time at which the model is shown, seconds.

Raises
------
ValueError, TypeError
    Where an argument is invalid, or the result has nothing to show.
OSError
    Where the file cannot be written, or ffmpeg is not installed.
ImportError
    Where Matplotlib is not installed.
"""
_ABOUT = """q : array_like, shape (n,)
    The equilibrium about which it vibrates, as it was passed to `modes`.
"""
_WHICH = """mode : int
    Index of the mode, from 0 for the slowest; reports and plots count from 1.
"""


def _plot_motion(self: MotionResult) -> NDArray[Any]:
    from .pictures import of_motion

    return of_motion(self)


def _animate(
    self: MotionResult, path: str | os.PathLike[str], *, fps: float = 25.0, speed: float = 1.0
) -> None:
    """Write the motion as an animation (extra `plot`).

    Parameters
    ----------
    path : path-like
        ``.gif``, or ``.mp4`` or ``.webm``, which need the program ffmpeg. A file that is there is replaced.
    fps : float
        Pictures per second of the animation, 1 to 100; at most 3000 pictures in all. GIF counts hundredths of
        a second: rates that do not divide 100 are rounded.
    speed : float
        Seconds of the motion that are shown in a second. Each picture is the state that is nearest in time.

    Raises
    ------
    ValueError
        Where an option or the suffix makes no sense, or the result has no model (`newmark`) or no states.
    OSError
        Where the file cannot be written, or ffmpeg is not installed.
    ImportError
        Where Matplotlib is not installed.
    """
    from .pictures import animate

    animate(self, path, fps, speed)


def _report(self: MotionResult, path: str | os.PathLike[str], *, title: str = "Motion") -> None:
    """Write the report of the motion: one HTML file, with the robot in motion and its curves.

    Parameters
    ----------
    path : path-like
        The file to write; one that is there is replaced.
    title : str
        Heading of the page.

    Raises
    ------
    ValueError
        Where the result has no model (`newmark`) or no states.
    OSError
        Where the file cannot be written.
    """
    from .report import write_result

    write_result(self, path, title=_text(title))


def _contact_events(self: MotionResult) -> list[ContactEvent]:
    """When surfaces began and ceased to touch.

    Each event is found by bisection along the polynomial of degree five between two states of the result.
    What happens between two states and is undone before the second is not seen: take results of all accepted
    steps (`t_eval="steps"` of the adaptive methods), which resolve impacts.

    Returns
    -------
    events : list of ContactEvent
        In the order of their times; empty for a model without contacts. Surfaces that touch at the start or
        at the end make no event there.

    Raises
    ------
    ValueError
        Where the result has no model (`newmark`).

    Examples
    --------
    >>> import lissom
    >>> ball = lissom.Link("ball", body=lissom.Body(0.1), joint=lissom.Prismatic((0, 0, 1)))
    >>> floor = lissom.Contact(
    ...     lissom.Ball("ball", 0.05), lissom.HalfSpace((0, 0, 0), (0, 0, 1)), stiffness=1e5, name="bounce"
    ... )
    >>> robot = lissom.Robot([ball], contacts=[floor])
    >>> run = lissom.simulate(robot, 0.6, q0=[1.05], method="radau", t_eval="steps")
    >>> [(event.kind, round(event.t, 3)) for event in run.contact_events()]
    [('touch', 0.452), ('lift_off', 0.455)]
    """
    from .contact_events import events_of

    return events_of(self)


def _text(title: str) -> str:
    if not isinstance(title, str):
        raise TypeError(f"title: a {type(title).__name__} is not text")
    return title


def _report_statics(
    self: StaticsResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    title: str = "Equilibrium",
    t: float = 0.0,
    u: ArrayLike | None = None,
) -> None:
    from .report import write_equilibrium
    from .studies import setting_for

    write_equilibrium(self, path, setting_for(model, len(self.q), t, u), _text(title))


def _report_path(
    self: ContinuationResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    title: str = "Path of equilibria",
    t: float = 0.0,
    u: ArrayLike | None = None,
) -> None:
    from .report import write_equilibrium
    from .studies import setting_for

    write_equilibrium(self, path, setting_for(model, self.path.q.shape[1], t, u), _text(title))


def _report_modes(
    self: ModesResult,
    path: str | os.PathLike[str],
    model: Model,
    q: ArrayLike,
    *,
    title: str = "Natural modes",
    t: float = 0.0,
    u: ArrayLike | None = None,
) -> None:
    from .report import write_modes
    from .studies import setting_for, vector

    setting = setting_for(model, self.shapes.shape[0], t, u)
    write_modes(self, path, setting, vector("q", q, model.n), _text(title))


def _animate_path(
    self: ContinuationResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    fps: float = 25.0,
    duration: float = 4.0,
    t: float = 0.0,
) -> None:
    from .pictures import animate_path
    from .studies import setting_for

    animate_path(self, path, setting_for(model, self.path.q.shape[1], t, None), fps, duration)


def _animate_mode(
    self: ModesResult,
    path: str | os.PathLike[str],
    model: Model,
    q: ArrayLike,
    *,
    mode: int = 0,
    fps: float = 25.0,
    duration: float = 2.0,
    t: float = 0.0,
) -> None:
    from .pictures import animate_mode
    from .studies import setting_for, vector

    setting = setting_for(model, self.shapes.shape[0], t, None)
    animate_mode(self, path, setting, vector("q", q, model.n), mode, fps, duration)


def _of_what_rests(self: StaticsResult, name: str) -> Any:
    if name == "animate":
        raise AttributeError(
            "an equilibrium does not move: `plot(model)` draws it, `report(path, model)` shows how it was "
            "loaded, and `continuation(model).animate(path, model)` makes a film of the growing loads",
            name=name,
            obj=self,
        )
    raise AttributeError(f"'lissom.StaticsResult' object has no attribute {name!r}", name=name, obj=self)


def _save_motion(self: MotionResult, path: str | os.PathLike[str]) -> None:
    from .keeping import save

    save(self, path)


def _save_with(
    self: StaticsResult | ContinuationResult | ModesResult | EnsembleResult | ReachResult | ActuateResult,
    path: str | os.PathLike[str],
    model: Model | None = None,
) -> None:
    from .keeping import save

    save(self, path, model)


def _dataset_of_motion(self: MotionResult) -> xarray.Dataset:
    from .datasets import dataset

    return dataset(self)


def _dataset_with(
    self: StaticsResult | ContinuationResult | ModesResult | ReachResult | ActuateResult,
    model: Model | None = None,
) -> xarray.Dataset:
    from .datasets import dataset

    return dataset(self, model)


def _dataset_of_ensemble(self: EnsembleResult, model: Model | None = None) -> xarray.Dataset:
    from .datasets import dataset

    return dataset(self, model)


def _plot_ensemble(self: EnsembleResult, model: Model | None = None) -> NDArray[Any]:
    from .pictures import of_ensemble

    return of_ensemble(self, model)


def _report_ensemble(
    self: EnsembleResult,
    path: str | os.PathLike[str],
    model: Model | None = None,
    *,
    title: str = "Many runs",
) -> None:
    """Write the report of many runs: one HTML file with their spread, those that failed, and their cost.

    Parameters
    ----------
    path : path-like
        The file to write; one that is there is replaced.
    model : Model
        Names and units of the coordinates; without it they are numbered.
    title : str
        Heading of the page.

    Raises
    ------
    ValueError, TypeError
        Where an argument is invalid.
    OSError
        Where the file cannot be written.
    """
    from .report import write_ensemble

    write_ensemble(self, path, _text(title), model)


def _save_plain(self: Shown, path: str | os.PathLike[str]) -> None:
    from .keeping import save

    save(self, path)  # type: ignore[arg-type]


def _dataset_plain(self: Shown) -> xarray.Dataset:
    from .datasets import dataset

    return dataset(self)


def _plot_parameters(self: Shown) -> NDArray[Any]:
    from .pictures import of_parameters

    return of_parameters(self)


def _report_parameters(self: Shown, path: str | os.PathLike[str], *, title: str | None = None) -> None:
    """Write the report: one HTML file that needs nothing but a browser.

    Parameters
    ----------
    path : path-like
        The file to write; one that is there is replaced.
    title : str, optional
        Heading of the page.

    Raises
    ------
    TypeError
        Where the title is no text.
    OSError
        Where the file cannot be written.
    """
    from .report import write_parameters

    write_parameters(self, path, None if title is None else _text(title))  # type: ignore[arg-type]


def _plot_statics(self: StaticsResult, model: Model) -> NDArray[Any]:
    from .pictures import of_statics

    return of_statics(self, model)


def _plot_path(self: ContinuationResult, model: Model | None = None) -> NDArray[Any]:
    from .pictures import of_path

    return of_path(self, model)


def _plot_modes(self: ModesResult) -> NDArray[Any]:
    from .pictures import of_modes

    return of_modes(self)


def _view(
    self: Simulation,
    *,
    port: int = 8080,
    speed: float = 1.0,
    paused: bool = False,
    ranges: Mapping[str, Sequence[float]] | None = None,
    block: bool = True,
) -> LiveView:
    """Show the motion as it is computed, in a browser (extra `view`), and change it there.

    The page has a button to pause and run, one to step, one to go back to the start, a slider for each input
    of the model, and a handle at the tip that pulls it. It is served to this machine alone. The motion goes
    on from the state of the simulation, which itself stays as it is; it waits until a page is open.

    Parameters
    ----------
    port : int
        Where the page is served; the next one that is free where this one is taken. Any free one for 0.
    speed : float
        Seconds of the motion in a second of the clock.
    paused : bool
        Whether the motion begins paused.
    ranges : mapping of str to (float, float), optional
        The lowest and the highest value of sliders by the names of inputs. By default they are such that each
        input moves the tips by about half the size of the model, as linear theory has it.
    block : bool
        Whether to print the address and to serve until Ctrl-C. If False, a thread serves the page until
        `stop` of what is returned.

    Returns
    -------
    view : lissom.live.server.LiveView
        With the address, `url`, and the method `stop`; a context manager.

    Raises
    ------
    ValueError, TypeError
        Where an option makes no sense, or the model cannot be drawn.
    OSError
        Where no port is free.
    ImportError
        Where viser is not installed.
    """
    from .live import open_view

    if not isinstance(block, bool):
        raise TypeError(f"block: a {type(block).__name__} is not True or False")
    view = open_view(self, port=port, speed=speed, paused=paused, ranges=ranges)
    if block:
        try:
            print(f"Open {view.url} in a browser; Ctrl-C ends.", flush=True)
            view.serve()
        except KeyboardInterrupt:
            # Before the page was served; from then on `serve` hears it.
            view.stop()
    else:
        view.start()
    return view


def _attach(owner: type, name: str, function: Any, text: str | None = None) -> None:
    """Give a class a function of its own as a method."""
    import types

    own = types.FunctionType(function.__code__, function.__globals__, name, function.__defaults__)
    own.__kwdefaults__ = function.__kwdefaults__
    own.__annotations__ = function.__annotations__
    own.__doc__ = text or function.__doc__
    own.__qualname__ = f"{owner.__name__}.{name}"
    setattr(owner, name, own)


def attach() -> None:
    """Give the classes of results their methods; once more does no harm."""
    paraview = f"{_ALL_KINDS}; ``.vtkhdf`` is for ParaView alone (extra `files`) and cannot be loaded again"
    trajectory = (
        "States, inputs, energies (J), centre lines of rods and positions of tips (m) over the time (s)."
    )
    _attach(
        MotionResult, "plot", _plot_motion, f"Draw coordinates, positions of the tips and energies.\n{_AXES}"
    )
    _attach(MotionResult, "animate", _animate)
    _attach(MotionResult, "report", _report)
    _attach(MotionResult, "contact_events", _contact_events)
    _attach(MotionResult, "save", _save_motion, _SAVE.format(kinds=paraview, model=""))
    _attach(MotionResult, "to_xarray", _dataset_of_motion, _DATASET.format(model="", holds=trajectory))
    _attach(Simulation, "view", _view)
    _attach(EnsembleResult, "save", _save_with, _SAVE.format(kinds=_ALL_KINDS, model=_MODEL))
    rows = "States, status and cost by rows; of places positions (m), or their mean and variance."
    _attach(EnsembleResult, "to_xarray", _dataset_of_ensemble, _DATASET.format(model=_NAMES, holds=rows))
    shown = "Draw the coordinates: their median and spread over time, or the last ones of each run."
    _attach(EnsembleResult, "plot", _plot_ensemble, f"{shown}\n{_NAMES}{_AXES}")
    _attach(EnsembleResult, "report", _report_ensemble)
    _attach(Shown, "save", _save_plain, _SAVE.format(kinds=_ALL_KINDS, model=""))
    _attach(
        Shown, "to_xarray", _dataset_plain, _DATASET.format(model="", holds="With the parameters by name.")
    )
    drawn = "Draw derivatives of positions or coordinates, or what was measured beside what was fitted."
    _attach(Shown, "plot", _plot_parameters, f"{drawn}\n{_AXES}")
    _attach(Shown, "report", _report_parameters)
    holds = {
        StaticsResult: "The coordinates in equilibrium and the verdict.",
        ContinuationResult: "Coordinates, load factor, lowest eigenvalue and stability along the path.",
        ModesResult: "Frequencies (Hz), damping ratios, eigenvalues, shapes; real and imaginary parts apart.",
        ReachResult: "The coordinates, poses of the links, and by how much they miss the targets.",
        ActuateResult: "Inputs and coordinates, poses of the links, and by how much they miss the targets.",
    }
    for owner, held in holds.items():
        _attach(owner, "save", _save_with, _SAVE.format(kinds=_ALL_KINDS, model=_MODEL))
        _attach(owner, "to_xarray", _dataset_with, _DATASET.format(model=_NAMES, holds=held))
    shown = "\nParameters\n----------\nmodel : Model\n    What rests.\n"
    _attach(StaticsResult, "plot", _plot_statics, f"Draw the equilibrium shape.\n{shown}{_AXES}")
    path = f"Draw coordinates and the lowest eigenvalue over the load factor.\n{_NAMES}{_AXES}"
    _attach(ContinuationResult, "plot", _plot_path, path)
    rests, vibrates = "What rests.", "What vibrates."
    own = "; a path of inputs has its own"
    of_path, a_path = "a path of equilibria", "the path of equilibria, from its beginning to its end,"
    of_rest = _REPORT.format(what="an equilibrium", role=rests, about="", own="")
    _attach(StaticsResult, "report", _report_statics, of_rest)
    _attach(StaticsResult, "__getattr__", _of_what_rests, "Say what to use in place of what is not there.")
    of_path = _REPORT.format(what=of_path, role=rests, about="", own=own)
    _attach(ContinuationResult, "report", _report_path, of_path)
    lasts = (
        "Seconds of the animation; equal times show equal parts of the way, as coordinates and loads change."
    )
    film = _ANIMATE.format(what=a_path, role=rests, about="", lasts=lasts)
    _attach(ContinuationResult, "animate", _animate_path, film)
    of_modes = _REPORT.format(what="natural modes", role=vibrates, about=_ABOUT, own="")
    _attach(ModesResult, "report", _report_modes, of_modes)
    lasts = "Seconds of the animation, which is one period of the mode: it is not shown in real time."
    film = _ANIMATE.format(what="one period of a mode", role=vibrates, about=_ABOUT + _WHICH, lasts=lasts)
    _attach(ModesResult, "animate", _animate_mode, film)
    _attach(ModesResult, "plot", _plot_modes, f"Draw frequencies and damping ratios.\n{_AXES}")
