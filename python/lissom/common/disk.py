"""Files as a whole: only regular files of bounded size are read; a file is replaced completely or stays."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .arguments import path_of

#: Largest description (a scene, a URDF file) that is read, bytes. Large public URDF files have about 1 MB.
LARGEST_DESCRIPTION = 64 * 2**20

#: Longest suffix that the new file has, too: those that choose a format are shorter.
LONGEST_SUFFIX = 16

#: Opening a FIFO or a device without a reader must not block.
_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)


def read(path: str | os.PathLike[str], largest: int | None = None) -> bytes:
    """Read a regular file of at most `largest` bytes.

    Devices, FIFOs and sockets may have no end, or block for ever.

    Raises
    ------
    OSError
        If the file cannot be read, is not a regular file, or is larger.
    """
    with open(path, "rb", opener=lambda name, _: os.open(name, _FLAGS)) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "not a regular file", os.fspath(path))
        # The size of files in some pseudo file systems is zero although they have contents.
        content = file.read() if largest is None else file.read(largest + 1)
    if largest is not None and len(content) > largest:
        raise _too_large(path, largest)
    return content


def _too_large(path: str | os.PathLike[str], largest: int) -> OSError:
    return OSError(errno.EFBIG, f"larger than {largest // 2**20} MiB", os.fspath(path))


def read_beside(folder: str | os.PathLike[str], name: str, *, anywhere: bool) -> bytes:
    """Read a description that a file in `folder` names: only from that folder, unless `anywhere` is set.

    Raises
    ------
    ValueError
        If the file lies elsewhere.
    OSError
        As for `read`.
    """
    path, home = os.path.realpath(os.path.join(folder, name)), os.path.realpath(folder)
    if not anywhere and os.path.commonpath([path, home]) != home:
        raise ValueError(
            f"{name!r} leads out of the folder of the scene; `Scene.load(..., anywhere=True)` and "
            "`lissom --import-anywhere` read it all the same"
        )
    return read(path, LARGEST_DESCRIPTION)


def read_given(path: str | os.PathLike[str]) -> bytes:
    """Read a description that the user named: also from a pipe, but not more than it can have.

    Raises
    ------
    OSError
        If it cannot be read, or is too large.
    """
    with open(path, "rb") as file:
        content = file.read(LARGEST_DESCRIPTION + 1)
    if len(content) > LARGEST_DESCRIPTION:
        raise _too_large(path, LARGEST_DESCRIPTION)
    return content


def write(path: str | os.PathLike[str], content: bytes | str) -> None:
    """Write a file; an existing one is replaced by the complete new one, or stays as it is.

    Text is encoded as UTF-8. Anything but a regular file, such as ``/dev/stdout``, is written directly.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    path = path_of(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    if os.path.exists(path) and not os.path.isfile(path):
        with open(path, "wb") as file:
            file.write(data)
        return
    with replacing(path) as partial:
        partial.write_bytes(data)


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A new, empty file beside `path` with the same suffix, which replaces it when the block ends.

    The file is flushed to the disk before it is renamed. If the block raises, it is removed, and `path` is as
    it was.

    Raises
    ------
    OSError
        If `path` cannot be written; at once if it is write-protected or in a folder that is.
    """
    # A link stays a link.
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path))
    mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
    if mode is not None and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), os.fspath(path))
    suffix = target.suffix if len(target.suffix) <= LONGEST_SUFFIX else ""
    partial = target.with_name(f".lissom-{os.urandom(8).hex()}{suffix}")
    try:
        # Nobody may read it while it is written who may not read the file that it replaces.
        created = 0o666 if mode is None else mode | stat.S_IRUSR | stat.S_IWUSR
        os.close(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, created))
        yield partial
        with partial.open("r+b") as file:
            os.fsync(file.fileno())
        if mode is not None:
            partial.chmod(mode)
        partial.replace(target)
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(partial)):
            raise
        raise type(error)(error.errno, error.strerror, os.fspath(path)) from error
    finally:
        partial.unlink(missing_ok=True)
