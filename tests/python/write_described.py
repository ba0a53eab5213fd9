"""Writes what follows from the tables of described parts: classes of the stubs, the JSON Schema.

Run it with the extension built.
"""

from pathlib import Path

import lissom
from lissom import _lissom

ROOT = Path(__file__).parents[2]
STUB = ROOT / "python/lissom/_lissom.pyi"
METHODS = ROOT / "python/lissom/methods/__init__.pyi"
SCHEMA = ROOT / "scenes/lissom-scene.schema.json"

#: The stubs before and behind them are written by hand.
MARKS = (
    "# Classes that are made from the tables of `description`; `test_description.py` compares them.\n",
    "# End of these classes.\n",
)

#: What classes of models have from their tables stands in them between these lines.
MARKS_OF_MODELS = ("    # From the table of `described::{}`.\n", "    # End of what is from it.\n")


def between(text, marks):
    """A text before, between and behind two lines."""
    before, rest = text.split(marks[0])
    inner, after = rest.split(marks[1], 1)
    return before, inner, after


def write(stub, made, marks=MARKS):
    """Replaces what is between two lines of a stub."""
    before, _, after = between(stub.read_text(encoding="utf-8"), marks)
    stub.write_text(before + marks[0] + made + marks[1] + after, encoding="utf-8")


def of_models():
    """What stands in the stub of each model, with the lines around it."""
    first, last = MARKS_OF_MODELS
    return [((first.format(name), last), text) for name, text in _lissom._stub_of_models()]


def main():
    write(STUB, _lissom._stub_of_parts())
    for marks, text in of_models():
        write(STUB, text, marks)
    write(METHODS, _lissom._stub_of_methods())
    SCHEMA.write_text(lissom.Scene.schema(), encoding="utf-8")


if __name__ == "__main__":
    main()
