"""What lissom computes, frozen, to compare before and after code is moved.

    python tests/python/freeze.py record results/freeze     # before
    python tests/python/freeze.py compare results/freeze    # after

Frozen are runs, equilibria, verdicts and modes of all scenes, which are those of the gallery, and
of random robots with every effect; forces, tangents, energies and poses in random states;
messages about broken scenes, word by word; and the signatures of all public names. Code that was
only moved leaves every bit (`--rtol 0`); by default arrays may change by 1e-12 of their largest
number. `compare` lists what differs and the largest change of each kind of quantity, and ends
with 1 if there is any. The numbers are those of one machine: compare on the same one.
"""

import argparse
import inspect
import json
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import lissom
from fuzz import families, rendered
from fuzz import scenes as broken_scenes

ROOT = Path(__file__).parents[2]
#: Random robots, and broken scenes.
ROBOTS, BROKEN = 200, 300
#: Iterations and steps of random robots: those that end nowhere are not waited for.
MOST_ITERATIONS, DURATION, STEPS = 60, 0.02, 20
#: Methods of runs, with their options.
METHODS = {
    "newmark": {"dt": DURATION / STEPS},
    "radau": {"rtol": 1e-5, "max_steps": 500},
    "dop853": {"rtol": 1e-5, "max_steps": 500},
}

