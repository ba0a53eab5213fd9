"""The Python API: every public callable, found in `__all__` and in the stubs, called in ways that make no sense.

A case is a script that stands alone. `call()` is what is tried; further names say how to judge it:
`forbidden`, an argument that must be refused; `layouts`, whose result must be the same with plain arrays, to the
last bit; `watched`, a callback whose value must be refused; `works`, that it must not be.
"""

import ast
import inspect
import sys
import traceback
import typing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import lissom
from fuzz import judge
from fuzz import values as v

NAME = "api"
SUFFIX = ".py"
STUB = Path(lissom.__file__).parent / "_lissom.pyi"

HEAD = "import lissom\nimport numpy as np\n\nfrom fuzz import values as v\n\n"
#: What refuses.
EXPECTED = (ValueError, TypeError, OverflowError, MemoryError, RecursionError, lissom.LissomError, v.Boom)
#: What `OdeSolver` documents for a step at the wrong moment.
OUT_OF_TURN = ("in the middle of a step", "failed or finished solver", "Dense output is available", "step")


# What there is.


@dataclass(frozen=True)
class Function:
    """A public callable: "Rod.pose"; its parameters with their annotations as text."""

    name: str
    parameters: dict[str, str] = field(hash=False)


def _parameters(node: ast.FunctionDef) -> dict[str, str]:
    arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return {
        a.arg: ast.unparse(a.annotation) if a.annotation else "Any"
        for a in arguments
        if a.arg not in ("self", "cls")
    }


#: Of a class in the stubs: what is called by another name, or by `protocol`.
_SPECIAL = {"__new__": "", "__call__": ".__call__"}


def discover() -> dict[str, Function]:
    """All public callables. Those of the compiled module come from its stubs, the others from themselves."""
    functions = {}

    def add(name, parameters):
        functions[name] = Function(name, parameters)

    for node in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef) and node.name in lissom.__all__:
            add(node.name, _parameters(node))
        if isinstance(node, ast.ClassDef) and node.name in lissom.__all__:
            add(node.name, {})
            for item in node.body:
                if not isinstance(item, ast.FunctionDef):
                    continue
                if any(ast.unparse(d) == "property" for d in item.decorator_list):
                    continue
                if item.name in _SPECIAL:
                    add(node.name + _SPECIAL[item.name], _parameters(item))
                elif not item.name.startswith("_"):
                    add(f"{node.name}.{item.name}", _parameters(item))
    for name in lissom.__all__:
        value = getattr(lissom, name)
        if name not in functions and callable(value):
            signature = inspect.signature(value)
            add(name, {key: str(p.annotation) for key, p in signature.parameters.items()})
    return functions


# How each is called.


def _a(*values):
    return f"v.array({list(values)})"


_IVP = {
    "fun": "lambda t, y: -y",
    "t0": "0.0",
    "t_bound": "1.0",
    "y0": _a(1.0, 2.0),
    "rtol": "1e-4",
    "atol": "1e-6",
    "first_step": "0.1",
    "max_step": "0.5",
    "min_step": "0.0",
    "max_steps": "1000",
    "vectorized": "False",
}
_STATE = {"q": _a(0.1, 0.2), "qd": _a(0.3, -0.1), "qdd": _a(-0.2, 0.5), "t": "0.1"}
_MODEL = "v.MODELS['{model}']()"
_ENERGIES = ("kinetic", "elastic", "gravitational", "loads", "dissipated", "work")
_TABLE = "([0.0, 0.1, 0.2], [0.01, 0.02, 0.015])"
_STRAIN = "lambda X: (0, 0.1 * X, 0, 1, 0, 0)"
_TURN = "lambda t: (np.cos(t / 2), np.sin(t / 2), 0, 0)"

