"""Ends at random times: signals while something is computed, SIGKILL and full disks while it is saved.

A case is a line of JSON; processes of their own are ended.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import lissom
from fuzz import judge

NAME = "endings"
SUFFIX = ".case"

HEAD = """
import sys, time
import numpy as np
import lissom
from fuzz import values as v
model = v.planar()
long = v.rod(fluid=lissom.Fluid(1000.0))
print("ready", flush=True)
"""
#: Computations that take seconds, by name.
LONG = {
    "simulate": "found = lissom.simulate(long, 1e4, dt=1e-3)",
    "simulate_many": "found = lissom.simulate_many(long, 1e4, dt=1e-3, q0=np.zeros((4, 2)), keep='final')",
    "radau": "[lissom.simulate(long, 1e4, method='radau', rtol=1e-9) for _ in range(10**4)]",
    "statics": "[lissom.statics(model, load_steps=1000) for _ in range(10**4)]",
    "continuation": "[lissom.continuation(model) for _ in range(10**4)]",
    "reach": "[model.reach('rod', model.pose([0.1, 0.2]), restarts=50) for _ in range(10**4)]",
    "sensitivity": "found = lissom.sensitivity(long, 1e3, ['q0'], dt=1e-3)",
    "solve_ivp": "found = lissom.solve_ivp(lambda t, y: -y, (0.0, 1e6), [1.0], max_step=1e-3)",
    "root": "[lissom.root(lambda x: x * x - 2.0, [1.0]) for _ in range(10**7)]",
}
#: Saves a result, whose size is some MB, again and again.
SAVE = """
found = lissom.simulate(v.planar(), 4.0, dt=1e-4)
found.save(sys.argv[1])
print("saved", flush=True)
while True:
    found.save(sys.argv[1])
"""
#: Sizes at which the disk is full, bytes.
FULL = (0, 1, 100, 10_000, 300_000)
#: Seconds after which a process that was asked to end is a hang, on a busy machine.
PATIENCE = 60.0


def prepare() -> None:
    pass


def make(rng: np.random.Generator) -> bytes:
    kind = str(rng.choice(["computing", "saving", "full"], p=[0.6, 0.25, 0.15]))
    case = {
        "kind": kind,
        "what": str(rng.choice(list(LONG))),
        "signal": str(rng.choice(["SIGINT", "SIGINT", "SIGTERM"])),
        "after": float(rng.exponential(0.3)),
        "suffix": str(rng.choice([".lissom", ".npz", ".nc"])),
        "full": int(rng.choice(FULL)),
    }
    return json.dumps(case).encode()


def where(path: Path) -> str:
    case = json.loads(path.read_text(encoding="utf-8"))
    return f"{case['kind']} {case['what'] if case['kind'] == 'computing' else case['suffix']}"


def run(path: Path, clock) -> judge.Outcome:
    case = json.loads(path.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder:
        return {"computing": _computing, "saving": _saving, "full": _full}[case["kind"]](
            where(path), case, Path(folder)
        )


def _started(script: str, *arguments: str, word: str = "ready", **options) -> subprocess.Popen:
    process = subprocess.Popen(
        [sys.executable, "-c", HEAD + script, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )
    while word not in (line := process.stdout.readline()):
        if not line:
            break
    return process


def _ended(process: subprocess.Popen) -> tuple[int | None, str]:
    """Exit code, None if there is none in time, and what it said."""
    try:
        _, said = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return None, ""
    return process.returncode, said


def _computing(place, case, folder) -> judge.Outcome:
    process = _started(LONG[case["what"]])
    time.sleep(min(case["after"], 3.0))
    number = signal.Signals[case["signal"]]
    process.send_signal(number)
    code, said = _ended(process)
    if code is None:
        return judge.found("hang", place, f"{number.name} is not heard")
    # SIGTERM ends the process at once; Ctrl-C is a KeyboardInterrupt, after which Python ends by the signal.
    expected = (-number, 130) if number == signal.SIGINT else (-number,)
    last = (said.strip().splitlines() or [""])[-1]
    if code not in expected:
        return judge.found("crash", place, f"{number.name}: exit code {code}, {last}")
    if number == signal.SIGINT and not last.startswith("KeyboardInterrupt"):
        return judge.found("exception", place, f"{number.name}: {last}")
    return judge.Outcome("done", f"{number.name}: {last}")


def _saving(place, case, folder) -> judge.Outcome:
    """Killed while it replaces a file: the file is the old one or the new one, and loads."""
    path = folder / f"x{case['suffix']}"
    process = _started(SAVE, str(path), word="saved")
    time.sleep(min(case["after"], 1.0))
    process.kill()
    process.communicate()
    try:
        lissom.load(path)
    except Exception as error:
        return judge.found("wrong", place, f"after SIGKILL: {type(error).__name__}: {error}")
    left = [name.name for name in folder.iterdir() if name != path]
    if any(not name.startswith(".lissom-") for name in left) or len(left) > 1:
        return judge.found("wrong", place, f"after SIGKILL: {left}")
    return judge.Outcome("done", "the file is complete")


def _full(place, case, folder) -> judge.Outcome:
    """On a full disk the exception says so, the old file stays, and nothing is left."""
    path = folder / f"x{case['suffix']}"
    lissom.statics(_model()).save(path)
    before = path.read_bytes()
    script = "lissom.simulate(v.planar(), 1.0, dt=1e-4).save(sys.argv[1])"

    def limit():
        import resource

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (case["full"], case["full"]))

    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    process = _started(script, str(path), preexec_fn=limit, env=environment)
    code, said = _ended(process)
    last = (said.strip().splitlines() or [""])[-1]
    if code != 1 or not last.startswith("OSError"):
        return judge.found("exception", place, f"full after {case['full']} bytes: exit code {code}, {last}")
    if path.read_bytes() != before or [name for name in folder.iterdir() if name != path]:
        return judge.found(
            "wrong", place, f"full after {case['full']} bytes: the old file is damaged, or another is left"
        )
    return judge.Outcome("done", last)


def _model():
    from fuzz import values

    return values.planar()
