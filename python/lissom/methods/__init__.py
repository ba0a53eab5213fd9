"""Methods of simulations with their options, for `method=` of `simulate`, `simulate_many`, `Simulation`,
`Simulations` and `sensitivity`: ``lissom.simulate(robot, 1.0, method=lissom.methods.Radau(rtol=1e-9))``.

The name of a method with options beside it, as ``method="radau", rtol=1e-9``, is a shorthand for the same.
"""

from .._lissom import _methods

Newmark = _methods.Newmark
Radau = _methods.Radau
RK45 = _methods.RK45
DOP853 = _methods.DOP853
QuasiStatic = _methods.QuasiStatic
Auto = _methods.Auto

__all__ = ["DOP853", "RK45", "Auto", "Newmark", "QuasiStatic", "Radau"]


def __dir__() -> list[str]:
    return __all__