#: Arguments with which a callable works. A list has alternatives. Those of methods start at an object, `self`.
#: A new callable without an entry here fails a test.
RECIPES: dict[str, dict | list[dict]] = {
    "DOP853": _IVP | {"controller": "'PI'"},
    "RK45": _IVP | {"controller": "'I'"},
    "Radau": _IVP | {"jac": "lambda t, y: -np.eye(2)"},
    "Balance": {name: _a(1.0, 0.5, 0.2) for name in _ENERGIES},
    "BaseMotion": [
        {"translation": "lambda t: (t, 0, 0.1 * t * t)", "axis": _a(0.0, 0.0, 1.0), "angle": "lambda t: t"},
        {"translation": "([0, 1, 2], [[0, 0, 0], [0, 0, 1], [0, 0, 1]])", "rotation": _TURN},
        {"axis": "(0, 1, 0)", "angle": "lissom.Harmonic(0.1, 2.0)"},
    ],
    "Body": {"mass": "0.1", "at": "0.1", "centre": _a(0.0, 0.0, 0.01), "inertia": _a(1e-5, 1e-5, 1e-5)},
    "Fluid": {
        "density": "1000.0",
        "velocity": _a(0.0, 0.1, 0.0),
        "viscous_drag": _a(0.1, 0.1),
        "drag_coefficients": _a(1.0, 0.1),
        "added_mass_coefficient": "1.0",
        "buoyancy": "True",
    },
    "Harmonic": {
        "amplitude": _a(0.0, 0.0, 1.0),
        "frequency": "2.0",
        "phase": "0.1",
        "mean": _a(0.0, 1.0, 0.0),
        "rate": _a(0.0, 0.0, 0.1),
    },
    "LinearModel": {
        "A": "np.eye(2)",
        "B": "np.eye(2)",
        "C": "np.eye(2)",
        "D": "np.eye(2)",
        "states": "('a', 'b')",
        "inputs": "('a', 'b')",
        "outputs": "('a', 'b')",
    },
    "Load": [
        {"force": _a(0.0, 0.0, 1.0), "moment": _a(0.0, 0.1, 0.0), "at": "0.1", "frame": "'body'"},
        {"force": "lambda t: (0, 0, t)", "along": _a(0.0, 0.1)},
        {"moment": "([0, 1], [[0, 0, 0], [0, 0, 1]])"},
    ],
    "Profile": [
        {"length": "0.2", "stations": _a(0.0, 0.1, 0.2), "values": _a(1.0, 2.0, 1.0)},
        {"length": "0.2", "coefficients": _a(1.0, 0.1)},
    ],
    "Profile.__call__": {"self": "lissom.Profile(0.2, coefficients=[1.0, 0.1])", "X": _a(0.0, 0.1)},
    "Rod": {
        "segments": "[v.segment(), v.segment()]",
        "base_position": _a(0.0, 0.0, 1.0),
        "base_orientation": _a(1.0, 0.0, 0.0, 0.0),
        "gravity": _a(0.0, 0.0, -9.81),
        "tip_force": _a(0.0, 0.1, 0.0),
        "tip_moment": _a(0.0, 0.1, 0.0),
        "tip_mass": "0.1",
        "loads": "[lissom.Load(force=(0, 0, 1), at=0.1)]",
        "bodies": "[lissom.Body(0.1, at=0.1)]",
        "base_motion": "lissom.BaseMotion(translation=lissom.Harmonic((0, 0, 0.01), 2.0))",
        "supports": "[lissom.Support(stiffness=3.0)]",
        "fluid": "lissom.Fluid(1000.0)",
    },
    "Rod.explain": {"self": _MODEL},
    "Rod.pose": {"self": "v.moving()", "q": _a(0.1, 0.2), "X": _a(0.0, 0.1, 0.2), "t": "0.1"},
    "Rod.jacobian": {"self": "v.moving()", "q": _a(0.1, 0.2), "X": "0.1", "t": "0.1"},
    "Rod.velocity": {"self": "v.moving()", "q": _a(0.1, 0.2), "qd": _a(0.1, 0.2), "X": "0.1", "t": "0.1"},
    "Rod.base_wrench": {"self": "v.moving()"} | _STATE,
    "Scene.load": {"path": "'scene.toml'"},
    "Scene.loads": {"text": "v.scene().text", "name": "'a'"},
    "Scene.schema": {},
    "Scene.run": {"self": "v.scene()"},
    "Section.circle": [{"radius": "0.01", "length": "0.2"}, {"radius": "lambda X: 0.01 + X", "length": "0.2"}],
    "Section.hollow_circle": {"outer": "(0.02, 0.01)", "inner": "0.005", "length": "0.2"},
    "Section.rectangle": [
        {"width": "lambda X: 0.01 + X", "height": "0.02", "length": "0.2"},
        {"width": "0.01", "height": _TABLE, "length": "0.2"},
    ],
    "Section.ellipse": {"semi_axis_y": "0.01", "semi_axis_z": "(0.01, 0.02)", "length": "0.2"},
    "Section.given": [
        {
            "stiffness": _a(1.0, 1.0, 1.0, 100.0, 50.0, 50.0),
            "mass": "0.1",
            "inertia": _a(1e-5, 1e-5, 1e-5),
            "centre": _a(0.001, 0.0),
            "length": "0.2",
        },
        {"stiffness": "lambda X: np.ones(6)", "mass": "lambda X: 0.1 + X", "length": "0.2"},
    ],
    "Section.area": {"self": "lissom.Section.circle((0.01, 0.02))", "x": "0.1"},
    "Section.second_moments": {"self": "lissom.Section.rectangle(0.01, 0.02)", "x": "0.1"},
    "Section.torsion_constant": {"self": "lissom.Section.rectangle(0.01, 0.02)", "x": "0.1"},
    "Section.cowper": {"self": "lissom.Section.hollow_circle(0.02, 0.01)", "poisson_ratio": "0.3", "x": "0.1"},
    "Section.half_extents": {"self": "lissom.Section.ellipse(0.01, 0.02)", "x": "0.1"},
    "Segment": [
        {
            "length": "0.2",
            "radius": "(0.01, 0.02)",
            "young_modulus": "3e5",
            "shear_modulus": "1e5",
            "density": "1000.0",
            "modes": "{'bend_y': 2, 'torsion': 1}",
            "retardation_time": "0.01",
            "reference_strain": _a(0.0, 1.0, 0.0, 1.0, 0.0, 0.0),
            "shear_correction": "0.9",
            "nodes": "16",
            "basis": "'chebyshev'",
        },
        {
            "length": "0.2",
            "radius": "lambda X: 0.01 + 0.1 * X",
            "young_modulus": "3e5",
            "shear_modulus": "1e5",
            "density": "1000.0",
            "modes": "{'bend_y': 2}",
            "reference_strain": _STRAIN,
            "shear_correction": "'cowper'",
        },
        {"length": "0.2", "modes": "{'stretch': 1}", "section": "lissom.Section.given(np.ones(6), 0.1)"},
    ],
    "Segment.stiffness": {"self": "v.segment()", "X": "0.1"},
    "Segment.inertia": {"self": "v.segment()", "X": "0.1"},
    "SpringPendulum": {"length": "1.0", "mass": "1.0", "stiffness": "10.0", "gravity": "9.81"},
    "SpringPendulum.explain": {"self": "v.pendulum()"},
    "Support": {
        "stiffness": _a(1.0, 2.0, 3.0),
        "rotational_stiffness": _a(0.1, 0.1, 0.1),
        "damping": "0.1",
        "rotational_damping": "0.1",
        "at": "0.1",
        "position": _a(0.1, 0.0, 0.0),
        "orientation": _a(1.0, 0.0, 0.0, 0.0),
    },
    "Model.check_shape": {"self": _MODEL, "q": _a(0.1, 0.2)},
    "Model.inverse_dynamics": {"self": _MODEL} | _STATE,
    "Model.mass_matrix": {"self": _MODEL, "q": _a(0.1, 0.2)},
    "Model.forward_dynamics": {"self": _MODEL} | {k: e for k, e in _STATE.items() if k != "qdd"},
    "Model.tangent": {"self": _MODEL} | _STATE,
    "Model.energy": {"self": _MODEL} | {k: e for k, e in _STATE.items() if k != "qdd"},
    "Model.dissipated_power": {"self": _MODEL} | {k: e for k, e in _STATE.items() if k != "qdd"},
    "Model.supplied_power": {"self": _MODEL} | _STATE,
    "DenseOutput.__call__": {
        "self": "lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0, 2.0], dense_output=True).sol",
        "t": _a(0.0, 0.5),
    },
    "OdeSolver.step": {"self": "v.stepper('{solver}')"},
    "OdeSolver.dense_output": {"self": "v.stepper('{solver}')"},
    "OdeSolver.error_estimate": {"self": "v.stepper('{solver}')"},
    "check_jacobian": {
        "fun": "lambda x: x * x",
        "jac": "lambda x: np.diag(2 * x)",
        "x": _a(1.0, 2.0),
        "x_scale": _a(1.0, 1.0),
    },
    "choose_modes": {
        "rod": "v.planar()",
        "t_end": "0.02",
        "rtol": "1e-1",
        "dt": "0.01",
        "segments": "[0]",
    },
    "continuation": {
        "model": _MODEL,
        "q0": _a(0.0, 0.0),
        "load_factor": "0.0",
        "direction": _a(1.0, 0.0),
        "bounds": "(0.0, 1.0)",
        "max_step": "0.25",
        "max_steps": "20",
        "t": "0.0",
        "tol": "1e-8",
    },
    "jacobian": {
        "fun": "lambda x: x * x",
        "x": _a(1.0, 2.0),
        "method": "'forward'",
        "x_scale": _a(1.0, 1.0),
        "args": "()",
    },
    "linearise": {"model": _MODEL, "q": _a(0.1, 0.2), "inputs": "'forces'", "outputs": "'coordinates'", "t": "0.1"},
    "modes": {"model": _MODEL, "q": _a(0.1, 0.2), "t": "0.1"},
    "newmark": {
        "residual": "lambda t, q, v, a: a + 0.1 * v + q",
        "t_span": "(0.0, 0.2)",
        "q0": _a(1.0, 0.0),
        "v0": _a(0.0, 1.0),
        "dt": "0.05",
        "rtol": "1e-6",
        "atol": "1e-9",
        "jac": "lambda t, q, v, a: (np.eye(2), 0.1 * np.eye(2), np.eye(2))",
        "adaptive": "True",
        "max_step": "0.1",
        "max_steps": "200",
        "t_eval": _a(0.0, 0.1, 0.2),
        "a0": _a(-1.0, -0.1),
        "callback": "lambda t, q, v, a: None",
    },
    "root": {
        "fun": "lambda x: x * x - 2.0",
        "x0": _a(1.0, 2.0),
        "jac": "lambda x: np.diag(2 * x)",
        "method": "'trust_region'",
        "tol": "1e-8",
        "max_iter": "50",
        "xtol": "1e-8",
        "x_scale": _a(1.0, 1.0),
        "f_scale": _a(1.0, 1.0),
        "max_step": "10.0",
        "history": "True",
    },
    "simulate": {
        "model": _MODEL,
        "t_end": "0.05",
        "q0": _a(0.1, 0.2),
        "v0": _a(0.0, 0.0),
        "method": "'{method}'",
        "dt": "0.01",
        "rtol": "1e-4",
        "t_eval": _a(0.0, 0.01, 0.05),
        "progress": "lambda t: None",
        "max_steps": "500",
    },
    "solve_ivp": {
        "fun": "lambda t, y: -y",
        "t_span": "(0.0, 1.0)",
        "y0": _a(1.0, 2.0),
        "method": "'{solver}'",
        "t_eval": _a(0.0, 0.5, 1.0),
        "dense_output": "True",
        "events": "lambda t, y: y[0] - 0.5",
        "rtol": "1e-4",
        "atol": _a(1e-6, 1e-6),
        "max_steps": "1000",
        "callback": "lambda t, y: None",
    },
    "statics": [
        {"model": _MODEL, "load_steps": "5", "t": "0.0", "tol": "1e-8", "max_iter": "50", "max_steps": "50"},
        {"model": _MODEL, "load_steps": _a(0.0, 0.5, 1.0), "method": "'load_path'"},
        {"model": _MODEL, "q0": _a(0.0, 0.0), "method": "'descent'"},
    ],
}
#: Classes that only functions make, and exceptions: calling them must raise, or make an exception.
RECIPES |= {
    name: {}
    for name in (
        "ContinuationResult ConvergenceError CriticalPoint DenseOutput Energy EquilibriumPath JacobianCheck "
        "LissomError Model ModesResult MotionResult OdeResult OdeSolver RootResult Scene SceneError SceneProblem "
        "Section SimulationSettings StaticsResult Statistics"
    ).split()
}
#: What fills the braces.
CHOICES = {
    "model": list(v.MODELS),
    "solver": ["RK45", "DOP853", "Radau"],
    "method": ["newmark", "hht", "generalised_alpha", "rk45", "dop853", "radau", "auto", "central_difference"],
}
#: Parameters whose values are not judged as numbers: anything may be passed on.
OPAQUE = {"args", "options"}
#: Callbacks whose values are a wish, not a number.
WISHES = {"callback", "progress"}

