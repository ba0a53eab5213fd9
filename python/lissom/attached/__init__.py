"""Python methods of the compiled result classes, which use other packages.

They are attached on the first access to a name of the package. The stubs in ``_lissom.pyi`` repeat their
signatures; a test compares them. Matplotlib, xarray and h5py are imported on use.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NoReturn

from .._lissom import (
    ActuateResult,
    ContinuationResult,
    EnsembleResult,
    Model,
    ModesResult,
    MotionResult,
    ReachResult,
    Robot,
    Scene,
    Segment,
    Simulation,
    StaticsResult,
)
from ..analysis.base import ParameterResult
from ..common.arguments import MORE, suggesting, text
from . import texts
from .missing import INSTEAD, of_attribute
from .models import advice_of_model, advice_of_scene, save_scene, scene_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray
    from numpy.typing import ArrayLike, NDArray

    from ..analysis.contact_events import ContactEvent
    from ..analysis.peaks import Peak
    from ..common.arguments import Inputs
    from ..drawing.live.server import LiveView
    from ..model.visuals import Visual


def _plot_motion(self: MotionResult) -> NDArray[Any]:
    from ..drawing.pictures import of_motion

    return of_motion(self)


def _animate(
    self: MotionResult,
    path: str | os.PathLike[str],
    *,
    fps: float = 25.0,
    speed: float = 1.0,
    visuals: Sequence[Visual] = (),
) -> None:
    """Write the motion as an animation (extra `plot`).

    Parameters
    ----------
    path : path-like
        ``.gif``, or ``.mp4`` or ``.webm``, which need the program ffmpeg. An existing file is replaced.
    fps : float
        Frames per second, 1 to 100; at most 3000 frames in total. GIF times are multiples of 0.01 s: rates
        that do not divide 100 are rounded.
    speed : float
        Playback speed: simulated seconds per second. Each frame shows the state nearest in time.
    visuals : sequence of Visual
        Meshes that stand for links.

    Raises
    ------
    ValueError, TypeError
        If an option or the suffix is invalid, or the result has no model (`newmark`) or no states.
    OSError
        If the file cannot be written, or ffmpeg is not installed.
    ImportError
        If Matplotlib is not installed.
    """
    from ..drawing.pictures import animate

    animate(self, path, fps, speed, visuals)


def _picture(
    self: MotionResult,
    path: str | os.PathLike[str],
    *,
    times: ArrayLike | None = None,
    view: str | ArrayLike | None = None,
    width: float = 0.085,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.figures import of_motion

    of_motion(self, path, times, view, width, visuals)


def _picture_statics(
    self: StaticsResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    view: str | ArrayLike | None = None,
    width: float = 0.085,
    t: float | None = None,
    u: Inputs | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.figures import of_statics
    from ..results.studies import setting_for

    of_statics(self, path, setting_for(self, model, t, u, visuals), view, width)


def _report(
    self: MotionResult,
    path: str | os.PathLike[str],
    *,
    title: str = "Motion",
    visuals: Sequence[Visual] = (),
) -> None:
    """Write an HTML report of the motion in a single file: an animation and curves over time.

    Parameters
    ----------
    path : path-like
        File to write; an existing file is replaced.
    title : str
        Heading of the page.
    visuals : sequence of Visual
        Meshes that stand for links.

    Raises
    ------
    ValueError, TypeError
        If the result has no model (`newmark`) or no states, or a visual is invalid.
    OSError
        If the file cannot be written.
    """
    from ..drawing.report import write_result

    write_result(self, path, title=_text(title), visuals=visuals)


def _pose(self: MotionResult, X: ArrayLike | None = None, *, link: str | None = None) -> NDArray[Any]:
    """Poses of sections or bodies at the times of the result: `Robot.pose` of its states and times.

    Parameters
    ----------
    X : float or array_like, shape (j,), optional
        Arc lengths on the unstretched rod, metres; by default the tip. None for a rigid link.
    link : str, optional
        The link; not needed if there is only one.

    Returns
    -------
    pose : ndarray, shape (m, 4, 4) or (m, j, 4, 4)
        Homogeneous matrices that map section axes to world axes, for each of the m times.

    Raises
    ------
    ValueError, TypeError
        If the result has no model with links, or an argument is invalid.

    Examples
    --------
    >>> import lissom
    >>> rubber = lissom.Segment(0.3, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    >>> motion = lissom.simulate(lissom.Rod([rubber]), 0.1)
    >>> motion.pose().shape, motion.pose([0.1, 0.2]).shape
    ((11, 4, 4), (11, 2, 4, 4))
    """
    if not isinstance(self.model, Robot):
        has = "no model" if self.model is None else f"a {type(self.model).__name__}"
        expected = "the result of a Robot or Rod; coordinates are `q`"
        raise ValueError(f"result: has {has}, which has no links, expected {expected}")
    return self.model.pose(self.q, X, link=link, t=self.t)


def _contact_events(self: MotionResult) -> list[ContactEvent]:
    """Times at which surfaces began and ceased to touch.

    Each event is located by bisection on the quintic polynomial between two states of the result. A contact
    that begins and ends between two states is missed; use `t_eval="steps"` with an adaptive method, whose
    accepted steps resolve impacts.

    Returns
    -------
    events : list of ContactEvent
        Events in the order of their times; empty for a model without contacts. Surfaces that touch at the
        start or at the end of the result give no event there.

    Raises
    ------
    ValueError
        If the result has no model (`newmark`).

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
    from ..analysis.contact_events import events_of

    return events_of(self)


def _peaks(self: MotionResult) -> list[Peak]:
    """The largest curvatures, strains, stresses, forces and overlaps of the motion, with places and times.

    For each rod: curvature of bending and torsion (with those at rest), stretch and shear (as changes of the
    reference strain), axial strain and stress of the outermost fibre (without shear, torsion and damping),
    and bending moment, torque and tension in its sections by the balance of forces. Stretch and bending that
    have no modes count by these forces in strain and stress, unless tendons or chambers act along the rod.
    Where Young's modulus stands for a measured stiffness (EI / I of a cable), stresses are fictitious.
    For each actuator its force, for each contact its resultant and the largest overlap.

    Rods are evaluated at 49 places of each segment, at the times of the result: peaks between these are
    missed. Curvature and stress are those of the modes; `StaticsResult.space_error` estimates their error.

    Returns
    -------
    peaks : list of Peak
        For each part and quantity the value that is largest in size; first those of rods, then actuators,
        then contacts. ``1 / value`` of a curvature is the smallest radius of bending.

    Raises
    ------
    ValueError
        If the result has no model (`newmark`) or no states.

    Examples
    --------
    >>> import lissom
    >>> segment = lissom.Segment(1.0, 2e-3, 210e9, 80e9, 7800.0, modes={"bend_y": 4})
    >>> run = lissom.simulate(lissom.Rod([segment]), 0.5, dt=2e-3)
    >>> stress = next(peak for peak in run.peaks() if peak.quantity == "axial stress")
    >>> stress.X  # metres: at the clamp
    0.0
    """
    from ..analysis.peaks import States, peaks_of
    from ..model.views import view

    if self.model is None:
        raise ValueError("result: a result of `newmark` does not contain its model: use one of `simulate`")
    if not len(self.t):
        raise ValueError("result: it has no states")
    return peaks_of(self.model, States(view(self.model), self.q, self.v, self.a, self.t, self.u))


def _peaks_statics(
    self: StaticsResult, model: Model, *, t: float | None = None, u: Inputs | None = None
) -> list[Peak]:
    """The largest curvatures, strains, stresses, forces and overlaps of the equilibrium, with their places.

    As `MotionResult.peaks`. Forces are those under the whole loads, also where the search ended below them.

    Parameters
    ----------
    model : Model
        The model of the search.
    t : float, optional
        Time of the loads, seconds; by default that of the search.
    u : array_like or dict, optional
        Inputs, or some of them by name; by default those of the search.

    Returns
    -------
    peaks : list of Peak

    Raises
    ------
    TypeError, ValueError
        If the model or an argument is invalid.
    """
    from ..analysis.peaks import States, peaks_of
    from ..results.studies import setting_for

    setting = setting_for(self, model, t, u)
    return peaks_of(setting.model, States.at_rest(setting.view, self.q, setting.t, setting.u))


def _text(title: str) -> str:
    return text("title", title)


def _report_statics(
    self: StaticsResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    title: str = "Equilibrium",
    t: float | None = None,
    u: Inputs | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.report import write_equilibrium
    from ..results.studies import setting_for

    write_equilibrium(self, path, setting_for(self, model, t, u, visuals), _text(title))


def _report_path(
    self: ContinuationResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    title: str = "Path of equilibria",
    t: float | None = None,
    u: Inputs | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.report import write_equilibrium
    from ..results.studies import setting_for

    write_equilibrium(self, path, setting_for(self, model, t, u, visuals), _text(title))


def _report_modes(
    self: ModesResult,
    path: str | os.PathLike[str],
    model: Model,
    q: ArrayLike,
    *,
    title: str = "Natural modes",
    t: float | None = None,
    u: Inputs | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..common.arguments import vector
    from ..drawing.report import write_modes
    from ..results.studies import setting_for

    setting = setting_for(self, model, t, u, visuals)
    write_modes(self, path, setting, vector("q", q, model.n), _text(title))


def _animate_path(
    self: ContinuationResult,
    path: str | os.PathLike[str],
    model: Model,
    *,
    fps: float = 25.0,
    duration: float = 4.0,
    t: float | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.pictures import animate_path
    from ..results.studies import setting_for

    animate_path(self, path, setting_for(self, model, t, None, visuals), fps, duration)


def _animate_mode(
    self: ModesResult,
    path: str | os.PathLike[str],
    model: Model,
    q: ArrayLike,
    *,
    mode: int = 0,
    fps: float = 25.0,
    duration: float = 2.0,
    t: float | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..common.arguments import vector
    from ..drawing.pictures import animate_mode
    from ..results.studies import setting_for

    setting = setting_for(self, model, t, None, visuals)
    animate_mode(self, path, setting, vector("q", q, model.n), mode, fps, duration)


def _save_motion(
    self: MotionResult,
    path: str | os.PathLike[str],
    *,
    t: float | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.meshfiles import motion_writers
    from ..drawing.paraview import timeline
    from ..results.io import save

    meshes = motion_writers(t, visuals)
    _only_with_meshes("t", t is None, path, meshes)
    _only_with_meshes("visuals", isinstance(visuals, list | tuple) and not visuals, path, meshes)
    save(self, path, further=meshes | {".vtkhdf": lambda result, _: timeline(result)})


def _save_statics(
    self: StaticsResult,
    path: str | os.PathLike[str],
    model: Model | None = None,
    *,
    t: float | None = None,
    visuals: Sequence[Visual] = (),
) -> None:
    from ..drawing.meshfiles import statics_writers
    from ..results.io import save

    meshes = statics_writers(t, visuals)
    _only_with_meshes("t", t is None, path, meshes)
    _only_with_meshes("visuals", isinstance(visuals, list | tuple) and not visuals, path, meshes)
    save(self, path, model, meshes)


def _only_with_meshes(
    name: str, is_left_out: bool, path: str | os.PathLike[str], meshes: Mapping[str, Any]
) -> None:
    from ..common.arguments import path_of

    if not is_left_out and path_of(path).suffix not in meshes:
        raise ValueError(f"{name}: only files of meshes have it ({', '.join(meshes)})")


def _save_with(
    self: ContinuationResult | ModesResult | EnsembleResult | ReachResult | ActuateResult,
    path: str | os.PathLike[str],
    model: Model | None = None,
) -> None:
    from ..results.io import save

    save(self, path, model)


def _dataset_of_motion(self: MotionResult) -> xarray.Dataset:
    from ..results.datasets import dataset

    return dataset(self)


def _dataset_with(
    self: StaticsResult | ContinuationResult | ModesResult | ReachResult | ActuateResult,
    model: Model | None = None,
) -> xarray.Dataset:
    from ..results.datasets import dataset

    return dataset(self, model)


def _dataset_of_ensemble(self: EnsembleResult, model: Model | None = None) -> xarray.Dataset:
    from ..results.datasets import dataset

    return dataset(self, model)


def _plot_ensemble(self: EnsembleResult, model: Model | None = None) -> NDArray[Any]:
    from ..drawing.pictures import of_ensemble

    return of_ensemble(self, model)


def _report_ensemble(
    self: EnsembleResult,
    path: str | os.PathLike[str],
    model: Model | None = None,
    *,
    title: str = "Many runs",
) -> None:
    """Write an HTML report of the ensemble in a single file: spread, failed runs and cost.

    Parameters
    ----------
    path : path-like
        File to write; an existing file is replaced.
    model : Model
        The model, for names and units of the coordinates; without it they are numbered.
    title : str
        Heading of the page.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid.
    OSError
        If the file cannot be written.
    """
    from ..drawing.report import write_ensemble

    write_ensemble(self, path, _text(title), model)


def _save_plain(self: ParameterResult, path: str | os.PathLike[str]) -> None:
    from ..results.io import save

    save(self, path)  # type: ignore[arg-type]


def _dataset_plain(self: ParameterResult) -> xarray.Dataset:
    from ..results.datasets import dataset

    return dataset(self)


def _plot_parameters(self: ParameterResult) -> NDArray[Any]:
    from ..drawing.pictures import of_parameters

    return of_parameters(self)


def _report_parameters(
    self: ParameterResult, path: str | os.PathLike[str], *, title: str | None = None
) -> None:
    """Write an HTML report in a single file.

    Parameters
    ----------
    path : path-like
        File to write; an existing file is replaced.
    title : str, optional
        Heading of the page.

    Raises
    ------
    TypeError
        If the title is not a string.
    OSError
        If the file cannot be written.
    """
    from ..drawing.report import write_parameters

    write_parameters(self, path, None if title is None else _text(title))  # type: ignore[arg-type]


def _plot_statics(self: StaticsResult, model: Model) -> NDArray[Any]:
    from ..drawing.pictures import of_statics

    return of_statics(self, model)


def _plot_path(self: ContinuationResult, model: Model | None = None) -> NDArray[Any]:
    from ..drawing.pictures import of_path

    return of_path(self, model)


def _plot_modes(self: ModesResult) -> NDArray[Any]:
    from ..drawing.pictures import of_modes

    return of_modes(self)


def _view(
    self: Simulation,
    *,
    port: int = 8080,
    speed: float = 1.0,
    paused: bool = False,
    ranges: Mapping[str, Sequence[float]] | None = None,
    block: bool = True,
    allow_hosts: Sequence[str] = (),
    dark: bool = False,
    visuals: Sequence[Visual] = (),
) -> LiveView:
    """Show the simulation live in a browser, and interact with it there (extra `view`).

    The page has buttons to pause, step and reset, a slider for each input of the model, and a handle that
    pulls the tip. It is served to this machine only. The view continues from the state of the simulation,
    which itself does not change; it waits until a page is open.

    Parameters
    ----------
    port : int
        Port of the page. If it is taken, the next free one is used; 0 selects any free port.
    speed : float
        Simulated seconds per second.
    paused : bool
        Whether to start paused.
    ranges : mapping of str to (float, float), optional
        Lowest and highest values of the sliders by names of inputs. By default, each input moves the tips by
        about half the size of the model according to linear theory.
    block : bool
        Whether to print the address and serve until Ctrl-C. If False, a thread serves the page until `stop`
        of the returned view is called.
    allow_hosts : sequence of str
        Names of hosts whose pages may use the view, such as that of a proxy. By default only the page that
        the view serves itself, to this machine.
    dark : bool
        Whether the page is dark at first; it has a switch for it.
    visuals : sequence of Visual
        Meshes that stand for links.

    Returns
    -------
    view : lissom.drawing.live.server.LiveView
        The view with its address `url` and the method `stop`; a context manager.

    Raises
    ------
    ValueError, TypeError
        If an option is invalid, or the model cannot be drawn.
    OSError
        If no port is free.
    ImportError
        If viser is not installed.
    """
    from ..drawing.live import open_view

    if not isinstance(block, bool):
        raise TypeError(f"block: a {type(block).__name__} is not True or False")
    view = open_view(
        self,
        port=port,
        speed=speed,
        paused=paused,
        ranges=ranges,
        allow_hosts=allow_hosts,
        dark=dark,
        visuals=visuals,
    )
    if block:
        try:
            print(f"Open {view.url} in a browser; Ctrl-C ends.", flush=True)
            view.serve()
        except KeyboardInterrupt:
            # Before the page is served; from then on `serve` handles Ctrl-C.
            view.stop()
    else:
        view.start()
    return view


#: How to draw one curve.
ONE_CURVE = (
    "it draws coordinates and places of tips; one curve is `matplotlib.pyplot.plot(result.t, "
    "result.pose()[:, 2, 3])`, here the height of the tip"
)

#: What is required beside a result, where it is missing.
REQUIRED = {
    "model": "results of statics, paths and modes keep no model, give that of the search",
    "q": "the shape about which the modes are, such as `statics(model).q`",
}


def _attach(owner: type, name: str, function: Any, text: str | None = None) -> None:
    """Attach a copy of a function to a class as a method."""
    import types

    own = types.FunctionType(function.__code__, function.__globals__, name, function.__defaults__)
    own.__kwdefaults__ = function.__kwdefaults__
    own.__annotations__ = function.__annotations__
    own.__doc__ = text or function.__doc__
    own.__qualname__ = f"{owner.__name__}.{name}"
    is_plot = (owner, name) == (MotionResult, "plot")
    setattr(owner, name, suggesting(own, {**REQUIRED, MORE: ONE_CURVE} if is_plot else REQUIRED))


#: File formats of a motion or a shape as meshes.
MESHES = "``.glb`` (glTF 2.0, {what}), ``.usd`` (likewise; extra `usd`), ``.ply`` and ``.obj`` have meshes"


def attach() -> None:
    """Attach the methods to the classes of results, models and scenes. Repeated calls have no effect."""
    _attach(Model, "to_scene", scene_of)
    _attach(Scene, "save", save_scene)
    _attach(Model, "advice", advice_of_model)
    _attach(Scene, "advice", advice_of_scene)
    _attach_to_motions()
    _attach_to_studies()
    _attach_to_equilibria()
    for owner in INSTEAD:
        _attach(owner, "__getattr__", of_attribute)
    type(Segment).__getattr__ = _of_class_of_parts  # type: ignore[attr-defined]


def _of_class_of_parts(cls: type, name: str) -> NoReturn:
    from ..common.elsewhere import of_class

    of_class(cls, name)


def _attach_to_motions() -> None:
    of_motion = MESHES.format(what="the motion as an animation, or one instant")
    paraview = f"{texts.ALL_KINDS}; ``.vtkhdf`` is for ParaView (extra `files`); {of_motion}"
    paraview += ": `load` reads none of these"
    trajectory = (
        "States, inputs, energies (J), centre lines of rods and positions of tips (m) over the time (s)."
    )
    _attach(
        MotionResult,
        "plot",
        _plot_motion,
        f"Draw coordinates, positions of the tips and energies.\n{texts.AXES}",
    )
    _attach(MotionResult, "animate", _animate)
    lacks = "the result has no model (`newmark`) or no states"
    more = "\nLater shapes are painted over earlier ones, which are paler."
    what, about = "shapes at some times", texts.TIMES
    figure = texts.PICTURE.format(what=what, more=more, about=about, setting="", lacks=lacks)
    _attach(MotionResult, "picture", _picture, figure)
    _attach(MotionResult, "report", _report)
    _attach(MotionResult, "contact_events", _contact_events)
    _attach(MotionResult, "peaks", _peaks)
    _attach(MotionResult, "pose", _pose)
    _attach(MotionResult, "save", _save_motion, texts.SAVE.format(kinds=paraview, model=texts.INSTANT))
    _attach(MotionResult, "to_xarray", _dataset_of_motion, texts.DATASET.format(model="", holds=trajectory))
    _attach(Simulation, "view", _view)


def _attach_to_studies() -> None:
    _attach(EnsembleResult, "save", _save_with, texts.SAVE.format(kinds=texts.ALL_KINDS, model=texts.MODEL))
    rows = "States, status and cost by rows; positions of places (m), or their mean and variance."
    _attach(
        EnsembleResult, "to_xarray", _dataset_of_ensemble, texts.DATASET.format(model=texts.NAMES, holds=rows)
    )
    shown = "Draw the coordinates: their median and spread over time, or the last ones of each run."
    _attach(EnsembleResult, "plot", _plot_ensemble, f"{shown}\n{texts.NAMES}{texts.AXES}")
    _attach(EnsembleResult, "report", _report_ensemble)
    _attach(ParameterResult, "save", _save_plain, texts.SAVE.format(kinds=texts.ALL_KINDS, model=""))
    _attach(
        ParameterResult,
        "to_xarray",
        _dataset_plain,
        texts.DATASET.format(model="", holds="With the parameters by name."),
    )
    drawn = "Draw derivatives of positions or coordinates, or what was measured beside what was fitted."
    _attach(ParameterResult, "plot", _plot_parameters, f"{drawn}\n{texts.AXES}")
    _attach(ParameterResult, "report", _report_parameters)


def _attach_to_equilibria() -> None:
    holds = {
        StaticsResult: "The coordinates at equilibrium and the stability.",
        ContinuationResult: "Coordinates, load factor, lowest eigenvalue and stability along the path.",
        ModesResult: "Frequencies (Hz), damping ratios, eigenvalues, shapes; real and imaginary parts apart.",
        ReachResult: "The coordinates, poses of the links, and by how much they miss the targets.",
        ActuateResult: "Inputs and coordinates, poses of the links, and by how much they miss the targets.",
    }
    for owner, held in holds.items():
        _attach(owner, "save", _save_with, texts.SAVE.format(kinds=texts.ALL_KINDS, model=texts.MODEL))
        _attach(owner, "to_xarray", _dataset_with, texts.DATASET.format(model=texts.NAMES, holds=held))
    of_rest = MESHES.format(what="the shape")
    of_rest = f"{texts.ALL_KINDS}; {of_rest} and need the model: `load` reads none of these"
    _attach(
        StaticsResult,
        "save",
        _save_statics,
        texts.SAVE.format(kinds=of_rest, model=texts.MODEL + texts.TIME_OF_SHAPE),
    )
    shown = "\nParameters\n----------\nmodel : Model\n    The model.\n"
    _attach(StaticsResult, "plot", _plot_statics, f"Draw the equilibrium shape.\n{shown}{texts.AXES}")
    path = f"Draw coordinates and the lowest eigenvalue over the load factor.\n{texts.NAMES}{texts.AXES}"
    _attach(ContinuationResult, "plot", _plot_path, path)
    role = "The model."
    own = "; a path of inputs has its own"
    of_path, a_path = "a path of equilibria", "the path of equilibria, from its beginning to its end,"
    of_rest = texts.REPORT.format(what="an equilibrium", role=role, about="", own="")
    _attach(StaticsResult, "report", _report_statics, of_rest)
    _attach(StaticsResult, "peaks", _peaks_statics)
    about, lacks = "model : Model\n    The model.\n", "the result has nothing to show"
    figure = texts.PICTURE.format(what="the shape", more="", about=about, setting=texts.SETTING, lacks=lacks)
    _attach(StaticsResult, "picture", _picture_statics, figure)
    of_path = texts.REPORT.format(what=of_path, role=role, about="", own=own)
    _attach(ContinuationResult, "report", _report_path, of_path)
    lasts = (
        "Duration of the animation, seconds. It advances uniformly along the path, by coordinates and loads."
    )
    film = texts.ANIMATE.format(what=a_path, role=role, about="", lasts=lasts)
    _attach(ContinuationResult, "animate", _animate_path, film)
    of_modes = texts.REPORT.format(what="natural modes", role=role, about=texts.ABOUT, own="")
    _attach(ModesResult, "report", _report_modes, of_modes)
    lasts = "Duration of the animation, seconds: one period of the mode, not in real time."
    film = texts.ANIMATE.format(
        what="one period of a mode", role=role, about=texts.ABOUT + texts.WHICH, lasts=lasts
    )
    _attach(ModesResult, "animate", _animate_mode, film)
    _attach(ModesResult, "plot", _plot_modes, f"Draw frequencies and damping ratios.\n{texts.AXES}")
