"""Values for the scripts of the API harness: rods, arrays of every layout, misbehaving callbacks.

Scripts say ``from fuzz import values as v``.
"""

import copy
import gc
import os
import pathlib
import pickle
import tempfile
import types

import numpy as np

import lissom
from fuzz import judge

# Objects of the package.

MATERIAL = {"young_modulus": 3e5, "shear_modulus": 1e5, "density": 1070.0, "retardation_time": 0.01}


def segment(**changes):
    return lissom.Segment(
        **({"length": 0.2, "radius": 0.01, "modes": {"torsion": 1, "bend_y": 1}} | MATERIAL | changes)
    )


def rod(**changes):
    """Two coordinates in space."""
    return lissom.Rod([segment()], **changes)


def planar():
    """Two coordinates in a plane."""
    return lissom.Rod([segment(modes={"bend_y": 2})], tip_mass=0.01)


def chain():
    """Three segments, held at the tip, in water."""
    return lissom.Rod(
        [segment(modes={"bend_y": 1}), segment(modes={"bend_z": 1}), segment(modes={})],
        supports=[lissom.Support(stiffness=3.0)],
        fluid=lissom.Fluid(1000.0, drag_coefficients=(1.0, 0.1)),
        loads=[lissom.Load(force=(0, 0, 0.01), frame="body")],
    )


def moving():
    """Two coordinates, and a moving base."""
    return rod(
        base_motion=lissom.BaseMotion(translation=lissom.Harmonic((0, 0, 0.01), 2.0)),
        loads=[lissom.Load(force=lissom.Harmonic((0, 0, 0.01), 1.0))],
    )


def link(name, **changes):
    """A body on a spring hinge."""
    joint = lissom.Revolute((0, 1, 0), stiffness=1.0, damping=0.1)
    body = lissom.Body(0.1, centre=(0.1, 0, 0))
    return lissom.Link(name, **({"joint": joint, "body": body} | changes))


def robot():
    """Two coordinates of joints."""
    return lissom.Robot([link("a"), link("b", parent="a", position=(0.1, 0, 0))])


def tied():
    """Two coordinates of joints, tied by a bar to the world."""
    bar = lissom.Loop(("b", None, (0.1, 0, 0)), None, lissom.Distance(0.15), name="bar")
    return lissom.Robot([link("a"), link("b", parent="a", position=(0.1, 0, 0))], loops=[bar])


def touching():
    """Two coordinates: a rod that touches a sphere, and a link whose ball penetrates a floor."""
    return lissom.Robot(
        [lissom.Link("a", rod=[segment(modes={"bend_y": 1})]), link("b", parent="a")],
        contacts=[
            lissom.Contact(
                lissom.Ball("b", 0.05), lissom.HalfSpace((0, 0, -0.03)), stiffness=1e4, friction=0.3
            ),
            lissom.Contact("a", lissom.Sphere((0.1, 0, 0.02), 0.02), friction=(0.1, 0.2, 0.3)),
        ],
    )


def actuated():
    """Two coordinates, with an actuator of every kind, and two inputs."""
    along = [lissom.Along("a", (0, 0.01), (0.0, 0.1))]
    return lissom.Robot(
        [lissom.Link("a", rod=[segment(modes={"bend_y": 1})]), link("b", parent="a")],
        actuators=[
            lissom.Tendon("pull", along, tension=lissom.Input("pull", 1.0)),
            lissom.Chamber("blow", along, 1e-5, lissom.Input("blow")),
            lissom.Motor("b", position=0.1, gains=(1.0, 0.1)),
            lissom.ActiveStrain("a", "bend_y", 1.0, 0.1),
        ],
    )


def pulled():
    """Two coordinates, and a tendon with its tension as input."""
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.005))], tension=lissom.Input("tension", 1.0))
    return rod(actuators=[pull])


def state():
    """The state of `moving` in a simulation."""
    zero = np.zeros(2)
    return types.SimpleNamespace(t=0.1, q=zero + 0.1, v=zero, a=zero, u=np.empty(0))


def begun(env):
    """A single or vector environment in its first episode."""
    env.reset(seed=0)
    return env


def antagonists():
    """Two coordinates, and two tendons whose tensions are inputs."""

    def tendon(name, z):
        return lissom.Tendon(name, [lissom.Along(offset=(0.0, z))], tension=lissom.Input(name, 0.5))

    finger = lissom.Segment(0.2, 2e-3, 1e9, 4e8, 1200, {"bend_y": 2})
    return lissom.Rod([finger], actuators=[tendon("up", 0.01), tendon("down", -0.01)])


def urdf():
    """The path of a file with one body on a hinge."""
    text = (
        '<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
    )
    path = pathlib.Path(place("one-hinge.urdf"))
    path.write_text(text, encoding="utf-8")
    return str(path)


def mesh():
    """The path of a file with a tetrahedron."""
    path = pathlib.Path(place("mesh.obj"))
    path.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", encoding="utf-8"
    )
    return str(path)


