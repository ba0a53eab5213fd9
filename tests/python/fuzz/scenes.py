"""Mutated scenes, through the command line: `check`, and if the scene is valid, `run` and another command."""

import contextlib
import io
import json
import math
import shutil
import tempfile
import tomllib
import traceback
import warnings
import zlib
from pathlib import Path

import h5py
import numpy as np

import lissom
from fuzz import judge, mutate
from lissom import cli
from lissom.urdf import UrdfWarning

NAME = "scenes"
SUFFIX = ".toml"
#: Initial scenes of the mutations: small scenes that together use every key, and the examples.
CORPUS = Path(__file__).parent / "corpus" / NAME
EXAMPLES = Path(__file__).parents[3] / "scenes"

#: Limits of scenes that are run: at most some seconds if nothing is wrong.
COORDINATES = 24
SEGMENTS = 8
NODES = 128
STEPS = 1000
KEPT = 5000
#: One in this many scenes is also run with a report, because drawing takes a second.
REPORTS = 12
#: Ratio of the tip's error to the tolerance above which a success of "auto" is wrong, as in the stress test.
FACTOR = 3.0
#: The same ratio for the adaptive methods, whose tolerances apply to single steps.
LOCAL_FACTOR = 1e4
#: Duration of motions that are compared, short because chaotic motion amplifies any error.
COMPARED = 0.3


def _seeds() -> list[dict]:
    paths = [*sorted(CORPUS.glob("*.toml")), *sorted(EXAMPLES.glob("*.toml"))]
    return [tomllib.loads(path.read_text(encoding="utf-8")) for path in paths]


SCHEMA = mutate.Schema(lissom.Scene.schema())
SEEDS = _seeds()


def make(rng: np.random.Generator) -> bytes:
    """A mutated scene of the corpus or the examples; one in ten is created from the schema alone."""
    start = SCHEMA.value(SCHEMA.root, rng) if rng.random() < 0.1 else SEEDS[int(rng.integers(len(SEEDS)))]
    tree = mutate.mutate_tree(start, rng, SCHEMA)
    text = mutate.write(tree).encode(errors="surrogatepass")
    return mutate.mutate_text(text, rng) if rng.random() < 0.12 else text


def prepare() -> None:
    np.seterr(all="ignore")


def where(path: Path) -> str:
    """The command that was running."""
    note = path.parent / "command.txt"
    return note.read_text() if note.exists() else "check"


def command(path: Path, words: list[str]) -> tuple[int, str]:
    """Exit code and output of the command line."""
    (path.parent / "command.txt").write_text(words[0])
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        try:
            cli.main(words)
        except SystemExit as end:
            return int(end.code or 0), output.getvalue()
        except KeyboardInterrupt:
            return 130, "Traceback (most recent call last): KeyboardInterrupt"
    raise AssertionError("the command line returned")


def run(path: Path, clock) -> judge.Outcome:
    folder = Path(tempfile.mkdtemp(dir=path.parent))
    try:
        return _run(path, folder, clock)
    except MemoryError as error:
        return judge.found("exception", where(path), f"traceback: MemoryError: {error}")
    except KeyboardInterrupt:
        if not clock.over:
            raise
        return judge.Outcome("slow", "the run that is compared with")
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return judge.of_exception(error, f"{where(path)}, {Path(last.filename).name}:{last.name}", ())
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _run(path: Path, folder: Path, clock) -> judge.Outcome:
    for imported in EXAMPLES.glob("*.urdf"):
        shutil.copy(imported, path.parent)
    code, said = command(path, ["check", str(path)])
    if clock.over:
        return judge.found("hang", "check", "takes too long, but hears Ctrl-C")
    bad = _ended(code, said, "check", (0, 2))
    if bad:
        return bad
    if code == 2:
        return judge.Outcome("refused", said[:1000])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)
        warnings.simplefilter("ignore", UrdfWarning)
        scene = lissom.Scene.load(path)
    if not small(scene):
        return judge.Outcome("done", "too large to run")
    chance = zlib.crc32(path.read_bytes())
    finished = False
    for name in ("run", ("statics", "modes", "explain", "statics")[chance % 4]):
        target = folder / name
        words = [name, str(path)]
        if name != "explain":
            words += ["-o", str(target)]
            words += ["--no-report"] if (chance >> 3) % REPORTS else []
        code, said = command(path, words)
        bad = _ended(code, said, name, (0, 1, 130))
        if bad is None and name == "run":
            finished = code == 0
            bad = finite(target) if finished else None
        if bad:
            return bad
        if clock.over:
            return judge.Outcome("slow", f"{name}: exit code {code}: {said[:300]}")
    return tighter(scene) if finished else judge.Outcome("failed", said[:300])


