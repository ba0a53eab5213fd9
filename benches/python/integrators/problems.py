"""The problems of work_precision.py, with every right-hand side in plain Python, as numba.cfunc and for jax.

Sources: Hairer, Norsett, Wanner (1993), "Solving Ordinary Differential Equations I" (HNW); Hairer, Wanner
(1996), "Solving Ordinary Differential Equations II" (HW); Mazzia, Magherini (2008), "Test Set for Initial
Value Problem Solvers" (IVP).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, sin

import numba
import numpy as np
from numba import types

POINTER = types.CPointer(types.double)
RHS_SIGNATURE = types.void(types.double, POINTER, POINTER, POINTER)

MU = 0.012277471
MU_1 = 1.0 - MU
VAN_DER_POL_MU = 1000.0
STIFFNESS = 40.0
GRAVITY = 9.81
STARS = 7


@dataclass(frozen=True)
class Problem:
    """y' = fun(t, y), y(t_span[0]) = y0.

    `write` and `write_jacobian` evaluate `fun` and `jac` in place, in the subset of Python that numba
    compiles; `jax` builds the function for jax. `final` is the final state if the literature gives it.
    """

    name: str
    fun: Callable
    write: Callable
    jax: Callable
    t_span: tuple[float, float]
    y0: np.ndarray
    stiff: bool = False
    # Absolute tolerance divided by relative tolerance.
    atol_ratio: float = 1.0
    jac: Callable | None = None
    write_jacobian: Callable | None = None
    final: np.ndarray | None = None
    # Weights of the components of the error; 1 / |y| if components differ by orders of magnitude.
    error_weights: np.ndarray | None = field(default=None)

    def cfunc(self):
        return numba.cfunc(RHS_SIGNATURE)(self.write)

    def cfunc_jacobian(self):
        return numba.cfunc(RHS_SIGNATURE)(self.write_jacobian) if self.write_jacobian else None


def spring_pendulum():
    """lissom's model of a spring pendulum (polar coordinates), written out for the other solvers."""

    def fun(t, y):
        angle, elongation, angle_rate, elongation_rate = y
        r = 1.0 + elongation
        return [
            angle_rate,
            elongation_rate,
            (-GRAVITY * cos(angle) - 2.0 * elongation_rate * angle_rate) / r,
            r * angle_rate * angle_rate - STIFFNESS * elongation - GRAVITY * sin(angle),
        ]

    def write(t, y, dydt, args):
        r = 1.0 + y[1]
        dydt[0] = y[2]
        dydt[1] = y[3]
        dydt[2] = (-GRAVITY * np.cos(y[0]) - 2.0 * y[3] * y[2]) / r
        dydt[3] = r * y[2] * y[2] - STIFFNESS * y[1] - GRAVITY * np.sin(y[0])

    def jax(jnp):
        def rhs(t, y, args):
            r = 1.0 + y[1]
            return jnp.stack(
                [
                    y[2],
                    y[3],
                    (-GRAVITY * jnp.cos(y[0]) - 2.0 * y[3] * y[2]) / r,
                    r * y[2] * y[2] - STIFFNESS * y[1] - GRAVITY * jnp.sin(y[0]),
                ]
            )

        return rhs

    return Problem("spring pendulum", fun, write, jax, (0.0, 10.0), np.array([0.0, 0.1, 0.0, 0.0]))


def pleiades():
    """Seven stars in a plane (HNW, section II.10)."""
    masses = np.arange(1.0, STARS + 1.0)

    def fun(t, y):
        x, z, vx, vz = y.reshape(4, STARS)
        dx, dz = x - x[:, None], z - z[:, None]
        cubed = (dx * dx + dz * dz) ** 1.5
        np.fill_diagonal(cubed, 1.0)
        return np.concatenate([vx, vz, (masses * dx / cubed).sum(axis=1), (masses * dz / cubed).sum(axis=1)])

    def write(t, y, dydt, args):
        for i in range(2 * STARS):
            dydt[i] = y[2 * STARS + i]
            dydt[2 * STARS + i] = 0.0
        for i in range(STARS):
            for j in range(i):
                dx = y[j] - y[i]
                dz = y[STARS + j] - y[STARS + i]
                squared = dx * dx + dz * dz
                factor = 1.0 / (squared * np.sqrt(squared))
                dydt[2 * STARS + i] += (j + 1.0) * factor * dx
                dydt[3 * STARS + i] += (j + 1.0) * factor * dz
                dydt[2 * STARS + j] -= (i + 1.0) * factor * dx
                dydt[3 * STARS + j] -= (i + 1.0) * factor * dz

    def jax(jnp):
        weights = jnp.asarray(masses)

        def rhs(t, y, args):
            x, z, vx, vz = y.reshape(4, STARS)
            dx, dz = x - x[:, None], z - z[:, None]
            cubed = (dx * dx + dz * dz + jnp.eye(STARS)) ** 1.5
            ax = (weights * dx / cubed).sum(axis=1)
            az = (weights * dz / cubed).sum(axis=1)
            return jnp.concatenate([vx, vz, ax, az])

        return rhs

    x = [3, 3, -1, -3, 2, -2, 2]
    z = [3, -3, 2, 0, 0, -4, 4]
    vx = [0, 0, 0, 0, 0, 1.75, -1.5]
    vz = [0, 0, 0, -1.25, 1, 0, 0]
    y0 = np.array([*x, *z, *vx, *vz], dtype=float)
    return Problem("Pleiades", fun, write, jax, (0.0, 3.0), y0)


