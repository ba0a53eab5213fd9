"""Robots: random ones, whose equilibria, verdicts, forces and runs have properties that need no other solver.

A case is a script that defines `robot`, a recipe (see `rendered`), and `question`, what is asked of it (see
`questions`).
"""

from pathlib import Path
from pprint import pformat

import numpy as np

from fuzz import families, judge, questions

NAME = "robots"
SUFFIX = ".py"

#: Words of what refuses random starts below the floor.
TOO_DEEP = ("is sunk into", "surfaces overlap")

#: Methods of `statics`, and those that find an equilibrium from anywhere.
SEARCHES = ("auto", "descent")
METHODS = ("auto", "descent", "newton", "newton", "load_path")
#: How often each question is asked, by family.
ASKED = {
    "tree": "balance verdict frequencies same_forces same_equilibrium saved forces inertia tangent cut runs",
    "balls": "balance balance verdict frequencies frequencies reached same_forces same_equilibrium runs",
    "cords": "balance reached verdict frequencies same_equilibrium same_equilibrium saved",
    "loops": "balance reached verdict verdict frequencies same_equilibrium same_equilibrium saved",
    "ground": "balance verdict verdict frequencies same_equilibrium",
    "floors": "balance cut cut verdict same_equilibrium",
}


def make(rng: np.random.Generator) -> bytes:
    """A random robot and a question."""
    family = families.FAMILIES[int(rng.integers(len(families.FAMILIES)))]
    recipe = family(rng)
    recipe = families.with_state(recipe, rng, families.STATES.get(family.__name__, 1.0))
    asked = str(rng.choice(ASKED[family.__name__].split()))
    question = {"ask": asked, "of": family.__name__}
    if asked in ("balance", "verdict", "frequencies", "reached", "same_equilibrium"):
        method = str(rng.choice(SEARCHES if asked == "reached" else METHODS))
        # A path of loads starts at the unloaded shape.
        question |= {"method": method, "start": bool(rng.random() < 0.7) and method != "load_path"}
    if asked in ("same_forces", "same_equilibrium"):
        changes = questions.CHANGES | (questions.IDLE if asked == "same_equilibrium" else {})
        kind = str(rng.choice(list(changes)))
        question |= {"change": [kind, str(rng.choice(list(changes[kind])))], "seed": int(rng.integers(1000))}
    if asked == "cut":
        question |= {"seed": int(rng.integers(1000))}
    return write(recipe, question).encode()


def write(recipe: dict, question: dict) -> str:
    """The case as a script, with one part of the robot a line."""
    text = "robot = {\n"
    for key, value in recipe.items():
        if isinstance(value, list):
            rows = "".join(f"        {_flat(item)},\n" for item in value)
            text += f"    {key!r}: [\n{rows}    ],\n"
        else:
            text += f"    {key!r}: {_flat(value)},\n"
    return text + "}\nquestion = " + _flat(question) + "\n"


def _flat(value) -> str:
    return pformat(value, width=10**9, sort_dicts=False)


def prepare() -> None:
    np.seterr(all="ignore")


def _case(path: Path) -> questions.Robot:
    space: dict = {}
    exec(compile(path.read_bytes(), str(path), "exec"), space)
    return questions.Robot(space["robot"], space["question"])


def _place(question: dict) -> str:
    """What faults of one place have in common: not the method, nor the very units."""
    kind = [f"({question['change'][0]})"] if "change" in question else []
    return " ".join([question["ask"].replace("_", " "), *kind, "of", question["of"]])


def where(path: Path) -> str:
    return _place(_case(path).question)


def run(path: Path, clock) -> judge.Outcome:
    place = "?"
    try:
        case = _case(path)
        place = _place(case.question)
        wrong = questions.QUESTIONS[case.question["ask"]](case)
        if wrong is None:
            return judge.Outcome("done", place=place)
        return judge.found("wrong", place, wrong, place)
    except questions.Undecided as error:
        return judge.Outcome("undecided", str(error), place=place)
    except KeyboardInterrupt:
        if clock.over:
            return judge.Outcome("slow", "ended by Ctrl-C")
        raise
    except (KeyError, NameError, SyntaxError, IndexError, AttributeError) as error:
        return judge.Outcome("undecided", f"the script itself: {error!r}")
    except BaseException as error:
        # Nothing else here is to be refused.
        if isinstance(error, ValueError) and any(word in str(error) for word in TOO_DEEP):
            return judge.Outcome("refused", str(error)[:300], place=place)
        return judge.of_exception(error, place, (MemoryError,))