#: No number, though NumPy makes one of some.
NO_NUMBER = [
    "'0.5'",
    "b'0.5'",
    "['0.1', '0.2']",
    "np.array(['0.1', '0.2'])",
    "np.datetime64(1, 's')",
    "np.array([1, 2], dtype='m8[s]')",
    "np.ma.masked_array([0.1, 0.2], [False, True])",
    "0.1 + 0.2j",
    "np.array([0.1, 0.2j])",
    "{}",
    "{1.0, 2.0}",
    "lissom.Rod",
    "np",
    "Ellipsis",
    "lambda: 3",
    "v.pendulum()",
    "[None, None]",
    "np.array([None, 1.0])",
    "np.zeros(2, dtype=[('a', 'f8'), ('b', 'i4')])",
    "v.Address()",
    "v.nested()",
    "[[0.1], [0.1, 0.2]]",
]
#: Numbers and shapes at the edge: refused, or taken, but neither a crash nor NaN.
EDGE = [
    "None",
    "True",
    "0",
    "0.0",
    "-0.0",
    "-1",
    "1",
    "2",
    "3",
    "65",
    "10**6",
    "10**9",
    "2**31",
    "2**63",
    "2**64",
    "-(2**63)",
    "10**400",
    "1e-320",
    "5e-324",
    "1e-300",
    "1e-30",
    "1e15",
    "1e100",
    "1e300",
    "1.7976931348623157e308",
    "float('inf')",
    "-float('inf')",
    "float('nan')",
    "np.float32(0.1)",
    "np.float16(0.1)",
    "np.longdouble('0.1')",
    "np.int8(3)",
    "np.array(0.1)",
    "np.array([0.1])",
    "np.array([[0.1, 0.2]])",
    "np.array([[0.1], [0.2]])",
    "np.zeros((0,))",
    "np.zeros((0, 2))",
    "np.zeros((2, 0))",
    "np.zeros((2,) * 20)",
    "np.zeros(3)",
    "np.zeros(1000)",
    "np.full(2, np.nan)",
    "np.full(2, np.inf)",
    "np.full(2, 1e308)",
    "np.full(2, 5e-324)",
    "np.full(6, 1e300)",
    "np.full(3, 1e160)",
    "np.array([1e-300, 1e300])",
    "np.broadcast_to(0.5, (10**5,))",
    "np.broadcast_to(0.5, (10**7,))",
    "np.broadcast_to(0.5, (2**40,))",
    "np.broadcast_to(0.5, (2**20, 2**20))",
    "np.array([True, False])",
    "np.array([1, 2], dtype='u1')",
    "np.array([0.1, 0.2], dtype=object)",
    "np.array([1, 2], dtype='>i2')",
    "np.asmatrix([[0.1, 0.2]])",
    "range(2)",
    "range(10**9)",
    "iter([0.1, 0.2])",
    "(x for x in (0.1, 0.2))",
    "memoryview(np.array([0.1, 0.2]))",
    "bytearray(16)",
    "[]",
    "()",
    "''",
    "'\\0'",
    "'\\ud800'",
    "'x' * 10**6",
    "[[[[[]]]]]",
    "[0.1] * 10**5",
    "([0.0, 1.0], [0.1, 0.2])",
    "([0.0, np.nan], [0.1, 0.2])",
    "([1.0, 0.0], [0.1, 0.2])",
    "([0.0, 5e-324], [1e308, -1e308])",
    "([], [])",
    "v.BadFloat()",
    "v.LyingLength()",
    "v.LyingArray()",
    "v.segment()",
    "[v.segment()] * 300",
    "[v.segment(), None]",
    "lissom.Harmonic(1e308, 1e308)",
    "lissom.Harmonic(0.1, 1e-300)",
    "lissom.Harmonic((0, 0, 0.1), 1.0)",
    "lissom.Profile(0.2, coefficients=[0.1])",
    "lissom.Profile(1e-300, coefficients=[0.1] * 60)",
    "lissom.Section.circle(0.01)",
    "lambda *a: 0.1",
    "lambda *a: np.nan",
    "lambda *a: v._raise(v.Boom())",
    "lambda *a: (0, 0, 0, 1, 0, 0)",
    "lambda *a: (0, 1e15, 0, 1, 0, 0)",
    "lambda *a: 1e300",
    "lambda *a: -1.0",
    "lambda *a: np.zeros(10**7)",
    "{'bend_y': 64}",
    "{'bend_y': 10**12}",
    "{'bend_y': True}",
    "{'bend_y': 2.0}",
    "{0: 1}",
    "{'bend_y': None}",
    "'newton'",
    "'RK45'",
    "'Radau'",
    "'auto'",
    "'central'",
]


