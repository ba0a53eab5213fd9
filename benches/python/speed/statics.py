"""Run times of statics and modes compared with common alternatives. Prints a table; nothing is written.

- an equilibrium of the heavy elastica: SciPy's ``solve_bvp`` on the same rod, with its default tolerance and
  with a tight one, and as few load steps as it needs to converge;
- the same equilibrium by dynamic relaxation: lissom's own simulation with strong damping until it stands
  still, with the best of nine pairs of damping and step size;
- natural modes: NumPy's eigenvalues of M^-1 K with matrices from central differences of the inverse dynamics.

Times are medians of several runs. On a busy machine only their ratios are meaningful.
"""

import statistics
import sys
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_bvp

import lissom
from lissom import _lissom

sys.path.insert(0, str(Path(__file__).parents[3] / "tests" / "python"))
from reference import modes as reference

RUNS = 7
RADIUS, YOUNG = 0.01, 1e9
EI = YOUNG * np.pi / 4 * RADIUS**4

#: rho A g L^3 / (E I), and the exact tip.
LOADS = {5.0: (0.8466571800, -0.4959050446), 20.0: (0.4452320522, -0.8298814434)}


def rod(load, retardation_time=0.0, modes=10):
    density = load * EI / (9.81 * np.pi * RADIUS**2)
    segment = lissom.Segment(
        1.0, RADIUS, YOUNG, YOUNG / 3, density, modes={"bend_y": modes}, retardation_time=retardation_time
    )
    return lissom.Rod([segment])


def error(model, q, load):
    return float(np.hypot(*(model.pose(q, 1.0)[[0, 2], 3] - LOADS[load])))


def median_time(function):
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        result = function()
        times.append(time.perf_counter() - start)
    return statistics.median(times), result


def bvp(load, tol, steps):
    """phi'' = -load (1 - X) cos phi, together with x and z; the load increases in steps."""
    X = np.linspace(0, 1, 11)
    y = np.array([0 * X, 0 * X, X, 0 * X])
    for part in np.arange(1, steps + 1) / steps:

        def rate(X, y, part=part):
            return np.array([y[1], -part * load * (1 - X) * np.cos(y[0]), np.cos(y[0]), -np.sin(y[0])])

        def ends(a, b):
            return np.array([a[0], b[1], a[2], a[3]])

        found = solve_bvp(rate, ends, X, y, tol=tol, max_nodes=20_000)
        if not found.success:
            return None
        X, y = found.x, found.y
    return y[2, -1], y[3, -1]


def relaxation(load, tolerance):
    """Strongly damped simulation until the tip moves by less than the tolerance in a step."""
    first = lissom.modes(rod(load), lissom.statics(rod(load)).q).angular_frequency[0]
    best = None
    for damping in (0.5, 1.0, 2.0):
        model = rod(load, retardation_time=2 * damping / first)
        for step in (0.3 / first, 1.0 / first, 3.0 / first):

            def run(model=model, step=step):
                q, v = np.zeros(model.n), np.zeros(model.n)
                for _ in range(200):
                    motion = lissom.simulate(
                        model, 10 * step, q0=q, v0=v, method="generalised_alpha", rho_inf=0.0, dt=step
                    )
                    if not motion.success:
                        return None
                    moved = np.abs(motion.q[-1] - q).max()
                    q, v = motion.q[-1], motion.v[-1]
                    if moved < tolerance:
                        return q
                return None

            seconds, q = median_time(run)
            if q is not None and (best is None or seconds < best[0]):
                best = seconds, q
    return best


def statics_table():
    print(f"{'rho A g L^3 / EI':>17} {'method':36} {'time':>11} {'tip error':>10} {'times lissom':>13}")
    for load in LOADS:
        model = rod(load)
        own, found = median_time(lambda model=model: lissom.statics(model))
        rows = [("lissom.statics, 10 modes", own, error(model, found.q, load))]
        for tol in (1e-3, 1e-9):
            steps = next(steps for steps in (1, 2, 4, 8, 16, 32) if bvp(load, tol, steps) is not None)
            seconds, tip = median_time(lambda load=load, tol=tol, steps=steps: bvp(load, tol, steps))
            name = f"solve_bvp, tol {tol:.0e}, {steps} load step{'s' if steps > 1 else ''}"
            rows.append((name, seconds, float(np.hypot(*(np.array(tip) - LOADS[load])))))
        relaxed = relaxation(load, 1e-8)
        if relaxed is not None:
            rows.append(("dynamic relaxation (lissom.simulate)", relaxed[0], error(model, relaxed[1], load)))
        for name, seconds, miss in rows:
            print(f"{load:17.0f} {name:36} {seconds * 1e3:8.3f} ms {miss:10.1e} {seconds / own:13.1f}")


def modes_table():
    print(f"\n{'n':>4} {'lissom.modes':>13} {'NumPy, differences':>19} {'NumPy, exact matrices':>22}")
    for modes in (6, 12, 24, 48):
        model = rod(5.0, modes=modes)
        q = lissom.statics(model).q
        zero = np.zeros(modes)

        def exact(model=model, q=q, zero=zero):
            K, _, M = model.tangent(q, zero, zero)
            return np.linalg.eigvals(np.linalg.solve(M, K))

        def differences(model=model, q=q):
            return reference.eigenvalues(*reference.matrices(model, q))

        own, _ = median_time(lambda model=model, q=q: lissom.modes(model, q))
        by_differences, by_tangent = median_time(differences)[0], median_time(exact)[0]
        print(
            f"{modes:4d} {own * 1e6:10.0f} us {by_differences * 1e6:10.0f} us ({by_differences / own:4.1f}x)"
            f" {by_tangent * 1e6:10.0f} us ({by_tangent / own:4.1f}x)"
        )


if __name__ == "__main__":
    assert _lissom.build_profile == "release", "a debug build is not worth timing"
    statics_table()
    modes_table()