Frozen = Iterator[tuple[str, object]]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("do", choices=["record", "compare"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rtol", type=float, default=1e-12)
    parser.add_argument("--robots", type=int, default=ROBOTS)
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    numbers, words = frozen(args.robots)
    if args.do == "record":
        args.folder.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(args.folder / "numbers.npz", **numbers)
        (args.folder / "words.json").write_text(json.dumps(words, indent=0), encoding="utf-8")
        print(f"{len(numbers)} arrays and {len(words)} texts in {args.folder}")
        return 0
    with np.load(args.folder / "numbers.npz") as old:
        before = {name: old[name] for name in old.files}
    said = json.loads((args.folder / "words.json").read_text(encoding="utf-8"))
    return report(differences(before, numbers, said, words, args.rtol), len(numbers) + len(words))


def frozen(robots: int) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """All numbers and all texts by their names."""
    numbers, words = {}, {}
    for name, value in (*of_scenes(), *of_robots(robots), *of_messages(), *of_signatures()):
        if isinstance(value, str):
            words[name] = value
        else:
            numbers[name] = np.asarray(value, float)
    return numbers, words


def differences(before, after, said, says, rtol) -> dict[str, float | str]:
    """What differs, with the size of the change."""
    found: dict[str, float | str] = {}
    for name in sorted(before.keys() | after.keys()):
        if name not in before or name not in after:
            found[name] = "only " + ("after" if name in after else "before")
            continue
        old, new = before[name], after[name]
        if old.shape != new.shape or not np.array_equal(np.isfinite(old), np.isfinite(new)):
            found[name] = f"{old.shape} before, {new.shape} after"
            continue
        change = np.abs(new - old)[np.isfinite(old)].max(initial=0.0)
        size = np.abs(old)[np.isfinite(old)].max(initial=0.0)
        if change > rtol * size:
            found[name] = float(change / size) if size > 0.0 else float("inf")
    for name in sorted(said.keys() | says.keys()):
        if said.get(name) != says.get(name):
            found[name] = f"{said.get(name)!r} before, {says.get(name)!r} after"
    return found


def report(found: dict[str, float | str], number: int) -> int:
    largest: dict[str, float] = {}
    for name, change in found.items():
        print(f"{name}: {change if isinstance(change, str) else f'{change:.1e}'}")
        if isinstance(change, float):
            kind = name.rsplit("/", 1)[1]
            largest[kind] = max(largest.get(kind, 0.0), change)
    for kind, change in sorted(largest.items(), key=lambda item: -item[1]):
        print(f"largest change of {kind}: {change:.1e}")
    print(f"{len(found)} of {number} differ")
    return int(bool(found))


def of_run(name: str, run) -> Frozen:
    """Times, states and energies of a run, and how it ended; a refusal is its message."""
    try:
        done = run()
    except (ValueError, TypeError) as error:
        yield f"{name}/refused", str(error)
        return
    yield f"{name}/status", str(done.status)
    yield f"{name}/t", done.t
    for each in ("q", "v", "theta", "omega"):
        if hasattr(done, each):
            yield f"{name}/{each}", np.asarray(getattr(done, each))[-1]
    balance = getattr(done, "balance", None)
    if balance is not None:
        for each in ("kinetic", "elastic", "gravitational", "work"):
            yield f"{name}/{each}", getattr(balance, each)[-1]


def at_rest(name: str, model, q0, **options) -> Frozen:
    """An equilibrium, its path and verdict, and the modes there."""
    try:
        found = lissom.statics(model, q0, **options)
    except ValueError as error:
        yield f"{name}/refused", str(error)
        return
    yield f"{name}/status", f"{found.status}, {found.stability}"
    yield f"{name}/message", found.message
    if not found.success:
        return
    yield f"{name}/equilibrium", found.q
    yield f"{name}/iterations", found.nit
    try:
        modes = lissom.modes(model, found.q)
    except (ValueError, lissom.LissomError) as error:
        yield f"{name}/no modes", str(error)
        return
    yield f"{name}/frequency", modes.frequency


def of_scenes() -> Frozen:
    for path in sorted((ROOT / "scenes").glob("*.toml")):
        scene = lissom.Scene.load(path)
        yield from of_run(f"{path.stem}/run", scene.run)
        if isinstance(scene.model, lissom.Robot):
            yield f"{path.stem}/explain", scene.model.explain()
            yield from at_rest(f"{path.stem}/statics", scene.model, scene.q0)


def of_robots(number: int) -> Frozen:
    for seed in range(number):
        rng = np.random.default_rng(seed)
        family = families.FAMILIES[seed % len(families.FAMILIES)]
        size = families.STATES.get(family.__name__, 1.0)
        recipe = families.with_state(family(rng), rng, size)
        name = f"{family.__name__} {seed}"
        try:
            model = rendered.by_api(recipe)
        except ValueError as error:
            yield f"{name}/refused", str(error)
            continue
        q, v = rendered.state(recipe, model)
        a = rng.normal(size=model.n)
        yield f"{name}/inverse_dynamics", model.inverse_dynamics(q, v, a)
        yield f"{name}/tangent", model.tangent(q, v, a)
        yield f"{name}/mass_matrix", model.mass_matrix(q)
        energy = model.energy(q, v)
        yield f"{name}/energy", [energy.kinetic, energy.elastic, energy.gravitational, energy.loads]
        yield f"{name}/pose", [model.pose(q, link=link.name) for link in model.links]
        yield f"{name}/explain", model.explain()
        yield from at_rest(f"{name}/statics", model, None, max_iter=MOST_ITERATIONS)
        for method, options in METHODS.items():

            def run(model=model, q=q, v=v, method=method, options=options):
                return lissom.simulate(model, DURATION, q0=q, v0=v, method=method, **options)

            yield from of_run(f"{name}/{method}", run)


def of_messages() -> Frozen:
    """What is said about broken scenes, with their places."""
    for seed in range(BROKEN):
        text = broken_scenes.make(np.random.default_rng(seed)).decode("utf-8", "replace")
        try:
            lissom.Scene.loads(text)
            said = "read"
        except (ValueError, TypeError) as error:
            said = str(error)
        except OSError as error:
            said = type(error).__name__
        yield f"broken scene {seed}/message", said


def of_signatures() -> Frozen:
    for name in sorted(lissom.__all__):
        thing = getattr(lissom, name)
        if not callable(thing):
            continue
        try:
            yield f"{name}/signature", str(inspect.signature(thing))
        except (ValueError, TypeError):
            yield f"{name}/signature", "?"


if __name__ == "__main__":
    sys.exit(main())
