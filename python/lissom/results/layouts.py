"""Layouts of results: kinds and shapes of their arrays, and numbers of their names.

`records` compares what it reads with them. Sizes are letters that mean the same in a whole result, such as m
times, n coordinates and p parameters, or numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

#: Attributes of each class: kinds of the elements, and sizes. ``text`` are words, ``word`` words or None,
#: ``list`` other entries, ``t`` times that do not decrease; ``?`` allows None.
LAYOUTS: Mapping[str, Mapping[str, str]] = {
    "EquilibriumPath": {
        "load_factor": "f m",
        "u": "f? m k",
        "q": "f m n",
        "lowest_eigenvalue": "f m",
        "stability": "word m",
    },
    "CriticalPoint": {"u": "f? k", "q": "f n", "directions": "f d n"},
    "ContinuationResult": {"u": "f? k", "t": "f?"},
    "ModesResult": {
        "frequency": "f m",
        "angular_frequency": "f m",
        "damping_ratio": "f m",
        "eigenvalues": "c m",
        "shapes": "fc n m",
        "u": "f? k",
        "t": "f?",
        "refined_frequency": "f? m",
    },
    "EnsembleResult": {
        "t": "t m",
        "lowest": "f? r n",
        "highest": "f? r n",
        "mean": "f? m k 3",
        "variance": "f? m k 3",
        "reached": "f r",
        "success": "b r",
        "status": "U r",
        "message": "text r",
        "doubt": "word r",
        "slack": "list r",
    },
    "FitResult": {
        "names": "text p",
        "values": "f p",
        "covariance": "f p p",
        "intervals": "f p 2",
        "data": "list k",
    },
    "FittedData": {"places": "text k"},
    "SensitivityResult": {
        "names": "text p",
        "t": "t m",
        "q": "f m n",
        "v": "f m n",
        "dq": "f? m n p",
        "dv": "f? m n p",
        "gradient": "f? p",
        "_parameters": "list p",
    },
    "EquilibriumSensitivityResult": {
        "names": "text p",
        "q": "f n",
        "dq": "f? n p",
        "gradient": "f? p",
        "frequencies": "f k",
        "dfrequencies": "f k p",
        "_parameters": "list p",
    },
}


def mismatch(name: str, thing: Any) -> str:
    """Which attribute of an object of this class has another layout; empty if none has."""
    model = getattr(thing, "_model", None)
    sizes = {} if model is None else {"n": model.n}
    layout = {**LAYOUTS.get(name, {}), **_OTHERS.get(name, lambda _: {})(thing)}
    return next(
        (attribute for attribute, wanted in layout.items() if not _fits(thing, attribute, wanted, sizes)), ""
    )


def _fits(thing: Any, attribute: str, wanted: str, sizes: dict[str, int]) -> bool:
    value = thing
    for part in attribute.split("."):
        value = getattr(value, part)
    kind, *shape = wanted.split()
    if value is None:
        return kind.endswith("?")
    kind = kind.removesuffix("?")
    if kind in ("text", "word", "list"):
        words = (str, type(None)) if kind == "word" else str if kind == "text" else object
        if not isinstance(value, list | tuple) or not all(isinstance(each, words) for each in value):
            return False
        found: tuple[int, ...] = (len(value),)
    elif not shape:
        return isinstance(value, float)
    else:
        if not isinstance(value, np.ndarray) or value.dtype.kind not in kind.replace("t", "f"):
            return False
        if kind == "t" and not (np.isfinite(value).all() and (np.diff(value) >= 0.0).all()):
            return False
        found = value.shape
    return len(found) == len(shape) and all(
        size == (int(letter) if letter.isdigit() else sizes.setdefault(letter, size))
        for letter, size in zip(shape, found, strict=True)
    )


def _of_ensemble(result: Any) -> dict[str, str]:
    times = "m " if result.keep == "states" else ""
    counted = isinstance(result.stats, dict) and all(
        isinstance(each, np.ndarray) and each.dtype.kind in "fiu" and each.shape == (len(result.message),)
        for each in result.stats.values()
    )
    wrong = {} if counted else {"stats": "f r"}
    return {"q": f"f r {times}n", "v": f"f r {times}n", "poses": f"f? r {times}k 4 4", **wrong}


def _of_path(path: Any) -> dict[str, str]:
    points = all(type(each).__name__ == "CriticalPoint" for each in path.critical_points)
    return {} if points else {"critical_points": "f k"}


def _of_equilibrium(result: Any) -> dict[str, str]:
    return {"q": "f n", "u": "f? k", "t": "f?"} | ({} if result.path is None else {"path.q": "f m n"})


def _of_recording(result: Any) -> dict[str, str]:
    # Positions of places at times or in equilibria, or frequencies.
    measured = "f i k 3" if result.places else "f i"
    return {"residuals": measured, "measured": measured, "t": "t? i"}


def _of_targets(result: Any) -> dict[str, str]:
    targets = "" if isinstance(result.position_error, float) else " k"
    return {"position_error": f"f{targets}", "orientation_error": f"f{targets}", "pose": f"f{targets} 4 4"}


_OTHERS: Mapping[str, Any] = {
    "EnsembleResult": _of_ensemble,
    "EquilibriumPath": _of_path,
    "StaticsResult": _of_equilibrium,
    "FittedData": _of_recording,
    "ReachResult": _of_targets,
    "ActuateResult": _of_targets,
}