def look():
    """A visual of the rod of `planar`."""
    return lissom.Visual("rod", [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)], [(0, 1, 2)])


def place(name):
    """A file of this process in a writable folder."""
    return str(pathlib.Path(tempfile.gettempdir()) / f"lissom-{os.getpid()}-{name}")


def saved():
    """A file with a result."""
    path = place("kept.lissom")
    lissom.statics(planar()).save(path)
    return path


def alone(result):
    """A result whose plots need no window and no earlier figures."""
    import matplotlib
    from matplotlib import pyplot

    matplotlib.use("Agg")
    pyplot.close("all")
    return result


def pendulum():
    return lissom.SpringPendulum()


#: Models of two coordinates each.
MODELS = {
    "rod": rod,
    "planar": planar,
    "chain": chain,
    "moving": moving,
    "robot": robot,
    "actuated": actuated,
    "pendulum": pendulum,
}


def scene():
    return lissom.Scene.loads("version = 1\n[pendulum]\nq0 = [0.1, 0]\n[simulation]\nt_end = 0.05\n")


# Layouts: the same numbers, stored differently.


def packed(array):
    """A column of a packed record array: strides that are not a multiple of the size of a number."""
    record = np.zeros(array.shape, dtype=np.dtype([("flag", "u1"), ("x", array.dtype), ("id", "<i4")]))
    record["x"] = array
    return record["x"]


def unaligned(array):
    """Contiguous, at an odd address."""
    array = np.ascontiguousarray(array)
    memory = np.zeros(array.nbytes + 1, dtype=np.uint8)
    moved = memory[1:].view(array.dtype).reshape(array.shape)
    moved[...] = array
    return moved


def strided(array):
    wide = np.full((*array.shape[:-1], 3 * array.shape[-1]), 77.0) if array.ndim else np.full(3, 77.0)
    wide[..., ::3] = array
    return wide[..., ::3]


def read_only(array):
    array = array.copy()
    array.setflags(write=False)
    return array


def zero_stride(array):
    """All entries at the same address; only for constant arrays."""
    return np.broadcast_to(array.ravel()[0], array.shape) if np.ptp(array) == 0 else array


#: Layouts of float64 that every function accepts.
LAYOUTS = {
    "packed": packed,
    "unaligned": unaligned,
    "strided": strided,
    "reversed": lambda array: array[::-1].copy()[::-1],
    "fortran": np.asfortranarray,
    "big_endian": lambda array: array.astype(">f8"),
    "read_only": read_only,
    "zero_stride": zero_stride,
    "list": lambda array: array.tolist(),
    "tuple": lambda array: tuple(map(tuple, array)) if array.ndim == 2 else tuple(array),
    "packed_big_endian": lambda array: packed(array.astype(">f8")),
    "transposed": lambda array: np.ascontiguousarray(array.T).T,
}


def array(values, layout=None):
    plain = np.array(values, dtype=float)
    return plain if layout is None else LAYOUTS[layout](plain)


def plain(values, layout=None):
    """The same array without its layout."""
    return array(values)


