"""``lissom doctor``: versions, missing extras, and a test simulation."""

from __future__ import annotations

import math
import platform
import re
from collections.abc import Iterator
from pathlib import Path

import click

from .exits import FAILED

#: A requirement of an extra: a name at the beginning, the extra in a marker.
REQUIREMENT = re.compile(r"""(?P<name>[\w.-]+).*;.*extra\s*==\s*["'](?P<extra>[\w.-]+)["']""")

#: A steel wire, and a force (N) that bends it by a thousandth of its length, where linear theory is accurate
#: to 1e-6.
LENGTH, RADIUS, YOUNG_MODULUS = 1.0, 1e-3, 210e9
FORCE = 5e-4

#: Relative error of the deflection above which the test fails.
WRONG = 1e-4


@click.command("doctor")
def command() -> int:
    """Show versions, extras and processor, and test a simulation.

    Include this output when you report a problem.

    Exit code: 0 all is well, 1 the simulation is wrong.
    """
    from .._lissom import __version__

    rows = [
        ("lissom", f"{__version__} in {Path(__file__).parents[1]}"),
        ("Python", f"{platform.python_version()} ({platform.python_implementation()})"),
        ("NumPy", _version("numpy") or "missing"),
        ("system", f"{platform.system()} {platform.release()}, {platform.machine()}"),
        ("processor", processor()),
        *extras(),
    ]
    well, found = trial()
    rows.append(("simulation", found))
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        click.echo(f"{name:<{width}}  {value}")
    return 0 if well else FAILED


def processor() -> str:
    """The number of processors (threads used by default) and the instruction set that lissom uses."""
    from .._lissom import machine

    instructions, processors = machine()
    return f"{platform.machine()} with {instructions}, {processors} threads"


def extras() -> Iterator[tuple[str, str]]:
    """The installed packages of each extra, and how to install missing ones."""
    from importlib import metadata

    try:
        names = metadata.metadata("lissom").get_all("Provides-Extra") or []
        needs = metadata.requires("lissom") or []
    except metadata.PackageNotFoundError:
        yield "extras", "unknown: the package is not installed"
        return
    found = [match for match in map(REQUIREMENT.match, needs) if match]
    for extra in names:
        packages = [match["name"] for match in found if match["extra"] == extra and match["name"] != "lissom"]
        if not packages:
            continue
        versions = {package: _version(package) for package in packages}
        said = ", ".join(f"{package} {version or 'missing'}" for package, version in versions.items())
        if None in versions.values():
            said += f"; to install: pip install 'lissom[{extra}]'"
        yield f"[{extra}]", said


def trial() -> tuple[bool, str]:
    """Whether the deflection of a wire is correct, and how long one second of its motion takes."""
    from .._lissom import Rod, Segment, simulate, statics

    wire = Segment(
        length=LENGTH,
        radius=RADIUS,
        young_modulus=YOUNG_MODULUS,
        shear_modulus=80e9,
        density=7800.0,
        modes={"bend_y": 3},
    )
    pushed = Rod([wire], gravity=(0.0, 0.0, 0.0), tip_force=(0.0, 0.0, -FORCE))
    exact = -FORCE * LENGTH**3 / (3.0 * YOUNG_MODULUS * math.pi * RADIUS**4 / 4.0)
    error = abs(float(pushed.pose(statics(pushed).q)[2, 3]) / exact - 1.0)
    motion = simulate(Rod([wire]), t_end=1.0, dt=1e-2)
    well = error < WRONG and motion.success
    verdict = "correct" if well else "WRONG"
    time = 1e3 * motion.stats.wall_time
    return well, f"{verdict}: deflection with an error of {error:.0e}; 1 s of motion takes {time:.2g} ms"


def _version(package: str) -> str | None:
    """The installed version of a package; None where it is missing."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
