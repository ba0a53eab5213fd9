"""States of a robot for instruments: many states as rows of arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._lissom import finite_array

Array = NDArray[np.float64]

#: Descriptions of the optional parts of a state.
PARTS = {"v": "velocities", "a": "accelerations"}


@dataclass(frozen=True)
class States:
    """k states: times (k,), coordinates (k, n), and velocities, accelerations and inputs as far as known."""

    t: Array
    q: Array
    v: Array | None = None
    a: Array | None = None
    u: Array | None = None

    def __getitem__(self, which: NDArray[Any]) -> States:
        """A subset of the states."""
        v, a, u = (None if part is None else part[which] for part in (self.v, self.a, self.u))
        return States(self.t[which], self.q[which], v, a, u)

    @property
    def inputs(self) -> dict[str, Any]:
        """The keyword argument for the inputs of a robot's methods; empty for default inputs."""
        return {} if self.u is None or self.u.size == 0 else {"u": self.u}


def of(n: int, needed: str, who: str, **given: ArrayLike | None) -> tuple[States, bool]:
    """Checked states including the needed parts of ``v`` and ``a``, and whether it is a single state."""
    q = finite_array(given["q"], "q")
    if q.shape[-1:] != (n,) or q.ndim > 2:
        raise ValueError(f"q: expected shape ({n},) or (k, {n}), got {q.shape}")
    is_one = q.ndim == 1
    rows = {"q": q[None] if is_one else q}
    for name, what in PARTS.items():
        value = given.get(name)
        if value is not None:
            rows[name] = _like(finite_array(value, name), name, q.shape).reshape(rows["q"].shape)
        elif name in needed:
            raise TypeError(f"{name}: got none, expected the {what}: {who} needs them")
    t = _like(finite_array(given["t"], "t"), "t", q.shape[:-1])
    if given.get("u") is not None:
        u = finite_array(given["u"], "u")
        if u.ndim not in (1, q.ndim) or u.shape[: u.ndim - 1] != q.shape[: u.ndim - 1]:
            expected = "(m,)" if is_one else f"(m,) or ({len(q)}, m)"
            raise ValueError(f"u: expected shape {expected}, got {u.shape}")
        rows["u"] = np.broadcast_to(u, (len(rows["q"]), u.shape[-1]))
    return States(t.reshape(len(rows["q"])), **rows), is_one


def _like(value: Array, name: str, shape: tuple[int, ...]) -> Array:
    if value.shape != shape:
        expected = f"shape {shape}, as the coordinates ask for" if shape else "a number"
        raise ValueError(f"{name}: expected {expected}, got shape {value.shape}")
    return value
