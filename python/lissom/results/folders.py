"""Folders of results: checked and locked before the first step, filled when all files are complete."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path
from types import TracebackType

from ..common import disk

#: Name of the file that marks a folder as results of lissom, by its key MARK.
SUMMARY = "summary.json"
MARK = "lissom"

#: Every file that lissom writes into a folder of results, in the order in which they are named.
OWN_FILES = (
    "trajectory.nc",
    "trajectory.npz",
    "equilibrium.npz",
    "modes.npz",
    "sweep.nc",
    "sweep.npz",
    "report.html",
    "lab.html",
    SUMMARY,
)

#: Prefix of the temporary folders that hold results until they are complete.
PARTIAL = ".lissom-partial-"

#: Bytes written to test whether a folder is writable: one block of most file systems.
TRIAL = 4096


class NotOurs(Exception):
    """The folder must not be written: it contains other files, or another run is using it."""


class Folder:
    """A folder for results, locked by one run from beginning to end.

    It is created, locked and tested immediately. Files are written to ``partial``, a hidden folder inside,
    and moved to their places by ``publish``, the summary last; until then results of an earlier run remain.
    Without ``publish`` nothing is left. Files that lissom did not write are never changed.

    Raises NotOurs for a folder that must not be written, OSError for one that cannot be.
    """

    def __init__(self, target: Path) -> None:
        check_target(target)
        #: The folder as given.
        self.target = target
        self._place = Path(os.path.realpath(target))
        self._made = _make(self._place)
        # If this raises, the folder stays with the run that holds the lock.
        self._lock = _lock(self._place, target)
        #: Where the files are written.
        self.partial = self._place / f"{PARTIAL}{os.urandom(8).hex()}"
        try:
            if self._lock is not None:
                # This run holds the lock, so these are left over from killed runs.
                for leftover in self._place.glob(f"{PARTIAL}*"):
                    shutil.rmtree(leftover, ignore_errors=True)
            # Another run may have ended since the first check.
            check_target(target)
            self.partial.mkdir()
            _try(self.partial / "trial")
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Folder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def publish(self) -> list[str]:
        """Move the files of ``partial`` into the folder, replacing older ones; returns their names."""
        written = [name for name in OWN_FILES if (self.partial / name).exists()]
        for name in written:
            # A full disk may be reported only now.
            _flush(self.partial / name)
        for stale in OWN_FILES:
            if stale not in written:
                (self._place / stale).unlink(missing_ok=True)
        for name in written:
            (self.partial / name).replace(self._place / name)
        return written

    def close(self) -> None:
        """Remove incomplete files, and the folder itself if this run created it and it is empty."""
        shutil.rmtree(self.partial, ignore_errors=True)
        for made in self._made:
            try:
                made.rmdir()
            except OSError:
                break
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def _make(folder: Path) -> list[Path]:
    """Make a folder and its parents; return those that did not exist, innermost first."""
    absent = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return absent


def _lock(folder: Path, name: Path) -> int | None:
    """Lock a folder until the process ends, however it ends; None if the system has no such locks."""
    if sys.platform == "win32":
        return None
    import fcntl

    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise NotOurs(
            f"another run of lissom is writing into {name}; wait for its end, or name another folder with -o"
        ) from None
    except OSError:
        # Some network file systems have no locks. There, the last of several runs into one folder wins.
        os.close(handle)
        return None
    return handle


def _try(path: Path) -> None:
    path.write_bytes(bytes(TRIAL))
    _flush(path)
    path.unlink()


def _flush(path: Path) -> None:
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def check_target(folder: Path) -> None:
    """Raise NotOurs unless ``folder`` may be written: absent, empty, or with results of lissom only."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise NotOurs(f"{folder} is a file; name another folder with -o")
    found = sorted(path for path in folder.iterdir() if not path.name.startswith(PARTIAL))
    foreign = [path.name for path in found if not is_own(path)]
    if not foreign and found and not is_own_summary(folder / SUMMARY):
        foreign = [path.name for path in found]
    if foreign:
        more = f" and {len(foreign) - 1} more" if len(foreign) > 1 else ""
        raise NotOurs(
            f"{folder} has {foreign[0]}{more}, which lissom did not write; name another folder with -o, "
            "or move your own files out of this one"
        )


def is_own(path: Path) -> bool:
    """Whether lissom writes files with this name."""
    return path.name in OWN_FILES and path.is_file() and not path.is_symlink()


def is_own_summary(path: Path) -> bool:
    """Whether lissom wrote this summary."""
    try:
        numbers = json.loads(disk.read(path, disk.LARGEST_DESCRIPTION))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(numbers, dict) and isinstance(numbers.get(MARK), str)