# Making cases.


def make(rng: np.random.Generator) -> bytes:
    """A random script."""
    name = str(rng.choice(NAMES, p=WEIGHTS))
    function = FUNCTIONS[name]
    recipe = RECIPES[name]
    recipe = dict(recipe[rng.integers(len(recipe))] if isinstance(recipe, list) else recipe)
    recipe = {key: _fill(text, rng) for key, text in recipe.items()}
    others = [key for key in recipe if key != "self" and rng.random() < 0.25 and key in OPTIONAL.get(name, ())]
    for key in others:
        del recipe[key]
    changed = [_callback, _layout, _no_number, _edge][rng.choice(4, p=[0.3, 0.15, 0.2, 0.35])]
    return changed(function, recipe, rng).encode(errors="surrogatepass")


def _fill(text: str, rng) -> str:
    for name, choices in CHOICES.items():
        if "{" + name + "}" in text:
            text = text.replace("{" + name + "}", str(rng.choice(choices)))
    return text


def script(function: Function, arguments: dict[str, str], parameters="") -> str:
    """The call as a function of its own; an argument a line, so that a line can be left out."""
    target = f"lissom.{function.name}"
    arguments = dict(arguments)
    if "self" in arguments:
        target = f"{arguments.pop('self')}.{function.name.rpartition('.')[2]}"
    lines = "".join(f"        {key}={text},\n" for key, text in arguments.items())
    return f"def call({parameters}):\n    return {target}(\n{lines}    )\n"


