"""Simulations as differentiable PyTorch functions: ``import lissom.torch``.

Needs the extra `torch`: ``pip install 'lissom[torch]'``. ``docs/sensitivities.md`` has examples and costs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

try:
    import torch
except ModuleNotFoundError as error:
    raise ImportError("lissom.torch takes PyTorch: pip install 'lissom[torch]'") from error

from ._lissom import Model
from .analysis.pullbacks import Pullback, pullback
from .methods import Newmark

__all__ = ["simulation"]

Run = Callable[..., tuple[Any, Any, Any]]


class _States(torch.autograd.Function):
    """Coordinates and velocities, computed on the CPU."""

    @staticmethod
    def forward(ctx: Any, found: Pullback, values: Any, q0: Any, v0: Any, u: Any) -> tuple[Any, Any]:
        ctx.found = found
        ctx.save_for_backward(values, q0, v0, u)
        q, v = found.run(*(given.numpy(force=True) for given in (values, q0, v0, u)))
        return torch.tensor(q, device=q0.device), torch.tensor(v, device=q0.device)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, on_q: Any, on_v: Any) -> tuple[Any, ...]:
        given = (*ctx.saved_tensors, on_q, on_v)
        found = ctx.found.pull(*(part.numpy(force=True) for part in given))
        return None, *(torch.tensor(np.ascontiguousarray(part), device=on_q.device) for part in found)


def simulation(
    model: Model,
    t_end: float,
    parameters: Sequence[str] = (),
    *,
    t: ArrayLike | None = None,
    t0: float = 0.0,
    dt: float = 1e-2,
    method: str | Newmark = "newmark",
    control_step: float | None = None,
    **options: Any,
) -> Run:
    """Return a PyTorch function that simulates a model and supports differentiation.

    Derivatives are those of `lissom.sensitivity` by the adjoint method: first order only. Tensors with
    leading axes represent many runs in one `simulate_many`; the adjoints are computed one by one. Runs are
    computed on the CPU.

    Parameters
    ----------
    model, t_end, parameters, t, t0, dt, method, control_step, **options
        As for `lissom.jax.simulation`.

    Returns
    -------
    callable
        ``run(values, q0, v0)`` with a dictionary of a tensor of shape (...) for each parameter and tensors of
        shape (..., n), which broadcast, returns `t` of shape (m,), `q` and `v` of shape (..., m, n); with a
        `control_step`, ``run(values, q0, v0, u)`` with inputs of shape (..., control steps, inputs). Tensors
        are 64-bit. If a run fails, `q` and `v` are NaN from then on, and so are its derivatives.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid, a name is unknown, nothing depends on a parameter; when called, if names or
        shapes do not match, or a tensor is not 64-bit.
    """
    found = pullback(
        model, t_end, parameters, t=t, t0=t0, dt=dt, method=method, control_step=control_step, **options
    )
    n = model.n

    def run(values: Mapping[str, Any], q0: Any, v0: Any, u: Any = None) -> tuple[Any, Any, Any]:
        if set(values) != set(found.names):
            raise ValueError(f"values: got {sorted(values)}, expected {sorted(found.names)}")
        row = [_doubles(f"values[{name!r}]", values[name]) for name in found.names]
        if (u is None) != (control_step is None):
            raise ValueError(
                f"u: got {type(u).__name__}: inputs and a control_step need each other, give both or none"
            )
        u = torch.zeros(found.held, dtype=torch.float64) if u is None else u
        start = {
            "q0": (_doubles("q0", q0), (n,)),
            "v0": (_doubles("v0", v0), (n,)),
            "u": (_doubles("u", u), found.held),
        }
        for name, (given, shape) in start.items():
            if given.shape[-len(shape) :] != shape:
                expected = ", ".join(map(str, ("...", *shape)))
                raise ValueError(f"{name}: got shape {tuple(given.shape)}, expected ({expected})")
        shapes = [
            *(value.shape for value in row),
            *(given.shape[: -len(shape)] for given, shape in start.values()),
        ]
        try:
            batch = torch.broadcast_shapes(*shapes)
        except RuntimeError:
            raise ValueError(
                f"values, q0, v0, u: got leading axes {[tuple(shape) for shape in shapes]}, expected some "
                "that broadcast"
            ) from None
        device = start["q0"][0].device
        stacked = (
            torch.stack([value.expand(batch) for value in row], -1)
            if row
            else torch.zeros((*batch, 0), dtype=torch.float64, device=device)
        )
        expanded = (given.expand(*batch, *shape) for given, shape in start.values())
        q, v = _States.apply(found, stacked, *expanded)
        return torch.tensor(found.t, device=device), q, v

    return run


def _doubles(name: str, given: Any) -> Any:
    """Convert numbers, sequences and tensors to a tensor of doubles."""
    if not isinstance(given, torch.Tensor):
        return torch.as_tensor(given, dtype=torch.float64)
    if given.dtype != torch.float64:
        raise ValueError(f"{name}: got {given.dtype}, expected torch.float64: runs are computed in 64 bits")
    return given