def difference(one, other) -> str | None:
    """The place at which two results differ bitwise; None if they are equal."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        one, other = np.asarray(one), np.asarray(other)
        equal = one.shape == other.shape and np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
        return None if equal else "values"
    if isinstance(one, dict):
        return difference(
            *([item for item in each.items() if item[0] not in NOT_DATA] for each in (one, other))
        )
    if isinstance(one, tuple | list):
        if len(one) != len(other):
            return "length"
        return next(filter(None, map(difference, one, other)), None)
    names = judge.public(one)
    if names and type(one) is type(other):
        for name in names:
            inside = None if name in NOT_DATA else difference(getattr(one, name), getattr(other, name))
            if inside:
                return f"{name}, {inside}"
        return None
    return None if callable(one) or one == other or (one != one and other != other) else "values"


#: Attributes that differ from run to run, or belong to the caller.
NOT_DATA = {"wall_time", "model"}


# Objects that imitate others.


class Boom(Exception):
    """Raised by misbehaving callbacks and objects."""

    def __init__(self, *words):
        super().__init__(*(words or ("boom",)))


class BaseBoom(BaseException):
    """Raised in the same way, but not derived from `Exception`."""


class Address:
    """Has an address, but is not a function."""

    address = 1
    ctypes = None


class BadFloat:
    def __float__(self):
        raise Boom("float")

    def __array__(self, *_, **__):
        raise Boom("array")

    def __index__(self):
        raise Boom("index")

    def __len__(self):
        raise Boom("len")

    def __bool__(self):
        raise Boom("bool")

    def __str__(self):
        raise Boom("str")

    __repr__ = __str__


class LyingLength:
    """A sequence that reports a length of two."""

    def __len__(self):
        return 2

    def __getitem__(self, index):
        if index > 1000:
            raise IndexError
        return 1.0


class LyingArray:
    """Another array at each access."""

    def __init__(self):
        self.asked = 0

    def __array__(self, dtype=None, copy=None):
        self.asked += 1
        return np.ones(self.asked)


class Model(lissom.Model if isinstance(lissom.Model, type) else object):
    """A user class derived from that of the models."""


def nested():
    """A list that contains itself."""
    own = [1.0]
    own.append(own)
    return own


# Callbacks.

#: Actions since `reset`, after which a call may not be called a success.
happened: list[str] = []


def reset():
    happened.clear()
    kept.clear()


kept: list = []


def _mutate(arguments):
    for argument in arguments:
        if isinstance(argument, np.ndarray) and argument.flags.writeable:
            argument[...] = 1e3


def _resize(arguments):
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            argument.resize((1000,), refcheck=False)


def _keep(arguments):
    for argument in kept:
        if isinstance(argument, np.ndarray) and argument.flags.writeable:
            argument[...] = -7.0
    kept.extend(arguments)
    gc.collect()


def _raise(error):
    raise error


def _longer(value):
    value = np.atleast_1d(np.asarray(value, dtype=float))
    return np.concatenate([value, value[..., -1:]], axis=-1)


#: Meaningless return values of a callback.
NONSENSE = {
    "none": lambda value: None,
    "string": lambda value: "one",
    "digits": lambda value: "1.0" if np.ndim(value) == 0 else ["1.0"] * len(value),
    "longer": _longer,
    "empty": lambda value: [],
    "complex": lambda value: np.asarray(value) * 1j,
    "datetime": lambda value: np.full(np.shape(value), np.datetime64(1, "s")),
    "masked": lambda value: np.ma.masked_all(np.shape(value)),
    "dict": lambda value: {"a": 1},
    "object": lambda value: BadFloat(),
    "ragged": lambda value: [[1.0], [1.0, 2.0]],
}
#: Exceptions of a callback.
ERRORS = {
    "boom": Boom,
    "base_boom": BaseBoom,
    "stop_iteration": lambda: StopIteration("boom"),
    "system_exit": lambda: SystemExit("boom"),
    "key_error": lambda: KeyError("boom"),
}
#: Invalid numbers.
NUMBERS = {"nan": np.nan, "inf": np.inf, "huge": 1e308, "tiny": 5e-324}
#: Side effects of a callback.
DEEDS = {"mutate": _mutate, "resize": _resize, "keep": _keep}
#: Kinds of misbehaviour; "layout" is the same value in another layout.
KINDS = ("nonsense", "error", "number", "deed", "layout", "again", "recurse", "jump")


def callback(good, kind, what, after=0, call=None):
    """A function that behaves like `good`, but misbehaves after this many calls."""
    calls = 0

    def misbehave(*arguments, **keywords):
        nonlocal calls
        calls += 1
        if kind == "deed" and calls > after:
            value = good(*arguments, **keywords)
            DEEDS[what](arguments)
            return value
        value = good(*arguments, **keywords)
        if calls <= after:
            return value
        if kind == "nonsense":
            happened.append(what)
            return NONSENSE[what](value)
        if kind == "error":
            happened.append("error")
            raise ERRORS[what]()
        if kind == "number":
            return np.full(np.shape(value), NUMBERS[what]) if np.ndim(value) else NUMBERS[what]
        if kind == "layout" and np.ndim(value):
            return LAYOUTS[what](np.asarray(value, dtype=float))
        if kind == "again" and calls == after + 1:
            call()
        if kind == "recurse":
            call()
        if kind == "jump":
            return np.asarray(value) * calls
        return value

    return misbehave


def protocol(value):
    """Every operation on objects of the package; copies are equal to them."""
    repr(value), str(value)
    if not type(value).__module__.startswith("lissom") or isinstance(value, lissom.OdeSolver):
        return value  # solvers are in the middle of something
    for name in judge.public(value):
        getattr(value, name)
    if not isinstance(value, tuple):
        assert value == value, "not equal to itself"
        assert value != 3.5
    try:
        copies = copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))
    except (AttributeError, pickle.PicklingError) as error:
        if "lambda" in str(error):  # the script's own, which no pickle can hold
            return value
        raise
    for copied in copies:
        different = difference(value, copied)
        if different:
            raise AssertionError(f"the copy of a {type(value).__name__} differs: {different}")
    return value


def stepper(name):
    """A solver after its first step."""
    solver = getattr(lissom, name)(lambda t, y: -y, 0.0, [1.0, 2.0], 1.0)
    solver.step()
    return solver


def simulation():
    """A simulation after its first step."""
    simulation = lissom.Simulation(rod(), dt=0.01)
    simulation.step()
    return simulation


class Viewed:
    """A simulation whose live view ends as soon as it has started, so that no server outlives a case."""

    def view(self, **options):
        if options.get("block", True) is True:
            options["block"] = False
        # Any free port, because the requested one may be in use.
        if type(options.get("port")) is int and 0 < options["port"] < 2**16:
            options["port"] = 0
        with simulation().view(**options) as shown:
            return shown.url.rpartition(":")[0]


def simulations():
    """Simulations after their first step."""
    simulations = lissom.Simulations(rod(), 3, dt=0.01)
    simulations.step()
    return simulations
