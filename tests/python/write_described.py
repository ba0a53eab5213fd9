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


def write(stub, classes):
    """Replaces the classes of a stub."""
    text = stub.read_text(encoding="utf-8")
    (before, rest), (_, after) = text.split(MARKS[0]), text.split(MARKS[1])
    assert MARKS[1] in rest
    stub.write_text(before + MARKS[0] + classes + MARKS[1] + after, encoding="utf-8")


def main():
    write(STUB, _lissom._stub_of_parts())
    write(METHODS, _lissom._stub_of_methods())
    SCHEMA.write_text(lissom.Scene.schema(), encoding="utf-8")


if __name__ == "__main__":
    main()