def arenstorf():
    """A periodic orbit of the restricted three-body problem (HNW, section II.0)."""

    def fun(t, y):
        x, z, vx, vz = y
        d = ((x + MU) ** 2 + z * z) ** 1.5
        d_1 = ((x - MU_1) ** 2 + z * z) ** 1.5
        return [
            vx,
            vz,
            x + 2.0 * vz - MU_1 * (x + MU) / d - MU * (x - MU_1) / d_1,
            z - 2.0 * vx - MU_1 * z / d - MU * z / d_1,
        ]

    def write(t, y, dydt, args):
        r = (y[0] + MU) ** 2 + y[1] * y[1]
        r_1 = (y[0] - MU_1) ** 2 + y[1] * y[1]
        d = r * np.sqrt(r)
        d_1 = r_1 * np.sqrt(r_1)
        dydt[0] = y[2]
        dydt[1] = y[3]
        dydt[2] = y[0] + 2.0 * y[3] - MU_1 * (y[0] + MU) / d - MU * (y[0] - MU_1) / d_1
        dydt[3] = y[1] - 2.0 * y[2] - MU_1 * y[1] / d - MU * y[1] / d_1

    def jax(jnp):
        def rhs(t, y, args):
            return jnp.stack(fun(t, y))

        return rhs

    y0 = np.array([0.994, 0.0, 0.0, -2.00158510637908252240537862224])
    t_span = (0.0, 17.0652165601579625588917206249)
    return Problem("Arenstorf", fun, write, jax, t_span, y0, final=y0)


def rigid_body():
    """Euler's equations without moments, principal moments 1/2, 2 and 3."""

    def fun(t, y):
        a, b, c = y
        return [-2.0 * b * c, 1.25 * a * c, -0.5 * a * b]

    def write(t, y, dydt, args):
        dydt[0] = -2.0 * y[1] * y[2]
        dydt[1] = 1.25 * y[0] * y[2]
        dydt[2] = -0.5 * y[0] * y[1]

    def jax(jnp):
        def rhs(t, y, args):
            return jnp.stack(fun(t, y))

        return rhs

    return Problem("rigid body", fun, write, jax, (0.0, 20.0), np.array([1.0, 0.0, 0.9]))


def van_der_pol():
    """Relaxation oscillation, mu = 1000 (HW, section IV.1, in the time of IVP, problem VDPOL)."""
    mu = VAN_DER_POL_MU

    def fun(t, y):
        position, velocity = y
        return [velocity, mu * (1.0 - position * position) * velocity - position]

    def jac(t, y):
        position, velocity = y
        return np.array(
            [[0.0, 1.0], [-2.0 * mu * position * velocity - 1.0, mu * (1.0 - position * position)]]
        )

    def write(t, y, dydt, args):
        dydt[0] = y[1]
        dydt[1] = mu * (1.0 - y[0] * y[0]) * y[1] - y[0]

    def write_jacobian(t, y, jacobian, args):
        jacobian[0] = 0.0
        jacobian[1] = 1.0
        jacobian[2] = -2.0 * mu * y[0] * y[1] - 1.0
        jacobian[3] = mu * (1.0 - y[0] * y[0])

    def jax(jnp):
        def rhs(t, y, args):
            return jnp.stack(fun(t, y))

        return rhs

    final = np.array([0.1706167732170483e1, -0.8928097010247975e-3])
    return Problem(
        "Van der Pol",
        fun,
        write,
        jax,
        (0.0, 2.0 * mu),
        np.array([2.0, 0.0]),
        stiff=True,
        jac=jac,
        write_jacobian=write_jacobian,
        final=final,
        error_weights=1.0 / np.abs(final),
    )


def robertson():
    """Three chemical reactions, rates from 0.04 to 3e7, to t = 1e11 (IVP, problem ROBER)."""

    def fun(t, y):
        a, b, c = y
        slow, fast, merge = 0.04 * a, 3e7 * b * b, 1e4 * b * c
        return [merge - slow, slow - merge - fast, fast]

    def jac(t, y):
        _, b, c = y
        return np.array(
            [[-0.04, 1e4 * c, 1e4 * b], [0.04, -1e4 * c - 6e7 * b, -1e4 * b], [0.0, 6e7 * b, 0.0]]
        )

    def write(t, y, dydt, args):
        slow = 0.04 * y[0]
        fast = 3e7 * y[1] * y[1]
        merge = 1e4 * y[1] * y[2]
        dydt[0] = merge - slow
        dydt[1] = slow - merge - fast
        dydt[2] = fast

    def write_jacobian(t, y, jacobian, args):
        jacobian[0] = -0.04
        jacobian[1] = 1e4 * y[2]
        jacobian[2] = 1e4 * y[1]
        jacobian[3] = 0.04
        jacobian[4] = -1e4 * y[2] - 6e7 * y[1]
        jacobian[5] = -1e4 * y[1]
        jacobian[6] = 0.0
        jacobian[7] = 6e7 * y[1]
        jacobian[8] = 0.0

    def jax(jnp):
        def rhs(t, y, args):
            return jnp.stack(fun(t, y))

        return rhs

    final = np.array([0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050])
    return Problem(
        "Robertson",
        fun,
        write,
        jax,
        (0.0, 1e11),
        np.array([1.0, 0.0, 0.0]),
        stiff=True,
        atol_ratio=1e-8,
        jac=jac,
        write_jacobian=write_jacobian,
        final=final,
        error_weights=1.0 / np.abs(final),
    )


PROBLEMS = [spring_pendulum, pleiades, arenstorf, rigid_body, van_der_pol, robertson]
