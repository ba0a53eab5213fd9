"""The command ``lissom``, also as ``python -m lissom``: handles Ctrl-C before slow imports."""

import os
import sys

from .common.interruption import interruption


def main() -> None:
    """Entry point of the command."""
    interruption.install()
    # OpenBLAS, which NumPy loads, starts a thread on each processor that waits actively. Commands multiply
    # small matrices only.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from .cli import main as command

    try:
        command()
    except OSError as error:
        # Commands report file errors themselves. What remains are output streams that cannot be written
        # to; their buffered data must not be flushed again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.exit(f"lissom: {error}")


if __name__ == "__main__":
    main()
