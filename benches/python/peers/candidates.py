"""Ways to compute the same motion, and the fastest of them that are within an error."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Candidate:
    """A way to move something; `size` is the number of modes or pieces, `seconds` are those of a step."""

    code: str
    size: int
    discretisation: str
    substeps: int
    error: float
    seconds: float
    run: Callable[[], object]


def within(found: list[Candidate], tolerance: float) -> list[Candidate]:
    """The fastest of each code; one counts only if finer steps of the same are within the error as well."""

    def holds(one: Candidate) -> bool:
        return all(
            other.error <= tolerance
            for other in found
            if (other.code, other.discretisation) == (one.code, one.discretisation)
            and other.substeps >= one.substeps
        )

    good: dict[str, list[Candidate]] = {}
    for one in filter(holds, found):
        good.setdefault(one.code, []).append(one)
    return [min(own, key=lambda one: one.seconds) for own in good.values()]
