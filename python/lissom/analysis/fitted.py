"""Results of parameter identification."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Robot, SpaceError
from .base import ParameterResult, ReadOnly

Array = NDArray[np.float64]

#: Fewest times of a motion whose residuals have a correlation.
FEWEST = 3


@dataclass(frozen=True, eq=False, repr=False)
class FittedData(ReadOnly):
    """A recording of a fit, and what is left of it.

    Attributes
    ----------
    kind : str
        'motion', 'shapes' or 'frequencies'.
    t : ndarray, shape (k,), or None
        The times of a motion, seconds.
    places : tuple of str
        Where positions were measured: link and arc length in metres; empty for frequencies.
    measured : ndarray, shape (k, places, 3) or (k,)
        The measurements: positions in metres, or frequencies in hertz.
    residuals : ndarray, shape as of the measurements
        Model minus data.
    noise : float
        Standard deviation of the measured numbers, in their unit: the given one, or an estimate from the
        residuals of all data, with as many degrees of freedom as measured numbers minus parameters.
    """

    # Pickles refer to the class by this module.
    __module__ = "lissom"

    kind: str
    t: Array | None
    places: tuple[str, ...]
    measured: Array
    residuals: Array
    noise: float

    def __repr__(self) -> str:
        return (
            f"<FittedData: {self.kind}, {self.measured.size} numbers, misfit {self.misfit:.4g} {self.unit}>"
        )

    @property
    def unit(self) -> str:
        """Unit of the measurements: 'm' or 'Hz'."""
        return "Hz" if self.kind == "frequencies" else "m"

    @property
    def fitted(self) -> Array:
        """Predictions of the fitted model: measurements plus residuals."""
        return self.measured + self.residuals

    @property
    def misfit(self) -> float:
        """Root of the mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def correlation(self) -> float:
        """Correlation of residuals that follow each other in a motion: 0 for white noise, NaN for others."""
        if self.t is None or len(self.t) < FEWEST:
            return np.nan
        residuals = self.residuals.reshape(len(self.t), -1)
        power = float((residuals**2).sum())
        return np.nan if power == 0.0 else float((residuals[1:] * residuals[:-1]).sum()) / power


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(ParameterResult):
    """Best-fit parameters, and how well the data determine them.

    It can be copied, pickled and saved; `report(path)` writes a page with values, intervals, correlations,
    data, model and residuals, `plot()` draws the measurements and the fitted model, `to_xarray()` returns a
    dataset. `print(result)` lists values, intervals and what there is to say of them.

    Attributes
    ----------
    names : tuple of str
        Names of the p parameters.
    values : ndarray, shape (p,)
        Their values.
    model : Robot
        The model with these values. Fitted initial states are not part of it.
    covariance : ndarray, shape (p, p)
        Covariance of the values, from the Jacobian at the solution and the noise. For undetermined parameters
        the diagonal is infinite and the rest of the row and column NaN.
    intervals : ndarray, shape (p, 2)
        Confidence intervals from Student's t distribution, exact if the model is linear in the parameters and
        the noise is normal and independent. Those of parameters whose lower bound is not negative are
        intervals of their logarithms if half the width is not more than the value. Where an interval leaves
        the bounds, or the value is at one, the profile of the likelihood gives both ends, or the bound is an
        end.
    undetermined : tuple of str
        Parameters that the data do not determine, alone or together.
    data : tuple of FittedData
        The data with their residuals, in the order in which they were given.
    runs : int
        Number of evaluations of the model with derivatives.
    success : bool
        Whether the search converged.
    message : str
        Reason for termination, whether the residuals are more than noise, the parameters that the data do not
        determine, those at a bound, and the number of failed trial runs.
    at_bounds : tuple of str
        Parameters that ended at a bound, which is one end of their intervals.
    confidence : float
        Coverage probability of the intervals.
    space_error : SpaceError or None
        Estimated error due to the finite number of modes of the fitted model in the measured equilibria, the
        largest one; None for motions, and where it is not known.
    """

    # Pickles refer to the class by this module, where it has its methods.
    __module__ = "lissom"

    names: tuple[str, ...]
    values: Array
    model: Robot
    covariance: Array
    intervals: Array
    undetermined: tuple[str, ...]
    data: tuple[FittedData, ...]
    runs: int
    success: bool
    message: str
    at_bounds: tuple[str, ...]
    confidence: float
    space_error: SpaceError | None = None

    def __setstate__(self, state: dict[str, Any]) -> None:
        if "data" not in state:
            own, state = split_data(state)
            state["data"] = (FittedData(**own),)
        state.setdefault("space_error", None)
        super().__setstate__(state)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value:.6g}" for name, value in zip(self.names, self.values, strict=True)
        )
        outcome = "converged" if self.success else "not converged"
        return f"<FitResult: {outcome}, {values}, {self.runs} runs>"

    def __str__(self) -> str:
        width = max(len(name) for name in (*self.names, "parameter"))
        share = f"{100 * self.confidence:g} % interval"
        lines = [f"{'parameter':<{width}}  {'value':>12}  {share} (SI units)"]
        for name, value, (low, high) in zip(self.names, self.values, self.intervals, strict=True):
            lines.append(f"{name:<{width}}  {value:>12.6g}  {low:.6g} to {high:.6g}")
        for each in self.data:
            lines.append(
                f"{each.kind}: {each.measured.size} numbers, misfit {each.misfit:.3g} {each.unit}, noise "
                f"{each.noise:.3g} {each.unit}"
            )
        return "\n".join([*lines, self.message])

    @property
    def residuals(self) -> Array:
        """Model minus data of a fit to one recording, shape as of `data[0].residuals`."""
        return self._only("residuals").residuals

    @property
    def measured(self) -> Array:
        """The measurements of a fit to one recording, shape as of the residuals."""
        return self._only("measured").measured

    @property
    def noise(self) -> float:
        """Standard deviation of the measured numbers of a fit to one recording, in their unit."""
        return self._only("noise").noise

    @property
    def t(self) -> Array | None:
        """The times of a fit to one motion, seconds, shape (k,); None for equilibria."""
        return self._only("t").t

    @property
    def places(self) -> tuple[str, ...]:
        """Where the positions of a fit to one recording were measured; empty for frequencies."""
        return self._only("places").places

    def _only(self, name: str) -> FittedData:
        if len(self.data) != 1:
            raise AttributeError(
                f"{name}: this fit has {len(self.data)} recordings, each with its own: data[0].{name} to "
                f"data[{len(self.data) - 1}].{name}"
            )
        return self.data[0]


def split_data(state: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The fields of the data, and the others, of a result from before there were several recordings."""
    names = ("t", "places", "measured", "residuals", "noise")
    own = {name: state[name] for name in names}
    kind = "frequencies" if not own["places"] else "shapes" if own["t"] is None else "motion"
    return {"kind": kind, **own}, {name: value for name, value in state.items() if name not in names}
