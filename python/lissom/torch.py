"""Runs as functions of PyTorch, with their derivatives: ``import lissom.torch``.

It takes the extra `torch`: ``pip install 'lissom[torch]'``. ``docs/sensitivities.md`` tells more.
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
from .pullbacks import Pullback, pullback

__all__ = ["simulation"]

Run = Callable[[Mapping[str, Any], Any, Any], tuple[Any, Any, Any]]


class _States(torch.autograd.Function):
    """Coordinates and velocities, by the host."""

    @staticmethod
    def forward(ctx: Any, found: Pullback, values: Any, q0: Any, v0: Any) -> tuple[Any, Any]:
        ctx.found = found
        ctx.save_for_backward(values, q0, v0)
        q, v = found.run(*(given.numpy(force=True) for given in (values, q0, v0)))
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
    method: str = "newmark",
    **options: Any,
) -> Run:
    """Make a function of PyTorch that runs a model, and whose results know their derivatives.

    Derivatives are those of `lissom.sensitivity`, by the adjoint, and of first order. Tensors with leading
    axes are many runs: one `simulate_many`; the adjoints follow one by one. Runs are made on the processor.

    Parameters
    ----------
    model, t_end, parameters, t, t0, dt, method, **options
        As for `lissom.jax.simulation`.

    Returns
    -------
    callable
        ``run(values, q0, v0)`` with a dictionary of a tensor of shape (...) for each parameter and tensors of
        shape (..., n), which broadcast, returns `t` of shape (m,), `q` and `v` of shape (..., m, n). Tensors
        are of 64 bits. Where a run fails, `q` and `v` are NaN from there on, and so are its derivatives.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid, a name is unknown, nothing depends on a parameter; when called, if names or
        shapes are others, or a tensor has not 64 bits.
    """
    found = pullback(model, t_end, parameters, t=t, t0=t0, dt=dt, method=method, **options)

    def run(values: Mapping[str, Any], q0: Any, v0: Any) -> tuple[Any, Any, Any]:
        if set(values) != set(found.names):
            raise ValueError(f"values: got {sorted(values)}, expected {sorted(found.names)}")
        row = [_doubles(f"values[{name!r}]", values[name]) for name in found.names]
        start = [_doubles("q0", q0), _doubles("v0", v0)]
        for name, given in zip(("q0", "v0"), start, strict=True):
            if given.shape[-1:] != (model.n,):
                raise ValueError(f"{name}: got shape {tuple(given.shape)}, expected (..., {model.n})")
        shapes = [*(value.shape for value in row), *(given.shape[:-1] for given in start)]
        try:
            batch = torch.broadcast_shapes(*shapes)
        except RuntimeError:
            raise ValueError(
                f"values, q0, v0: got leading axes {[tuple(shape) for shape in shapes]}, expected some that "
                "broadcast"
            ) from None
        device = start[0].device
        stacked = (
            torch.stack([value.expand(batch) for value in row], -1)
            if row
            else torch.zeros((*batch, 0), dtype=torch.float64, device=device)
        )
        q, v = _States.apply(found, stacked, *(given.expand(*batch, model.n) for given in start))
        return torch.tensor(found.t, device=device), q, v

    return run


def _doubles(name: str, given: Any) -> Any:
    """A tensor of 64 bits; numbers and sequences become one."""
    if not isinstance(given, torch.Tensor):
        return torch.as_tensor(given, dtype=torch.float64)
    if given.dtype != torch.float64:
        raise ValueError(f"{name}: got {given.dtype}, expected torch.float64: runs are computed in 64 bits")
    return given
