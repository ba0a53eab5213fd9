"""The command ``lissom``, also as ``python -m lissom``: handles Ctrl-C before slow imports."""

import gc
import os
import sys

from .common.interruption import interruption

#: Number of objects after which Python searches for cycles: more than imports make.
COLLECT_AFTER = 100_000


def main() -> None:
    """Entry point of the command."""
    interruption.install()
    # Imports make many objects and no garbage, for which Python would search all of them again and again.
    gc.set_threshold(COLLECT_AFTER)
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
