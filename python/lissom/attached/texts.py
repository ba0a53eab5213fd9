"""Docstrings of the attached methods, which several classes share."""

SAVE = """Write the result to a file that `lissom.load` reads back bit for bit.

Parameters
----------
path : path-like
    {kinds}. An existing file is replaced.
{model}
Raises
------
ValueError
    If the suffix is unknown, or the model contains Python functions, which files cannot store.
OSError
    If the file cannot be written.
ImportError
    If an extra is not installed; the message says how to install it.
"""
ALL_KINDS = "``.lissom`` (the smallest), ``.npz`` (NumPy reads its arrays) or ``.nc`` (NetCDF, extra `files`)"
MODEL = """model : Model or None
    The model, for names and units of the coordinates in NetCDF files. The file does not contain the model.
"""
INSTANT = """t : float, optional
    The instant that a file of meshes shows, seconds; ``.ply`` and ``.obj`` need one. Between states of the
    result coordinates follow a polynomial of fifth order.
visuals : sequence of Visual
    Meshes that stand for links, in files of meshes.
"""
TIME_OF_SHAPE = """t : float, optional
    Time at which the model is shown in files of meshes, seconds; by default that of the result.
visuals : sequence of Visual
    Meshes that stand for links, in files of meshes.
"""
DATASET = """The result as an ``xarray.Dataset`` with named dimensions and units (extra `files`).
{model}
Returns
-------
data : xarray.Dataset
    {holds}

Raises
------
ImportError
    If xarray is not installed.
"""
NAMES = """
Parameters
----------
model : Model or None
    The model, for names and units of the coordinates; without it they are numbered.
"""
AXES = """
Returns
-------
axes : ndarray of matplotlib.axes.Axes
    Axes of a new `pyplot` figure, one below the other.

Raises
------
ValueError
    If the result has nothing to show.
ImportError
    If Matplotlib is not installed (extra `plot`).
"""


REPORT = """Write an HTML report of {what} in a single file, as the command line does for scenes.

Parameters
----------
path : path-like
    File to write; an existing file is replaced.
model : Model
    {role}
{about}title : str
    Heading of the page.
t : float, optional
    Time at which time-dependent loads are shown, seconds; by default that of the result.
u : array_like, shape (m,), or dict, optional
    Inputs, or some of them by name; by default those of the result{own}.
visuals : sequence of Visual
    Meshes that stand for links.

Raises
------
ValueError, TypeError
    If an argument is invalid, or the result has nothing to show.
OSError
    If the file cannot be written.
"""
ANIMATE = """Write {what} as an animation (extra `plot`).

Parameters
----------
path : path-like
    ``.gif``, or ``.mp4`` or ``.webm``, which need the program ffmpeg. An existing file is replaced.
model : Model
    {role}
{about}fps : float
    Frames per second, 1 to 100; at most 3000 frames in total. GIF times are multiples of 0.01 s: rates that
    do not divide 100 are rounded.
duration : float
    {lasts}
t : float, optional
    Time at which the model is shown, seconds; by default that of the result.
visuals : sequence of Visual
    Meshes that stand for links.

Raises
------
ValueError, TypeError
    If an argument is invalid, or the result has nothing to show.
OSError
    If the file cannot be written, or ffmpeg is not installed.
ImportError
    If Matplotlib is not installed.
"""
ABOUT = """q : array_like, shape (n,)
    The equilibrium that was passed to `modes`.
"""
WHICH = """mode : int
    Index of the mode, from 0 for the slowest; reports and plots count from 1.
"""

PICTURE = """Write a figure for a paper: {what} with true sections (extra `plot`).

Rods, bodies, tendons, magnets and obstacles are polygons, with a scale bar and the axes of the world.{more}

Parameters
----------
path : path-like
    ``.pdf`` or ``.svg``, of lines, or ``.png``. An existing file is replaced.
{about}view : str or array_like, shape (3,), optional
    Direction from the model to the viewer in world axes, or ``"front"`` (from -y), ``"back"``,
    ``"right"`` (from x), ``"left"``, ``"top"`` (from z), ``"bottom"``. By default obliquely.
width : float
    Width of the figure, metres; by default a column of a page. The height follows.
{setting}visuals : sequence of Visual
    Meshes that stand for links.

Raises
------
ValueError, TypeError
    If an argument is invalid, or {lacks}.
OSError
    If the file cannot be written.
ImportError
    If Matplotlib is not installed.
"""
TIMES = """times : array_like, optional
    Times of the shapes, seconds; by default five from the start to the end. Between states of the result
    coordinates follow a polynomial of fifth order.
"""
SETTING = """t : float, optional
    Time at which the model is shown, seconds; by default that of the result.
u : array_like, shape (m,), or dict, optional
    Inputs, or some of them by name; by default those of the result.
"""
