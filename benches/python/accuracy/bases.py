"""Conditioning and convergence of the strain bases: the tables of docs/bases.md.

python benches/python/accuracy/bases.py
"""

from collections.abc import Callable

import numpy as np

import lissom

BASES = ("legendre", "chebyshev", "monomial", "piecewise_constant", "hermite")
MODES = (2, 4, 8, 12, 16, 24)
NO_GRAVITY = (0, 0, 0)
REFERENCE_MODES = 20


def rod(basis: str, modes: int, **loads: tuple[float, float, float]) -> lissom.Rod:
    """A soft rod of one metre that bends in a plane."""
    segment = lissom.Segment(1.0, 0.01, 1e6, 4e5, 1000.0, {"bend_y": modes}, basis=basis)
    return lissom.Rod([segment], gravity=NO_GRAVITY, **loads)


def conditions(basis: str, modes: int) -> tuple[float, float]:
    """Condition numbers of the stiffness matrix and of the mass matrix of the straight rod."""
    rest = np.zeros(modes)
    model = rod(basis, modes)
    stiffness, _, _ = model.tangent(rest, rest, rest)
    return np.linalg.cond(stiffness), np.linalg.cond(model.mass_matrix(rest))


def tip(basis: str, modes: int) -> np.ndarray | None:
    """Position of the tip in equilibrium under a force, or None if no equilibrium is found."""
    model = rod(basis, modes, tip_force=(0.01, 0, 0.02))
    rest = lissom.statics(model)
    return model.pose(rest.q, 1.0)[:3, 3] if rest.success else None


def tip_error(basis: str, modes: int) -> str:
    """Distance of the tip from that of the rod with many modes."""
    found, exact = tip(basis, modes), tip("legendre", REFERENCE_MODES)
    return "not found" if found is None else f"{np.linalg.norm(found - exact):.0e}"


def table(title: str, cell: Callable[[str, int], str]) -> None:
    """Prints a table with a cell for each basis and number of modes."""
    print(f"\n{title}\n\n| basis |", " | ".join(f"{modes} modes" for modes in MODES), "|")
    print("|---|" + "---|" * len(MODES))
    for basis in BASES:
        print(f"| {basis} |", " | ".join(cell(basis, modes) for modes in MODES), "|")


def main() -> None:
    table("cond(K)", lambda basis, modes: f"{conditions(basis, modes)[0]:.0e}")
    table("cond(M)", lambda basis, modes: f"{conditions(basis, modes)[1]:.0e}")
    table("error of the tip", tip_error)


if __name__ == "__main__":
    main()
