"""Simulations as differentiable JAX functions: ``import lissom.jax``.

Needs the extra `jax`: ``pip install 'lissom[jax]'``. ``docs/sensitivities.md`` has examples and costs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

try:
    import jax
    import jax.numpy as jnp
except ModuleNotFoundError as error:
    raise ImportError("lissom.jax takes JAX: pip install 'lissom[jax]'") from error

from ._lissom import Model
from .analysis.pullbacks import pullback
from .methods import Newmark

__all__ = ["simulation"]

Run = Callable[..., tuple[jax.Array, jax.Array, jax.Array]]


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
    """Return a JAX function that simulates a model and supports `jax.grad`, `jax.jit` and `jax.vmap`.

    Derivatives are those of `lissom.sensitivity` by the adjoint method: first order, in reverse mode (`grad`,
    `vjp`, `jacrev`). Under `vmap`, one `simulate_many` computes all runs; their adjoints are computed one by
    one.

    Parameters
    ----------
    model : Model
        Model to simulate, as for `sensitivity`.
    t_end : float
        End of the run, seconds; a whole number of steps after `t0`.
    parameters : sequence of str
        Model parameters that the function takes, by the names that `sweep` uses.
    t : array_like, shape (m,), optional
        Times at which the function returns states, seconds; they must be times of steps. By default all
        steps.
    t0, dt, method
        As for `sensitivity`.
    control_step : float, optional
        Duration of a control step, seconds; a whole number of steps. The function then takes inputs, one row
        per control step.
    **options
        `beta`, `gamma`, `alpha`, `rho_inf`, `rtol`, `atol`, `jac`, `predictor`, `reuse_jacobian`, `max_steps`
        as for `simulate`. `rtol` controls how accurately the steps are solved, and with it the derivatives.

    Returns
    -------
    callable
        ``run(values, q0, v0)`` with a dictionary of a number for each parameter and arrays of shape (n,)
        returns `t` of shape (m,), `q` and `v` of shape (m, n). With a `control_step` it is
        ``run(values, q0, v0, u)`` with inputs of shape (control steps, inputs). If a run fails, `q` and `v`
        are NaN from then on, and so are its derivatives.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid, a name is unknown, nothing depends on a parameter; when called, if names or
        shapes do not match, or JAX computes in 32 bits.

    Examples
    --------
    >>> import jax, lissom, lissom.jax
    >>> jax.config.update("jax_enable_x64", True)
    >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 3}, retardation_time=1e-4)
    >>> run = lissom.jax.simulation(lissom.Rod([wire]), 0.1, ["gravity[2]"], t=[0.1])
    >>> def sag(g):
    ...     return run({"gravity[2]": g}, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0])[1][0, 0]
    >>> jax.grad(sag)(-9.81).shape
    ()
    """
    found = pullback(
        model, t_end, parameters, t=t, t0=t0, dt=dt, method=method, control_step=control_step, **options
    )
    p, n, m = len(found.names), model.n, len(found.t)
    state = jax.ShapeDtypeStruct((m, n), np.float64)
    given_shapes = ((p,), (n,), (n,), found.held)
    given_types = tuple(jax.ShapeDtypeStruct(shape, np.float64) for shape in given_shapes)

    def on_host(function: Callable[..., Any], shapes: Any, *arrays: Any) -> Any:
        def of_arrays(*given: Any) -> Any:
            return function(*map(np.asarray, given))

        return jax.pure_callback(of_arrays, shapes, *arrays, vmap_method="broadcast_all")

    @jax.custom_vjp
    def states(values: Any, q0: Any, v0: Any, u: Any) -> Any:
        return on_host(found.run, (state, state), values, q0, v0, u)

    def forward(values: Any, q0: Any, v0: Any, u: Any) -> Any:
        return states(values, q0, v0, u), (values, q0, v0, u)

    def backward(kept: Any, weights: Any) -> Any:
        return on_host(found.pull, given_types, *kept, *weights)

    states.defvjp(forward, backward)

    def run(
        values: Mapping[str, Any], q0: Any, v0: Any, u: Any = None
    ) -> tuple[jax.Array, jax.Array, jax.Array]:
        if not jax.config.read("jax_enable_x64"):
            raise ValueError(
                "JAX computes in 32 bits, expected 64: jax.config.update('jax_enable_x64', True) first"
            )
        if set(values) != set(found.names):
            raise ValueError(f"values: got {sorted(values)}, expected {sorted(found.names)}")
        row = [jnp.asarray(values[name], np.float64) for name in found.names]
        for name, value in zip(found.names, row, strict=True):
            if value.shape != ():
                raise ValueError(f"values[{name!r}]: got shape {value.shape}, expected a number")
        if (u is None) != (control_step is None):
            raise ValueError(
                f"u: got {type(u).__name__}: inputs and a control_step need each other, give both or none"
            )
        u = jnp.zeros(found.held) if u is None else u
        start = [jnp.asarray(given, np.float64) for given in (q0, v0, u)]
        for name, given, shape in zip(("q0", "v0", "u"), start, given_shapes[1:], strict=True):
            if given.shape != shape:
                raise ValueError(f"{name}: got shape {given.shape}, expected {shape}")
        q, v = states(jnp.stack(row) if row else jnp.zeros(0), *start)
        return jnp.asarray(found.t), q, v

    return run