def _ended(code: int, said: str, name: str, codes: tuple[int, ...]) -> judge.Outcome | None:
    """Problems in the end of any command."""
    if "Traceback (most recent" in said or "panicked at" in said:
        return judge.found("exception", name, f"traceback: {said[-500:]}")
    if len(said) > judge.LONGEST_MESSAGE:
        return judge.found("message", name, f"{len(said)} characters: {said[:300]}", "too long")
    if code not in codes:
        after = ", though check calls it good" if name != "check" else ""
        return judge.found("exception", name, f"exit code {code}{after}: {said[-500:].partition(': ')[2]}")
    if code and not said.strip():
        return judge.found("message", name, f"exit code {code} without a word")
    return None


def small(scene) -> bool:
    """Whether a run takes at most seconds."""
    settings = scene.simulation
    steps = (settings.t_end - settings.t0) / settings.dt
    kept = (settings.t_end - settings.t0) / (settings.output_dt or settings.dt)
    if not (steps <= STEPS and kept <= KEPT):
        return False
    model = scene.model
    if isinstance(model, lissom.Robot):
        segments = sum(len(link.rod or ()) for link in model.links)
    elif isinstance(model, lissom.Rod):
        segments = len(model.segments)
    else:
        return True
    return model.n <= COORDINATES and segments <= SEGMENTS and sum(model.nodes) <= NODES


def finite(folder: Path) -> judge.Outcome | None:
    """Whether the files of a successful run are finite and complete."""
    json.loads((folder / "summary.json").read_text())
    with h5py.File(folder / "trajectory.nc") as file:
        for name, variable in file.items():
            values = np.asarray(variable)
            if values.dtype.kind == "f" and not np.isfinite(values).all():
                return judge.found("nan", "run", f"{name} is not finite in a run that finished")
    return None


def tip(scene, q) -> np.ndarray:
    """Position of the tip, for robots of the last link's, relative to the total unstretched length."""
    model = scene.model
    if isinstance(model, lissom.Robot):
        # Total length of all links.
        lengths = [segment.length for link in model.links for segment in link.rod or ()]
        places = [float(np.linalg.norm(link.position)) for link in model.links]
        return np.asarray(model.pose(q, link=model.links[-1].name, t=scene.simulation.t_end))[..., :3, 3] / (
            sum(lengths) + sum(places) or 1.0
        )
    if isinstance(model, lissom.Rod):
        return np.asarray(model.pose(q, model.length))[..., :3, 3] / model.length
    angle, elongation = q
    return (1 + elongation / model.length) * np.array([math.cos(angle), math.sin(angle)])


def tighter(scene) -> judge.Outcome:
    """Compare a success with error control with runs of two other methods with far tighter tolerances."""
    settings = scene.simulation
    moves = getattr(scene.model, "base_motion", None) is not None
    is_long = settings.t_end - settings.t0 > COMPARED
    if is_long or moves or settings.method in ("newmark", "hht", "generalised_alpha"):
        return judge.Outcome("done")
    end = settings.t_end
    ends = [end]
    result = scene.run(t_eval=ends, max_steps=20_000)
    if not result.success:
        return judge.Outcome("failed", result.message)
    references = [
        lissom.simulate(
            scene.model,
            end,
            t0=settings.t0,
            q0=scene.q0,
            v0=scene.v0,
            method=method,
            rtol=1e-10,
            atol=1e-12,
            t_eval=ends,
            max_steps=20_000,
        )
        for method in ("radau", "dop853")
    ]
    if not all(reference.success for reference in references):
        return judge.Outcome("done", "no reference")
    tips = [tip(scene, found.q[-1]) for found in (result, *references)]
    unsure = float(np.linalg.norm(tips[1] - tips[2]))
    error = float(np.linalg.norm(tips[0] - tips[1]))
    if settings.method != "auto":  # relative to what moves
        error /= max(1.0, float(np.linalg.norm(tips[1])))
    if settings.method == "auto":
        limit = FACTOR * settings.rtol
    else:
        limit = LOCAL_FACTOR * (settings.rtol + settings.atol)
    if 10 * unsure > limit:
        return judge.Outcome("done", "no reference")
    if not error <= limit:
        return judge.found(
            "wrong", settings.method, f"the tip is off by {error:.2g} of the length, allowed {limit:.2g}"
        )
    return judge.Outcome("done", f"error {error:.1e}")
