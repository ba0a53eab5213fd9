"""Error of the inverse dynamics against the number of quadrature nodes: the table of docs/methods/rods.md.

python benches/python/accuracy/nodes.py
"""

import numpy as np

import lissom

STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")
NODES = (8, 12, 16, 20, 24, 32)
REFERENCE_NODES = 64
SAMPLES = 20


def rod(strains: tuple[str, ...], modes: int, nodes: int | None) -> lissom.Rod:
    """A soft rod of one metre with the same number of modes of every strain."""
    return lissom.Rod(
        [lissom.Segment(1.0, 0.01, 1e6, 4e5, 1000.0, dict.fromkeys(strains, modes), nodes=nodes)]
    )


def random_shape(strains: tuple[str, ...], modes: int, turns: float, rng: np.random.Generator) -> np.ndarray:
    """Bend and twist with this many turns of the rod; stretch and shear of about ten percent."""
    q = rng.normal(size=(len(strains), modes))
    is_angular = np.array([strain in STRAINS[:3] for strain in strains])
    x = np.linspace(-1, 1, 401)
    legendre = np.polynomial.legendre.legvander(x, modes - 1)
    curvature = np.linalg.norm(q[is_angular] @ legendre.T, axis=0)
    q[is_angular] *= 2 * np.pi * turns / curvature.mean()
    q[~is_angular] *= 0.1
    return q.ravel()


def largest_error(strains: tuple[str, ...], modes: int, turns: float, nodes: int | None) -> float:
    """Largest error of the generalised forces over random states, relative to the largest force."""
    model, reference = rod(strains, modes, nodes), rod(strains, modes, REFERENCE_NODES)
    worst = 0.0
    for seed in range(SAMPLES):
        rng = np.random.default_rng(seed)
        q = random_shape(strains, modes, turns, rng)
        v, a = rng.normal(size=(2, model.n))
        exact = reference.inverse_dynamics(q, v, a)
        error = np.abs(model.inverse_dynamics(q, v, a) - exact).max() / np.abs(exact).max()
        worst = max(worst, error)
    return worst


def main() -> None:
    for title, strains in (("all strains", STRAINS), ("bend_y alone", ("bend_y",))):
        print(
            f"\n{title}\n\n| modes | turns | default |", " | ".join(f"{nodes} nodes" for nodes in NODES), "|"
        )
        print("|---|---|---|" + "---|" * len(NODES))
        for modes in (1, 2, 4, 8):
            for turns in (0.25, 0.5, 1, 2):
                default = rod(strains, modes, None).nodes[0]
                errors = [largest_error(strains, modes, turns, nodes) for nodes in (default, *NODES)]
                cells = [f"{errors[0]:.0e} ({default})", *(f"{error:.0e}" for error in errors[1:])]
                print(f"| {modes} | {turns} |", " | ".join(cells), "|")


if __name__ == "__main__":
    main()
