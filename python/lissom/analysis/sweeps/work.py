"""Execution of the runs of some points, in any process."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..._lissom import EnsembleResult, LissomError, Model, Robot, simulate, simulate_many
from .source import Case, Source

Array = np.ndarray[Any, np.dtype[Any]]
Record = dict[str, Array]

#: Status of points with an invalid combination of parameters.
REFUSED = "refused"

#: Maximum length of a stored message, bytes.
MESSAGE = 240

#: Maximum length of a stored status, bytes.
STATUS = 24


@dataclass(frozen=True)
class Wants:
    """Results to store for each run."""

    #: 'final' or 'states'.
    keep: str
    #: Recorded places of robots, as for `simulate_many`; None for the tip of the last link.
    places: Sequence[Any] | None = None
    #: Additional measurement of a result.
    measure: Callable[[Any], Any] | None = None
    #: Number of threads per task.
    workers: int | None = 1


def places_of(model: Model, wants: Wants) -> Sequence[Any] | None:
    """The places whose positions are stored; None for models without places."""
    if wants.places is not None:
        return wants.places
    return [model.links[-1].name] if isinstance(model, Robot) else None


def run_points(
    source: Source, points: Sequence[Mapping[str, Any]], wants: Wants
) -> tuple[list[Record], float]:
    """Results of the runs of these points, and the elapsed time in seconds."""
    start = time.perf_counter()
    records: list[Record] = [{} for _ in points]
    cases: dict[int, Case] = {}
    for i, point in enumerate(points):
        try:
            cases[i] = source.case(point)
        except (ValueError, TypeError, LissomError) as error:
            records[i] = refused(str(error))
    for group in _alike(cases).values():
        for i, record in zip(group, _run([cases[i] for i in group], wants), strict=True):
            records[i] = record
    return records, time.perf_counter() - start


def _alike(cases: Mapping[int, Case]) -> dict[Any, list[int]]:
    """Groups of cases that can run together."""
    groups: dict[Any, list[int]] = {}
    for i, case in cases.items():
        shared = {name: value for name, value in case.options.items() if name not in ("q0", "v0")}
        links = len(case.model.links) if isinstance(case.model, Robot) else 0
        key = (case.model.n, tuple(case.model.inputs), links, tuple(_key(v) for v in sorted(shared.items())))
        groups.setdefault(key, []).append(i)
    return groups


def _key(item: tuple[str, Any]) -> tuple[str, Any]:
    name, value = item
    return name, value.tobytes() if isinstance(value, np.ndarray) else repr(value)


def _run(cases: Sequence[Case], wants: Wants) -> list[Record]:
    options = dict(cases[0].options)
    for name in ("q0", "v0"):
        given = [case.options.get(name) for case in cases]
        options[name] = [
            np.zeros(case.model.n) if v is None else v for v, case in zip(given, cases, strict=True)
        ]
    places = places_of(cases[0].model, wants)
    try:
        with warnings.catch_warnings():
            # The result contains the doubt.
            warnings.simplefilter("ignore")
            result = simulate_many(
                [case.model for case in cases], workers=wants.workers, places=places, **options
            )
    except (ValueError, TypeError, LissomError) as error:
        if len(cases) == 1:
            return [refused(str(error))]
        return [record for case in cases for record in _run([case], wants)]
    return [_record(result, row, wants.keep) | _measure(case, wants) for row, case in enumerate(cases)]


def _record(result: EnsembleResult, row: int, keep: str) -> Record:
    known = int(np.searchsorted(result.t, result.reached[row], side="right")) if len(result.t) else 0
    last = max(known - 1, 0)
    q, v = result.q[row], result.v[row]
    record = {
        "success": np.array(result.success[row]),
        "status": np.array(str(result.status[row]).encode()[:STATUS], f"S{STATUS}"),
        "message": np.array(result.message[row].encode()[:MESSAGE], f"S{MESSAGE}"),
        "is_doubtful": np.array(result.doubt[row] is not None),
        "reached": np.array(result.reached[row]),
        "steps": np.array(result.stats["steps"][row]),
        "wall_time": np.array(result.stats["wall_time"][row]),
    }
    if known == 0:
        return record
    record |= {"lowest": q[:known].min(axis=0), "highest": q[:known].max(axis=0)}
    if keep == "final":
        record |= {"q": q[last], "v": v[last]}
    else:
        record |= {"q": q, "v": v}
    if result.poses is not None:
        positions = result.poses[row, :, :, :3, 3]
        record |= {
            "position": positions[last] if keep == "final" else positions,
            "position_lowest": positions[:known].min(axis=0),
            "position_highest": positions[:known].max(axis=0),
        }
    return record


def _measure(case: Case, wants: Wants) -> Record:
    if wants.measure is None:
        return {}
    found = wants.measure(simulate(case.model, **case.options))
    if not isinstance(found, Mapping):
        found = {"measured": found}
    return {str(name): np.asarray(value, dtype=np.float64) for name, value in found.items()}


def refused(message: str) -> Record:
    """The record of a point with an invalid combination of parameters."""
    return {
        "success": np.array(False),
        "status": np.array(REFUSED.encode(), f"S{STATUS}"),
        "message": np.array(message.encode()[:MESSAGE], f"S{MESSAGE}"),
        "is_doubtful": np.array(False),
        "reached": np.array(np.nan),
        "steps": np.array(0, dtype=np.int64),
        "wall_time": np.array(np.nan),
    }
