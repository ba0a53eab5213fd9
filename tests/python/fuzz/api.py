"""The Python API: every public callable, in `__all__` and in the stubs, called with invalid or unusual
arguments.

A case is a self-contained script. `call()` is the call under test; further names specify the verdict:
`forbidden`, an argument that must be rejected; `layouts`, a result that must be bitwise equal to that with
plain arrays; `watched`, a callback whose value must be rejected; `works`, a call that must succeed.
"""

import ast
import inspect
import re
import sys
import traceback
import typing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import lissom
import lissom.gym
import lissom.sensors
from fuzz import judge
from fuzz import values as v
from fuzz.recipes import CALLABLES, CHOICES, EDGE, NO_NUMBER, OPAQUE, RECIPES, WISHES

NAME = "api"
SUFFIX = ".py"
STUB = Path(lissom.__file__).parent / "_lissom.pyi"

HEAD = "import lissom\nimport numpy as np\n\nfrom fuzz import values as v\n\n"
#: Exceptions that reject a call.
EXPECTED = (ValueError, TypeError, OverflowError, MemoryError, RecursionError, lissom.LissomError, v.Boom)
#: Messages that `OdeSolver` documents for a step at the wrong moment.
OUT_OF_TURN = ("in the middle of a step", "failed or finished solver", "Dense output is available", "step")


# Public callables.


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


#: Modules of the package whose public names are also tested.
MODULES = ("gym", "sensors")

#: Special methods in the stubs that are called by another name, or by `protocol`.
_SPECIAL = {"__new__": "", "__init__": "", "__call__": ".__call__"}


def discover() -> dict[str, Function]:
    """All public callables. Those of the compiled module come from its stubs, the others from inspection."""
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

    def add_python(name, value):
        parameters = inspect.signature(value).parameters
        add(name, {key: str(p.annotation) for key, p in parameters.items() if key != "self"})

    for name in lissom.__all__:
        value = getattr(lissom, name)
        if name not in functions and callable(value):
            add_python(name, value)
    for module in MODULES:
        for name in getattr(lissom, module).__all__:
            add_python(f"{module}.{name}", getattr(getattr(lissom, module), name))
    for name in ("measure", "read", "observe", "record", "reset", "copy"):
        add_python(f"sensors.Sensor.{name}", getattr(lissom.sensors.Sensor, name))
    add_python("LinearModel.discrete", lissom.LinearModel.discrete)
    for kind in ("RobotEnv", "RobotVectorEnv"):
        for name in ("reset", "step"):
            add_python(f"gym.{kind}.{name}", getattr(getattr(lissom.gym, kind), name))
    return functions


# Creating cases.

#: Values that are integers.
WHOLE = re.compile(r"True|np\.int|-?\(?[\d*()]+$")


def make(rng: np.random.Generator) -> bytes:
    """A random script."""
    name = str(rng.choice(NAMES, p=WEIGHTS))
    function = FUNCTIONS[name]
    recipe = RECIPES[name]
    recipe = dict(recipe[rng.integers(len(recipe))] if isinstance(recipe, list) else recipe)
    recipe = {key: _fill(text, rng) for key, text in recipe.items()}
    others = [
        key for key in recipe if key != "self" and rng.random() < 0.25 and key in OPTIONAL.get(name, ())
    ]
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
    """The call as a function, with one argument per line, so that lines can be left out."""
    target = f"lissom.{function.name}"
    arguments = dict(arguments)
    if "self" in arguments:
        target = f"{arguments.pop('self')}.{function.name.rpartition('.')[2]}"
    lines = "".join(f"        {key}={text},\n" for key, text in arguments.items())
    return f"def call({parameters}):\n    return {target}(\n{lines}    )\n"


def _edge(function, arguments, rng) -> str:
    """A call with some extreme arguments."""
    known = list(function.parameters)
    if not known:
        return (HEAD + script(function, arguments)).replace("(\n    )", f"({rng.choice(EDGE)})")
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        key, value = str(rng.choice(known)), str(rng.choice(EDGE))
        if not (_address(function.parameters[key]) and WHOLE.match(value)):
            arguments[key] = value
    return HEAD + script(function, arguments)


