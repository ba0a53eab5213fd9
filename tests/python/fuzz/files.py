"""Damaged, nested and endless files: saved results in every format, URDF files, scenes that import.

A case is a line of JSON, which names the file, and lines of changes to it. What `load` takes must be what was
saved, or a result that can be used; everything else is refused with a documented exception.
"""

import json
import os
import socket
import tempfile
import warnings
import zlib
from functools import cache
from pathlib import Path

import numpy as np

import lissom
from fuzz import damage, judge
from fuzz import values as v
from lissom import urdf
from lissom.results import io as result_files
from lissom.results import records

NAME = "files"
SUFFIX = ".case"

KINDS = {
    "record": 0.25,
    "repaired": 0.15,
    "tree": 0.2,
    ".npz": 0.1,
    ".nc": 0.1,
    "urdf": 0.12,
    "scene": 0.05,
    "special": 0.03,
}
#: What may be refused, and how.
REFUSED = (ValueError, OSError, lissom.LissomError)
SPECIAL = ("fifo", "zero", "random", "socket", "folder", "loop", "missing", "empty", "tty")
SUFFIXES = (".lissom", ".npz", ".nc", ".urdf", ".toml")

#: Values for a node of a tree of JSON.
NODES = (
    *(None, True, 0, -1, 2**63, 2**70, 10**400, 1e308, 0.1, "", "x", "\ud800", [], {}, [[]], [None] * 3),
    *({"model": 0}, {"model": 10**9}, {"float": "nan"}, {"float": "x"}, {"tuple": []}, {"dict": [["a", 1]]}),
    *(
        {"array": ["<f8", [2]]},
        {"array": ["<f8", [2**62, 2**62]]},
        {"array": ["|O8", [1]]},
        {"scalar": ["<f8", []]},
    ),
    *({"fields": ["Link", {}]}, {"made": ["Robot", None, [], {}]}, {"made": ["Rod", "_restore", [], {}]}),
)


@cache
def results() -> tuple:
    """One result of each kind that `save` takes. Shape and path have large errors by few modes."""
    planar = v.planar()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        shape = lissom.statics(v.actuated())
        path = lissom.continuation(planar, max_steps=5)
    return (
        lissom.simulate(planar, 0.02),
        lissom.simulate(v.touching(), 0.01),
        shape,
        path,
        lissom.modes(planar, [0.0, 0.0]),
        lissom.simulate_many(planar, 0.02, q0=np.zeros((2, 2))),
        lissom.sensitivity(planar, 0.02, ["q0"]),
        planar.reach("rod", planar.pose([0.1, 0.2])),
    )


@cache
def saved(number: int, suffix: str) -> bytes:
    result = results()[number]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"x{suffix}"
        result.save(path)
        return path.read_bytes()


def prepare() -> None:
    np.seterr(all="ignore")
    warnings.simplefilter("ignore")


def make(rng: np.random.Generator) -> bytes:
    kind = str(rng.choice(list(KINDS), p=list(KINDS.values())))
    head = {"kind": kind, "number": int(rng.integers(len(results()))), "seed": int(rng.integers(2**31))}
    return "\n".join([json.dumps(head), *damage.changes(rng)]).encode()


def where(path: Path) -> str:
    try:
        return json.loads(path.read_text(encoding="utf-8").partition("\n")[0])["kind"]
    except ValueError:
        return "files"


def run(path: Path, clock) -> judge.Outcome:
    first, *lines = path.read_text(encoding="utf-8").splitlines()
    head = json.loads(first)
    with tempfile.TemporaryDirectory() as folder:
        return READ[head["kind"]](Path(folder), head, lines)


def attempt(place: str, function, *arguments) -> tuple[judge.Outcome | None, object]:
    """A finding or a refusal, or else what the function returns."""
    try:
        return None, function(*arguments)
    except Exception as error:
        return judge.of_exception(error, place, REFUSED), None


