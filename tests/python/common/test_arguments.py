"""Arguments of every public callable: values of the wrong kind are refused with the argument's name."""

import re
import signal

import numpy as np
import pytest

from fuzz import api
from fuzz.recipes import RECIPES

#: Seconds of processor time after which a call is interrupted: it accepted its arguments, and computes.
PATIENCE = 2.0

#: Values that are no number, as Python text.
NO_NUMBERS = [
    "True",
    "'text'",
    "b'x'",
    "('ball', 0.1)",
    "object()",
    "{'a': 1}",
    "lissom.Rod",
    "1j",
    "v.segment()",
]
#: Numbers beyond doubles, and beyond 64 bits.
TOO_LARGE = ["10**400", "-10**400"]
TOO_LONG = [*TOO_LARGE, "2**70"]
#: Values that are no text, and those that are neither True nor False.
NO_TEXT = ["3", "1.5", "True", "b'x'", "('ball', 0.1)", "object()", "[]", "lissom.Rod", "np.zeros(2)"]
NO_FLAGS = ["3", "1.5", "'text'", "[]", "object()", "np.zeros(2)"]
#: What no argument takes, except one that takes everything.
NOTHING = ["object()"]

#: Kinds of annotations, and values that they refuse.
KINDS = {
    r"float( \| None)?": NO_NUMBERS + TOO_LARGE,
    r"int( \| None)?": [*NO_NUMBERS, *TOO_LONG, "1.5"],
    r"str( \| None)?": NO_TEXT,
    r"bool( \| None)?": NO_FLAGS,
    r"(ArrayLike|_Inputs|_InputRows|Inputs|InputRows)( \| None)?": [
        "'text'",
        "object()",
        "{'a': 1}",
        "1j",
        *TOO_LARGE,
        "[10**400]",
        "[[1, [2]]]",
    ],
    r"Vector|_Vector|Sequence\[float\]": ["'text'", "object()", "1j", "(10**400, 0, 0)", "[[1, [2]]]"],
    r"str \| PathLike\[str\]|str \| os.PathLike\[str\]": [
        "3",
        "True",
        "1.5",
        "b'x'",
        "None",
        "object()",
        "10**400",
    ],
    r"Model|Robot|Rod": ["3", "'text'", "None", "object()"],
    r"(Fluid|BaseMotion|Section) \| None": ["3", "'text'", "object()"],
    r"Surface|Iterable\[\w+\]|Joint|(Body|Mimic) \| None": ["3", "object()", "('ball', 0.1)", "1.5"],
    r"_Number( \| None)?|_Size|_AlongRod": ["'text'", "object()", "{'a': 1}", "1j", *TOO_LARGE],
    r"Literal\[.*\]": ["3", "'nothing'", "object()", "np.zeros(2)"],
    r"Callable\[.*\](?: \| None)?": ["3", "'text'", "object()"],
}

#: Results and their parts, which functions create: they hold what they are given.
CREATED = {
    *("Balance", "ContactEvent", "Peak", "Touch", "LinearModel", "sensors.Sensor"),
    *("gym.Outcome", "gym.Start", "gym.States"),
    *("EquilibriumSensitivityResult", "EquilibriaResult", "FitResult", "FittedData", "SensitivityResult"),
}
#: Parameters that something else uses or that stand for several: what they refuse has the name of that.
OTHER_NAMES = {
    ("gym.RobotVectorEnv.step", "actions"): "action",
    ("actuate", "target"): "pose|target",
    # Beside several targets, each of which has its own.
    ("Robot.reach", "link"): "link|pose",
    ("Robot.reach", "position_weight"): "position_weight|pose",
    ("Robot.reach", "orientation_weight"): "orientation_weight|pose",
}
#: What results and methods of a recipe do not need, and do not look at.
UNUSED = {("EnsembleResult.save", "model"), ("solve_ivp", "jac")}
#: Data that take inputs by names, which only the model of a fit knows.
NAMED = {("NaturalFrequencies", "u"), ("RecordedMotion", "u"), ("StaticShapes", "u")}


def refused(annotation):
    """Values of the wrong kind for an annotation."""
    return next((wrong for kind, wrong in KINDS.items() if re.fullmatch(kind, annotation)), NOTHING)


def cases():
    """The name of a callable, a parameter, and arguments that are right but for those of this parameter."""
    for name, recipes in sorted(RECIPES.items()):
        function = api.FUNCTIONS[name]
        # Functions that create results alone have no recipe.
        if name in CREATED or not function.parameters:
            continue
        for number, recipe in enumerate(recipes if isinstance(recipes, list) else [recipes]):
            if recipe:
                yield pytest.param(
                    name, {key: api._first(text) for key, text in recipe.items()}, id=f"{name}-{number}"
                )


class Late(Exception):
    pass


def late(*_):
    raise Late


def attempt(function, arguments):
    """The exception of a call; None if it takes its arguments."""
    space = {}
    exec(compile(api.HEAD + api.script(function, arguments), "case", "exec"), space)
    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        with np.errstate(all="ignore"):
            space["call"]()
    except Late:
        return None
    except BaseException as error:
        return error
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    return None


@pytest.mark.parametrize(("name", "recipe"), list(cases()))
@pytest.mark.filterwarnings("ignore")
def test_arguments_of_the_wrong_kind_are_refused_by_name(name, recipe, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function = api.FUNCTIONS[name]
    wrong = []
    for parameter, annotation in function.parameters.items():
        if parameter in ("args", "options") or (name, parameter) in UNUSED:
            continue
        for value in refused(annotation):
            if (name, parameter) in NAMED and value == "{'a': 1}":
                continue
            if api._address(annotation) and api.WHOLE.match(value):
                continue
            error = attempt(function, recipe | {parameter: value})
            if error is None and annotation == "Any":
                continue
            known = OTHER_NAMES.get((name, parameter), rf"\b{parameter}\b")
            is_named = re.search(known, str(error)) is not None
            # Another argument may be wrong beside this one, which is right by itself.
            if type(error) not in (ValueError, TypeError) or not is_named:
                wrong.append(f"{parameter}={value} ({annotation}): {type(error).__name__}: {error}")
    assert wrong == []
