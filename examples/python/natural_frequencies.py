"""The natural frequencies of a soft tapered arm, from its mass matrix and its exact tangent.

Around an equilibrium the motion is M qdd + K q = 0 with K = d tau / d q, so that omega^2 are the eigenvalues
of M^-1 K. Bending comes in pairs, about y and about z, with the same frequency.
"""

import numpy as np

import lissom


def arm(modes: int) -> lissom.Rod:
    """Half a metre of silicone that tapers from 30 mm to 10 mm, weightless and so at rest when straight."""
    segment = lissom.Segment(
        length=0.5,
        radius=(0.015, 0.005),
        young_modulus=1e6,
        shear_modulus=3.4e5,
        density=1100.0,
        modes={"torsion": modes, "bend_y": modes, "bend_z": modes, "stretch": modes},
    )
    return lissom.Rod([segment], gravity=(0, 0, 0))


def natural_frequencies(rod: lissom.Rod) -> np.ndarray:
    """In hertz, ascending, of the straight rod."""
    rest = np.zeros(rod.n)
    stiffness, _, _ = rod.tangent(rest, rest, rest)
    squares = np.linalg.eigvals(np.linalg.solve(rod.mass_matrix(rest), stiffness))
    return np.sort(np.sqrt(squares.real)) / (2 * np.pi)


def main() -> None:
    """Print the lowest frequencies for more and more modes."""
    for modes in (2, 4, 6, 8):
        lowest = natural_frequencies(arm(modes))[:6]
        print(f"{modes} modes a strain:", " ".join(f"{frequency:8.4f}" for frequency in lowest), "Hz")


if __name__ == "__main__":
    main()