def loaded(path: Path, place: str, original: object | None) -> judge.Outcome:
    """Load a file whose result, if it has one, is the original, or can be used like any other."""
    outcome, found = attempt(place, lissom.load, path)
    if outcome is not None:
        return outcome
    if type(found).__name__ not in result_files.RESULTS:
        return judge.found("silent", place, f"a {type(found).__name__} instead of a result")
    if original is not None:
        different = v.difference(original, found)
        if different:
            return judge.found("silent", place, f"loaded, with another {different}")
        return judge.Outcome("done", "loaded as it was")
    outcome, _ = attempt(f"{place}, after loading", v.protocol, found)
    return outcome or judge.Outcome("done", "loaded")


def _record(folder, head, lines) -> judge.Outcome:
    """Bytes of a record: the checksum finds every change."""
    path = folder / "x.lissom"
    path.write_bytes(damage.damaged(saved(head["number"], ".lissom"), lines))
    return loaded(path, head["kind"], results()[head["number"]])


def _repaired(folder, head, lines) -> judge.Outcome:
    """The same with a checksum that fits, as a stranger would send it."""
    content = saved(head["number"], ".lissom").removeprefix(result_files.HEAD).partition(b"\n")[2]
    return _loaded_record(folder, head, damage.damaged(content, lines))


def _loaded_record(folder, head, content: bytes) -> judge.Outcome:
    line = result_files.VERSION.rstrip() + result_files.CHECKSUM + b"%08x\n" % zlib.crc32(content)
    path = folder / "x.lissom"
    path.write_bytes(result_files.HEAD + line + content)
    return loaded(path, head["kind"], None)


def _tree(folder, head, lines) -> judge.Outcome:
    """Other values at places of the tree; deep nesting; the same array often."""
    rng = np.random.default_rng(head["seed"])
    content = records.write(results()[head["number"]])
    end = records.LENGTH + int.from_bytes(content[: records.LENGTH], "little")
    tree, arrays = json.loads(content[records.LENGTH : end]), content[end:]
    for _ in lines:
        tree = _other(tree, rng)
    text = json.dumps(tree).encode()
    if rng.random() < 0.1:
        depth = int(rng.choice([100, 900, 5000, 100_000]))
        text = b'[{"tuple":[' * depth + text + b"]}]" * depth
    return _loaded_record(folder, head, len(text).to_bytes(records.LENGTH, "little") + text + arrays)


def _other(tree, rng):
    """The tree with another node somewhere."""
    if rng.random() < 0.15 or not isinstance(tree, list | dict) or not tree:
        return NODES[int(rng.integers(len(NODES)))]
    if isinstance(tree, list):
        place = int(rng.integers(len(tree)))
        if rng.random() < 0.1:
            return [*tree[:place], tree[place], *tree[place:]]
        return [*tree[:place], _other(tree[place], rng), *tree[place + 1 :]]
    key = str(rng.choice(list(tree)))
    if rng.random() < 0.1:
        return {f"{key}x" if name == key else name: value for name, value in tree.items()}
    return tree | {key: _other(tree[key], rng)}


def _archive(folder, head, lines) -> judge.Outcome:
    suffix = head["kind"]
    path = folder / f"x{suffix}"
    path.write_bytes(damage.damaged(saved(head["number"], suffix), lines))
    return loaded(path, suffix, results()[head["number"]])


#: Parts of URDF files, of which `{}` is where a number of the case stands.
PARTS_OF_URDF = (
    '<link name="l{0}"/>',
    '<joint name="j{0}" type="revolute"><parent link="a"/><child link="l{0}"/></joint>',
    '<limit lower="{0}" upper="1e400" effort="x"/>',
    "<!DOCTYPE r [<!ENTITY a 'aaaa'>]>",
    "&a;",
    "<!-- {0} -->",
    "<![CDATA[{0}]]>",
    '<x a{0}="1" a{0}="2"/>',
    '<?xml version="1.0" encoding="idna"?>',
    '<?xml version="1.0" encoding="utf-16"?>',
    '<inertial><mass value="{0}"/><origin rpy="1 2" xyz="nan 0 0"/></inertial>',
    '<mimic joint="j" multiplier="{0}"/>',
    "<a" + " b='1'" * 2000 + "/>",
    "".join(f"<a x{k}='1'>" for k in range(500)),
    "<a>" * 20_000,
    "\x00",
    "\ufeff",
)


