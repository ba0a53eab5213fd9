"""Stores of sweeps with lost or damaged chunks: a later call completes or refuses them.

A case is a line of JSON and lines of damage: a file of the store, by its place in the sorted list, and what
happens to it.
"""

import json
import shutil
import tempfile
import warnings
from functools import cache
from pathlib import Path

import numpy as np

import lissom
from fuzz import damage, judge

NAME = "stores"
SUFFIX = ".case"

#: What may refuse a store.
REFUSED = (ValueError, OSError, lissom.LissomError)
TEXT = """version = 1
[pendulum]
mass = 1.0
length = 1.0
stiffness = 10.0
q0 = [-0.7, 1.2]
[simulation]
t_end = 0.05
dt = 0.01
"""
DEEDS = ("remove", "empty", "folder", "bytes", "bytes", "bytes", "copy")


def prepare() -> None:
    warnings.simplefilter("ignore")


def swept(store: Path):
    scene = lissom.Scene.loads(TEXT)
    values = [1.0, 2.0, 3.0, 4.0]
    found = lissom.sweep(scene, {"pendulum.mass": values}, keep="states", store=store, workers=1)
    return found.load().drop_vars("wall_time")  # differs from run to run


@cache
def complete() -> tuple[Path, object]:
    """A complete store, and its results."""
    store = Path(tempfile.mkdtemp(prefix="fuzz-store-")) / "store"
    return store, swept(store)


def make(rng: np.random.Generator) -> bytes:
    lines = []
    for _ in range(int(rng.choice([1, 1, 2, 4]))):
        deed = str(rng.choice(DEEDS))
        more = damage.changes(rng)[0] if deed == "bytes" else str(int(rng.integers(10**6)))
        lines.append(f"{deed} {int(rng.integers(10**6))} {more}")
    return "\n".join([json.dumps({"kind": "store"}), *lines]).encode()


def where(path: Path) -> str:
    return "store"


def run(path: Path, clock) -> judge.Outcome:
    _, *lines = path.read_text(encoding="utf-8").splitlines()
    original, expected = complete()
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "store"
        shutil.copytree(original, store)
        for line in lines:
            _harm(store, *line.split(maxsplit=2))
        try:
            found = swept(store)
        except Exception as error:
            return judge.of_exception(error, "store", REFUSED)
        if not expected.equals(found):
            names = [name for name in expected if not expected[name].equals(found.get(name))]
            return judge.found("silent", "store", f"other results than before: {', '.join(names)}")
    return judge.Outcome("done", "the same results")


def _harm(store: Path, deed: str, number: str, more: str) -> None:
    files = sorted(path for path in store.rglob("*") if path.is_file())
    if not files:
        return
    file = files[int(number) * len(files) // 10**6]
    match deed:
        case "remove":
            file.unlink()
        case "empty":
            file.write_bytes(b"")
        case "folder":
            file.unlink()
            file.mkdir()
        case "bytes":
            file.write_bytes(damage.damaged(file.read_bytes(), [more]))
        case "copy":
            file.write_bytes(files[int(more) * len(files) // 10**6].read_bytes())