def _edge(function, arguments, rng) -> str:
    """Some arguments are at the edge."""
    known = list(function.parameters)
    if not known:
        return (HEAD + script(function, arguments)).replace("(\n    )", f"({rng.choice(EDGE)})")
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        arguments[str(rng.choice(known))] = str(rng.choice(EDGE))
    return HEAD + script(function, arguments)


def _numeric(annotation: str) -> bool:
    """Whether only numbers, and functions of the package, make sense."""
    words = ("ArrayLike", "float", "int", "_Size", "_Along", "_Vector")
    others = ("str", "Literal", "Any", "dict", "args", "Iterable", "Model")
    return any(word in annotation for word in words) and not any(word in annotation for word in others)


def _no_number(function, arguments, rng) -> str:
    """One argument is no number where only a number makes sense."""
    known = [key for key, annotation in function.parameters.items() if _numeric(annotation) and key not in OPAQUE]
    if not known:
        return _edge(function, arguments, rng)
    key, value = str(rng.choice(known)), str(rng.choice(NO_NUMBER))
    if value.startswith("lambda") and "Callable" in function.parameters[key] + ALIASES:
        return _edge(function, arguments, rng)
    arguments[key] = value
    return HEAD + f"forbidden = {f'{key}: {value}'!r}\n\n" + script(function, arguments)