def urdf_text(head, lines) -> bytes:
    rng = np.random.default_rng(head["seed"])
    text = Path(v.urdf()).read_text(encoding="utf-8")
    for _ in range(int(rng.integers(4))):
        at = int(rng.integers(len(text) + 1))
        part = PARTS_OF_URDF[int(rng.integers(len(PARTS_OF_URDF)))].replace(
            "{0}", str(int(rng.integers(100)))
        )
        text = text[:at] + part + text[at:]
    return damage.damaged(text.encode(errors="surrogatepass"), lines[: int(rng.integers(len(lines) + 1))])


def _urdf(folder, head, lines) -> judge.Outcome:
    path = folder / "x.urdf"
    path.write_bytes(urdf_text(head, lines))
    outcome, robot = attempt("urdf", urdf.robot_from_urdf, path)
    return outcome or judge.Outcome("done", f"{robot.n} coordinates")


def _scene(folder, head, lines) -> judge.Outcome:
    """A scene that imports a damaged file, from where it may or from elsewhere."""
    rng = np.random.default_rng(head["seed"])
    (folder / "inside").mkdir()
    (folder / "inside" / "x.urdf").write_bytes(urdf_text(head, lines))
    (folder / "outside.urdf").write_bytes(Path(v.urdf()).read_bytes())
    (folder / "inside" / "link.urdf").symlink_to(folder / "outside.urdf")
    os.mkfifo(folder / "inside" / "pipe.urdf")
    names = [
        "x.urdf",
        "../outside.urdf",
        "link.urdf",
        str(folder / "outside.urdf"),
        "pipe.urdf",
        "/dev/zero",
        ".",
        "\0",
    ]
    name = str(rng.choice(names))
    scene = folder / "inside" / "scene.toml"
    scene.write_text(
        f"version = 1\n[import]\nurdf = {json.dumps(name)}\n[simulation]\nt_end = 0.1\n", encoding="utf-8"
    )
    outcome, _ = attempt("scene", lissom.Scene.load, scene)
    if outcome is None and name not in ("x.urdf",):
        return judge.found("silent", "scene", f"read {name!r}", f"read {name!r}")
    return outcome or judge.Outcome("done", "read")


def _special(folder, head, lines) -> judge.Outcome:
    """What is no regular file is refused without reading on."""
    rng = np.random.default_rng(head["seed"])
    kind, suffix = str(rng.choice(SPECIAL)), str(rng.choice(SUFFIXES))
    path = folder / f"x{suffix}"
    match kind:
        case "fifo":
            os.mkfifo(path)
        case "zero" | "random" | "tty":
            path.symlink_to(f"/dev/{kind}")
        case "socket":
            socket.socket(socket.AF_UNIX).bind(str(path))
        case "folder":
            path.mkdir()
        case "loop":
            path.symlink_to(path)
        case "empty":
            path.write_bytes(b"")
    readers = {".urdf": urdf.robot_from_urdf, ".toml": lissom.Scene.load}
    # Scenes that the user names may come from a pipe.
    if suffix == ".toml" and kind in ("fifo", "tty"):
        return judge.Outcome("undecided", "waits for somebody to write")
    outcome, found = attempt(f"{kind}{suffix}", readers.get(suffix, lissom.load), path)
    return outcome or judge.found("silent", f"{kind}{suffix}", f"a {type(found).__name__} was read")


READ = {
    "record": _record,
    "repaired": _repaired,
    "tree": _tree,
    ".npz": _archive,
    ".nc": _archive,
    "urdf": _urdf,
    "scene": _scene,
    "special": _special,
}