def _address(annotation: str) -> bool:
    """Whether an integer is the address of machine code, for which the caller is responsible."""
    return "Callable" in annotation and " int " in annotation


def _numeric(annotation: str) -> bool:
    """Whether only numbers, and functions of the package, are meaningful."""
    words = ("ArrayLike", "float", "int", "_Size", "_Along", "_Vector")
    others = ("str", "Literal", "Any", "dict", "args", "Iterable", "Model")
    return any(word in annotation for word in words) and not any(word in annotation for word in others)


def _no_number(function, arguments, rng) -> str:
    """A call with one argument that is not a number although a number is expected."""
    known = [
        key for key, annotation in function.parameters.items() if _numeric(annotation) and key not in OPAQUE
    ]
    if not known:
        return _edge(function, arguments, rng)
    key, value = str(rng.choice(known)), str(rng.choice(NO_NUMBER))
    if value in CALLABLES and any(word in function.parameters[key] for word in TAKE_FUNCTIONS):
        return _edge(function, arguments, rng)
    arguments[key] = value
    return HEAD + f"forbidden = {f'{key}: {value}'!r}\n\n" + script(function, arguments)


def _layout(function, arguments, rng) -> str:
    """A call with the same arrays in another layout, which must give the same result."""
    known = [key for key, text in arguments.items() if text.startswith("v.array")]
    if not known:
        return _edge(function, arguments, rng)
    changed = dict(arguments)
    for key in known:
        if rng.random() < 0.7:
            changed[key] = changed[key][2:-1] + f", {str(rng.choice(list(v.LAYOUTS)))!r})"
    return HEAD + "layouts = True\n\n" + script(function, changed, "array=v.array")


def _callback(function, arguments, rng) -> str:
    """A call with one misbehaving callback."""
    known = [key for key, text in arguments.items() if text.startswith("lambda")]
    if not known:
        return _edge(function, arguments, rng)
    key = str(rng.choice(known))
    kind = str(rng.choice(v.KINDS))
    table = {
        "nonsense": v.NONSENSE,
        "error": v.ERRORS,
        "number": v.NUMBERS,
        "deed": v.DEEDS,
        "layout": v.LAYOUTS,
    }
    what = str(rng.choice(list(table[kind]))) if kind in table else ""
    after = int(rng.choice([0, 0, 1, 2, 5, 20]))
    good = arguments[key]
    arguments[key] = f"v.callback({good}, {kind!r}, {what!r}, {after}, lambda: call())"
    judged = f"watched = {key!r}\n\n" if kind == "nonsense" and key not in WISHES else ""
    return HEAD + judged + script(function, arguments)


def protocols() -> dict[str, bytes]:
    """A script for each callable: it works, and its result can be printed, compared, copied and pickled."""
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
    """The optional parameters of each callable, from its own signature."""
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
#: Every callable, repeated according to its number of parameters.
NAMES = sorted(FUNCTIONS)
WEIGHTS = np.array([0.3 + len(FUNCTIONS[name].parameters) for name in NAMES])
WEIGHTS /= WEIGHTS.sum()
#: Annotations that include functions, also under the stubs' own names.
TAKE_FUNCTIONS = ("Callable", "_Size", "_Along", "_Vector")


# Running and judging.


def prepare() -> None:
    np.seterr(all="ignore")


def where(path: Path) -> str:
    """The callable of the script."""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("    return "):
            return line[11:].rstrip("(").rpartition(").")[2].removesuffix("()")
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


#: Classes that only contain the given numbers.
CONTAINERS = (
    "lissom.Balance",
    "lissom.ContactEvent",
    "lissom.LinearModel",
    "lissom.Peak",
    "lissom.Touch",
    "lissom.gym.Outcome",
    "lissom.gym.Start",
    "lissom.gym.States",
)

#: Callables that may take long, depending on their arguments.
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
    """Whether the plain call works, so that the layout was rejected."""
    try:
        space["call"](v.plain)
    except Exception:
        return False
    return True


def _own(error) -> bool:
    """Whether the exception was raised by the script or by a callback."""
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