def _layout(function, arguments, rng) -> str:
    """The same arrays in another layout give the same result."""
    known = [key for key, text in arguments.items() if text.startswith("v.array")]
    if not known:
        return _edge(function, arguments, rng)
    changed = dict(arguments)
    for key in known:
        if rng.random() < 0.7:
            changed[key] = changed[key][2:-1] + f", {str(rng.choice(list(v.LAYOUTS)))!r})"
    return HEAD + "layouts = True\n\n" + script(function, changed, "array=v.array")


def _callback(function, arguments, rng) -> str:
    """One callback misbehaves."""
    known = [key for key, text in arguments.items() if text.startswith("lambda")]
    if not known:
        return _edge(function, arguments, rng)
    key = str(rng.choice(known))
    kind = str(rng.choice(v.KINDS))
    table = {"nonsense": v.NONSENSE, "error": v.ERRORS, "number": v.NUMBERS, "deed": v.DEEDS, "layout": v.LAYOUTS}
    what = str(rng.choice(list(table[kind]))) if kind in table else ""
    after = int(rng.choice([0, 0, 1, 2, 5, 20]))
    good = arguments[key]
    arguments[key] = f"v.callback({good}, {kind!r}, {what!r}, {after}, lambda: call())"
    judged = f"watched = {key!r}\n\n" if kind == "nonsense" and key not in WISHES or kind == "error" else ""
    return HEAD + judged + script(function, arguments)


