"""A virtual environment for every code that lissom is compared with, made from its public package."""

import json
import os
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

SCRIPTS = Path(__file__).parent
# Name, script, requirement: a package, or a file of packages with hashes.
RODS = {
    "pyelastica": ("pyelastica.py", "pyelastica==1.0.0"),
    # The last version with the cable plugin.
    "mujoco-cable": ("mujoco_cable.py", "mujoco==3.17.0"),
    "mujoco-flex": ("mujoco_flex.py", "mujoco==4.0.0"),
    "soromox": ("soromox_gvs.py", "soromox==0.5.0"),
}
PILES = {
    "pile-mujoco": ("pile_mujoco_runs.py", "mujoco==4.0.0"),
    "pile-pyelastica": ("pile_elastica_runs.py", "pyelastica==1.0.0"),
}
PEERS = (
    RODS
    | PILES
    | {
        "robots": ("robot_peers_measured.py", SCRIPTS.parents[2] / "requirements" / "peers.txt"),
    }
)
# Written last, so that an environment without it is known to be unfinished.
STAMP = "requirement.txt"


class Unavailable(Exception):
    """A peer that cannot be installed or measured here; says why."""


@dataclass(frozen=True)
class Measured:
    """Versions of a peer's packages and its runs; `failure` says why there are not more."""

    versions: dict[str, str]
    runs: list[dict]
    failure: str | None


def interpreter(name: str, folder: Path) -> Path:
    """The Python of a peer's environment, which is made if it is not there."""
    _, requirement = PEERS[name]
    if isinstance(requirement, Path):
        content, wanted = requirement.read_text(), ["--require-hashes", "--requirement", requirement]
    else:
        content, wanted = requirement, [requirement]
    environment = folder / name
    python, stamp = environment / "bin" / "python", environment / STAMP
    if stamp.is_file() and stamp.read_text() == content:
        return python
    print(f"installing {requirement} in {environment}", file=sys.stderr)
    venv.create(environment, with_pip=True, clear=True)
    command = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *wanted]
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        lines = result.stderr.strip().splitlines()
        raise Unavailable(f"cannot be installed: {lines[-1] if lines else 'pip does not say why'}")
    stamp.write_text(content)
    return python


def measure(name: str, folder: Path, quick: bool, *options: str) -> Measured:
    """Measure a peer by its own interpreter; `options` are those of its script."""
    script, _ = PEERS[name]
    command = [interpreter(name, folder), SCRIPTS / script, *(["--quick"] if quick else []), *options]
    # What this interpreter finds on PYTHONPATH is not the peer's.
    surroundings = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    # There, because MuJoCo writes its log where it runs.
    result = subprocess.run(command, stdout=subprocess.PIPE, text=True, env=surroundings, cwd=folder)
    lines = [json.loads(line) for line in result.stdout.splitlines() if line.startswith("{")]
    if not lines:
        raise Unavailable(f"its script ended with {result.returncode} before the first run")
    failure = (
        None if result.returncode == 0 else f"ended with {result.returncode} after {len(lines) - 1} runs"
    )
    return Measured(lines[0]["versions"], lines[1:], failure)
