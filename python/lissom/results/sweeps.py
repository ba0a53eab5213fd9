"""The result of a sweep of a scene, and its folder on disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._lissom import Scene, __version__
from ..common.extras import missing
from .files import NETCDF, in_words, write_report, write_summary
from .folders import MARK

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class SweepStudy:
    """A scene that was simulated for values of some of its keys."""

    scene: Scene
    found: xarray.Dataset
    #: The varied keys.
    parameters: tuple[str, ...]
    wall_time: float

    @cached_property
    def points(self) -> int:
        """Number of points."""
        return int(self.found.is_done.size)

    @cached_property
    def counts(self) -> dict[str, int]:
        """Number of points by status."""
        done = self.found.is_done.values
        names, counts = np.unique(self.found.status.values[done], return_counts=True)
        found = {str(name): int(count) for name, count in zip(names, counts, strict=True)}
        missing = int((~done).sum())
        return found | ({"not made": missing} if missing else {})

    @property
    def is_good(self) -> bool:
        """Whether all runs were completed."""
        return bool(self.found.success.all())

    @property
    def outcome(self) -> str:
        """The outcome in a few words."""
        return f"{int(self.found.success.sum())} of {self.points} runs succeeded"

    @property
    def summary(self) -> list[tuple[str, str]]:
        """Summary of the sweep."""
        rows = [
            (name, f"{len(values)} values, {values[0]:.6g} to {values[-1]:.6g}")
            if values.dtype.kind in "if"
            else (name, f"{len(values)} values")
            for name in self.parameters
            for values in [self.found[name].values]
        ]
        rows += [(status, f"{count:,} runs") for status, count in self.counts.items()]
        if self.found.is_doubtful.any():
            rows.append(("doubtful", f"{int(self.found.is_doubtful.sum())} runs do not resolve their motion"))
        rows.append(("time", f"{self.wall_time:.3g} s"))
        return rows

    @property
    def numbers(self) -> dict[str, Any]:
        """Results as plain JSON."""
        return {
            "scene": self.scene.name,
            MARK: __version__,
            "study": "sweep",
            "outcome": "finished" if self.is_good else "failed",
            "parameters": {name: self.found[name].values.tolist() for name in self.parameters},
            "points": self.points,
            "runs": self.counts,
            "wall_seconds": self.wall_time,
        }


def write(study: SweepStudy, folder: Path, report: Callable[[Any, Path], None] | None) -> list[str]:
    """Write the files of a sweep into an empty folder; what could not be written, like ``files.write``."""
    found = study.found.assign_attrs(scene=study.scene.text, title=study.scene.name.replace("\0", " "))
    failures = []
    content = None
    if not missing(*NETCDF):
        try:
            content = found.to_netcdf(engine="h5netcdf")
        except Exception as error:
            failures.append(f"sweep.nc could not be written, sweep.npz was: {in_words(error)}")
    if content is not None:
        (folder / "sweep.nc").write_bytes(content)
    else:
        names: Any = [*found.data_vars, *found.coords]
        np.savez_compressed(folder / "sweep.npz", **{str(name): found[name].values for name in names})
    write_summary(study.numbers, folder)
    return failures + write_report(report, study, folder / "report.html")