def protocols() -> dict[str, bytes]:
    """A script for each callable: it works, and what it returns can be shown, compared, copied and pickled."""
    scripts = {}
    for name, recipes in RECIPES.items():
        if name == "Scene.load":
            continue
        for number, recipe in enumerate(recipes if isinstance(recipes, list) else [recipes]):
            recipe = {key: _first(text) for key, text in recipe.items()}
            if recipe or name in ("Scene.schema",):
                text = HEAD + "works = True\n\n" + script(FUNCTIONS[name], recipe)
                scripts[f"{name}-{number}"] = text.encode()
    return scripts


def _first(text: str) -> str:
    for name, choices in CHOICES.items():
        text = text.replace("{" + name + "}", choices[0])
    return text


def _optional() -> dict[str, tuple[str, ...]]:
    """Of each callable the parameters that can be left out, by its own signature."""
    optional = {}
    for name in FUNCTIONS:
        value: typing.Any = lissom
        for part in name.split("."):
            value = getattr(value, part)
        try:
            parameters = inspect.signature(value).parameters.values()
        except (TypeError, ValueError):
            continue
        optional[name] = tuple(p.name for p in parameters if p.default is not p.empty)
    return optional


FUNCTIONS = discover()
OPTIONAL = _optional()
#: Every callable, the oftener the more parameters it has.
NAMES = sorted(FUNCTIONS)
WEIGHTS = np.array([0.3 + len(FUNCTIONS[name].parameters) for name in NAMES])
WEIGHTS /= WEIGHTS.sum()
#: The stubs' own names for annotations that include functions.
ALIASES = "Callable"


# Running and judging.


def prepare() -> None:
    np.seterr(all="ignore")


def where(path: Path) -> str:
    """What the script calls."""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("    return "):
            text = line[11:].rstrip("(")
            return text.split("(")[-1] if text.startswith("lissom") else text.rpartition(".")[2].split("(")[0]
    return path.stem


