"""Method and tolerances for an accuracy: chosen once, for runs that are differentiated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import LissomError, Model, MotionResult, measured_places, scales_of, simulate
from ..methods import Auto
from .doubts import without_doubts

Array = NDArray[np.float64]

#: The motion with which a run is compared is asked for this many times the accuracy, and at most for the best
#: that there is.
FINER = 5.0
BEST = 1e-11

#: Tolerances of Radau's method that are tried, relative to what was asked. In the tests the second one is
#: enough for motions of a few periods.
TRIED = (0.3, 0.03, 0.003, 3e-4, 3e-5)

#: Part of what was asked that a run may miss with the first values, so that others do not miss it either.
MARGIN = 0.5

#: Relative tolerance over the absolute one relative to typical coordinates, as in runs of 'auto'.
RELATIVE = 1e-2

#: Part of a control step by which rounding may put its begin before it.
ROUNDING = 1e-9

#: Options of 'auto'.
OF_AUTO = ("rtol", "max_step", "max_steps", "space_error")


def asked(options: Mapping[str, Any]) -> tuple[Auto, dict[str, Any]]:
    """What is asked of 'auto' by options beside it, and those that are left."""
    for name in options:
        if name not in (*OF_AUTO, "progress") and options[name] is not None:
            raise ValueError(
                f'{name}: the method "auto" takes `rtol` and chooses the rest: leave `{name}` out'
            )
    given = {name: options[name] for name in OF_AUTO if options.get(name) is not None}
    return Auto(**given), {name: value for name, value in options.items() if name not in OF_AUTO}


@dataclass(frozen=True)
class AccurateRuns:
    """Runs of a model and of similar ones, by the method that is as accurate as was asked for the first."""

    model: Model
    t_end: float
    #: Arguments of `simulate` beside the method: the start, the inputs, `dt`.
    motion: Mapping[str, Any]
    auto: Auto
    #: Times at which runs are compared; by default every `dt`.
    times: Array | None = None
    #: The method and its tolerances as options of `simulate`; empty until they are chosen.
    options: Mapping[str, Any] = field(default_factory=dict)

    def chosen(self) -> AccurateRuns:
        """With the loosest tolerances of Radau's method with which the run is as accurate as was asked.

        Raises LissomError if there are none.
        """
        right = self._right(space_error=False)
        _, sizes = scales_of(self.model)
        limits = {name: getattr(self.auto, name) for name in ("max_step", "max_steps")}
        given = {name: value for name, value in limits.items() if value is not None}
        error = np.inf
        for tried in TRIED:
            tolerance = tried * self.auto.rtol
            tolerances = {"rtol": RELATIVE * tolerance, "atol": tolerance * np.asarray(sizes)}
            found = replace(self, options={"method": "radau", **tolerances, **given})
            error = found._apart(right)
            if error <= MARGIN * self.auto.rtol:
                return found
        raise LissomError(
            f"the accuracy of {self.auto.rtol:.0e} was not reached: with the tightest tolerances of Radau's "
            f"method the time error is {error:.0e} of the length"
        )

    def verdict(self, model: Model, **start: Any) -> tuple[str, str]:
        """A sentence about the errors of the run of another model, from another start.

        With a doubt, which is empty if they are as small as was asked.
        """
        other = replace(self, model=model, motion={**self.motion, **start})
        wanted = self.auto.rtol
        try:
            right = other._right(space_error=self.auto.space_error)
        except LissomError as failure:
            return "", f"The accuracy with the fitted values is unknown: {failure}"
        error, of_space = other._apart(right), right.stats.space_error or 0.0
        sentence = f" The time error with the fitted values is {error:.0e} of the length"
        sentence += f", the space error {of_space:.0e}" if of_space else ""
        sentence += f"; {wanted:.0e} was asked for."
        if of_space > wanted:
            sentence += " The modes of the model are too few: give it more, or more segments."
        if not error <= wanted:
            return sentence, (
                f"The steps were chosen for the first values; with the fitted ones the time error is "
                f"{error:.0e} of the length, and {wanted:.0e} was asked for: fit again from these values."
            )
        return sentence, ""

    def _right(self, space_error: bool) -> MotionResult:
        """A motion that is several times as accurate, apart from its modes."""
        finer = Auto(
            rtol=max(self.auto.rtol / FINER, BEST),
            max_step=self.auto.max_step,
            max_steps=self.auto.max_steps,
            space_error=space_error,
        )
        found, _ = without_doubts(
            lambda: simulate(self.model, self.t_end, method=finer, t_eval=self.times, **self.motion)
        )
        if not found.success and found.stats.time_error is None:
            raise LissomError(f"the run did not come to its end: {found.message}")
        # With an error that is known, it may be larger than in a success.
        return found

    def _apart(self, right: MotionResult) -> float:
        """Error of the run between its steps, too, relative to the length; infinite if it fails."""
        options: Any = {**self.options, "t_eval": "steps"}
        run, _ = without_doubts(lambda: simulate(self.model, self.t_end, **self.motion, **options))
        if not run.success:
            return np.inf
        length, _ = scales_of(self.model)
        places = [np.array(measured_places(self.model, right.t, q)) for q in (between(run, right.t), right.q)]
        apart = np.abs(places[0] - places[1]).max() / length
        return float(apart) + (right.stats.time_error or 0.0)


def found_options(
    method: str, options: dict[str, Any], model: Model, t_end: float, motion: Mapping[str, Any]
) -> tuple[str, dict[str, Any]]:
    """A method with its options: for 'auto' those with which the run is as accurate as was asked."""
    if method != "auto":
        return method, options
    auto, others = asked(options)
    found = others | dict(AccurateRuns(model, t_end, motion, auto).chosen().options)
    return found.pop("method"), found


def between(run: MotionResult, times: Array) -> Array:
    """Coordinates at these times, shape (k, n): cubic between steps, as in derivatives of runs."""
    k = np.clip(np.searchsorted(run.t, times, "right") - 1, 0, len(run.t) - 2)
    h = (run.t[k + 1] - run.t[k])[:, None]
    s = (times - run.t[k])[:, None] / h
    begin = (1 + 2 * s) * (1 - s) ** 2 * run.q[k] + h * s * (1 - s) ** 2 * run.v[k]
    end: Array = s**2 * (3 - 2 * s) * run.q[k + 1] + h * s**2 * (s - 1) * run.v[k + 1]
    found: Array = begin + end
    return found


def of_rows(rows: Array | None, control_step: float | None, t0: float) -> dict[str, Any]:
    """Arguments of `simulate` for rows of inputs, each of which is held for equal times."""
    if rows is None or control_step is None:
        return {}
    if len(rows) == 1:
        return {"u": rows[0]}

    def control(t: float, _q: Array, _v: Array) -> Array:
        found: Array = rows[min(int((t - t0) / control_step + ROUNDING), len(rows) - 1)]
        return found

    return {"control": control, "control_step": control_step}
