"""Possible outcomes of a case, and which of them are findings.

A case has a verdict, a detail for readers, the place that was tested, and a signature, which is equal for
cases with the same fault.
"""

import re
import signal
from dataclasses import asdict, dataclass, fields, is_dataclass

import numpy as np

#: Acceptable verdicts.
GOOD = ("done", "refused", "failed", "undecided", "slow")
#: Verdicts of findings.
BAD = ("panic", "crash", "hang", "memory", "exception", "message", "nan", "silent", "swallowed", "wrong")

#: Processor time of a case in seconds, after which Ctrl-C must be effective.
LIMIT = 10.0
#: Maximum increase of resident memory in a case, bytes. No model or run of the cases needs a tenth of this.
MEMORY = 512 * 2**20
#: Additional memory per byte of the case: for tables in a file, the parser's tree takes about seventy bytes.
MEMORY_OF_TEXT = 150
#: Maximum length of a useful message, characters.
LONGEST_MESSAGE = 50_000


@dataclass(frozen=True)
class Outcome:
    """Result of a case."""

    verdict: str
    detail: str = ""
    signature: str = ""
    place: str = ""

    @property
    def bad(self) -> bool:
        return self.verdict in BAD

    def plain(self) -> dict:
        return asdict(self)


def found(verdict, place, detail, everywhere=None) -> Outcome:
    """A finding. Its signature consists of the place and the detail without numbers and names.

    `everywhere` replaces this signature for a fault that does not depend on the place.
    """
    words = re.sub(r"'[^']*'|\"[^\"]*\"|`[^`]*`", "'…'", str(detail)[:400])
    words = re.sub(r"[-+]?(\d[\d_.]*(e[-+]?\d+)?|\binf\b|\bNaN\b|\bnan\b)", "#", words)
    signature = everywhere or f"{place} | {' '.join(words.split())[:160]}"
    return Outcome(verdict, str(detail)[:4000], f"{verdict} | {signature}", place)


def of_exception(error, where, expected) -> Outcome:
    """The outcome of a call that ended with an exception; the types in `expected` are rejections."""
    kind = type(error).__name__
    message = str(error)
    if kind == "PanicException" or "panicked" in message:
        return found("panic", where, message)
    if len(message) > LONGEST_MESSAGE:
        return found("message", where, f"{len(message)} characters: {message[:300]}", "too long")
    if isinstance(error, expected):
        if not message.strip() and not isinstance(error, MemoryError):
            return found("message", where, f"{kind} without a message")
        return Outcome("refused", f"{kind}: {message[:500]}")
    return found("exception", where, f"{kind}: {message}")


def of_death(code: int, where: str, said: str) -> Outcome:
    """The outcome if the worker died."""
    name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    last = [line for line in said.splitlines() if line.strip()]
    words = last[-1] if last else ""
    for line in last:
        if re.search(r"memory allocation|panicked|overflow|Fatal|capacity", line):
            words = line
            break
    if name == "SIGXCPU":
        return found("hang", where, "does not end, and does not hear Ctrl-C")
    if "memory allocation" in words or "capacity overflow" in words:
        return found("crash", where, f"{name}: {words}", "memory that cannot be had")
    return found("crash", where, f"{name}: {words}")


#: Attributes in which NaN is documented to mean no value: one row has no variance, no rows have no mean.
NAN_MEANS_NONE = {"step_norm", "mean", "variance"}


def has_nan(value) -> bool:
    """Whether an array, a number or a tuple of them contains NaN."""
    if isinstance(value, float | np.ndarray | np.floating):
        value = np.asarray(value)
        return value.dtype.kind in "fc" and bool(np.isnan(value).any())
    if isinstance(value, tuple | list):
        return any(has_nan(item) for item in value)
    return False


def nan_in(result) -> str | None:
    """The name of the part that is NaN in a successful result, or in an array."""
    if has_nan(result):
        return "the array"
    success = getattr(result, "success", True)
    if success is False:
        return None
    for name in public(result):
        value = getattr(result, name)
        # For many runs, only in the rows that succeeded.
        if isinstance(success, np.ndarray) and isinstance(value, np.ndarray) and len(value) == len(success):
            value = value[success]
        if name not in NAN_MEANS_NONE and has_nan(value):
            return name
    return None


def public(value) -> list[str]:
    """The public data attributes of an object of the package."""
    if not type(value).__module__.startswith("lissom"):
        return []
    if is_dataclass(value):
        return [field.name for field in fields(value) if not field.name.startswith("_")]
    return [
        name
        for name in dir(type(value))
        if not name.startswith("_")
        and not callable(attribute := getattr(type(value), name, None))
        # Old names warn when they are read.
        and not (attribute.__doc__ or "").startswith("The old name of ")
    ]