def run(path: Path, clock) -> judge.Outcome:
    place = where(path)
    v.reset()
    space: dict = {"__name__": "case", "__file__": str(path)}
    try:
        exec(compile(path.read_bytes(), str(path), "exec"), space)
    except RecursionError:
        raise
    except Exception as error:
        return judge.Outcome("undecided", f"the script itself: {error!r}")
    try:
        result = space["call"]()
    except KeyboardInterrupt:
        if clock.over:
            return _slow(place)
        raise
    except BaseException as error:
        return _raised(error, space, place)
    try:
        return _returned(result, space, place)
    except v.Boom:
        return judge.Outcome("done", "what came back holds an object that raises")


#: What only holds the numbers that it was given.
CONTAINERS = ("lissom.Balance", "lissom.LinearModel")

#: What may take long, because that is what it was asked for.
LONG = ("solve_ivp", "simulate", "newmark", "root", "statics", "continuation", "choose_modes", "run", "step")


def _slow(place: str) -> judge.Outcome:
    if place.rpartition(".")[2] in LONG:
        return judge.Outcome("slow", "ended by Ctrl-C")
    return judge.found("hang", place, "takes too long, but hears Ctrl-C")


def _raised(error, space, place) -> judge.Outcome:
    if space.get("works") or ("layouts" in space and _has_layout_fault(space)):
        text = f"refused though right: {type(error).__name__}: {error}"
        return judge.found("exception", place, text, "another layout" if "layouts" in space else None)
    if _own(error):
        return judge.Outcome("refused", f"the callback's own {type(error).__name__}")
    if "error" in v.happened and not isinstance(error, RecursionError):
        return judge.found("swallowed", place, f"another exception instead: {type(error).__name__}: {error}")
    if isinstance(error, RuntimeError) and any(words in str(error) for words in OUT_OF_TURN):
        return judge.Outcome("refused", str(error))
    if isinstance(error, FileNotFoundError | IsADirectoryError | PermissionError):
        return judge.Outcome("refused", str(error))
    return judge.of_exception(error, place, EXPECTED)


def _has_layout_fault(space) -> bool:
    """Whether the plain call works, so that the layout is what was refused."""
    try:
        space["call"](v.plain)
    except Exception:
        return False
    return True


def _own(error) -> bool:
    """Whether the exception was raised by the script's or a callback's own lines."""
    if isinstance(error, v.Boom | v.BaseBoom) or "boom" in str(error):
        return True
    frames = traceback.extract_tb(error.__traceback__)[2:]
    return any(frame.filename == v.__file__ or frame.name == "<lambda>" for frame in frames)


def _returned(result, space, place) -> judge.Outcome:
    if "forbidden" in space:
        key, _, value = space["forbidden"].partition(": ")
        return judge.found("silent", f"{place} {key}", f"taken: {value}", f"taken for a number: {value}")
    if "error" in v.happened and getattr(result, "success", None) is not False:
        return judge.found("swallowed", place, "success though the callback raised")
    if "watched" in space and v.happened and getattr(result, "success", None) is not False:
        what = f"a callback's {v.happened[0]} taken for a number"
        return judge.found("silent", f"{place} {space['watched']}", what, what)
    text = getattr(result, "message", "")
    if isinstance(text, str) and len(text) > judge.LONGEST_MESSAGE:
        return judge.found("message", place, "the result's message is too long")
    nan = None if place in CONTAINERS else judge.nan_in(result)
    if nan:
        return judge.found("nan", place, f"{nan} is NaN")
    if "layouts" in space:
        different = v.difference(result, space["call"](v.plain))
        if different:
            return judge.found("silent", place, f"another layout, another {different}", "another layout")
    try:
        if space.get("works"):
            v.protocol(result)
        else:
            repr(result)
    except BaseException as error:
        if sys.exc_info()[0] in (KeyboardInterrupt, MemoryError) or _own(error):
            raise
        text = f"afterwards: {type(error).__name__}: {error}"
        return judge.found("exception", place, text, "cannot be pickled" if "cannot pickle" in text else None)
    return judge.Outcome("failed" if getattr(result, "success", True) is False else "done")
