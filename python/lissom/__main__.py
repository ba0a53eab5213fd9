"""The command ``lissom``, also as ``python -m lissom``: hears Ctrl-C before it imports what takes time."""

import os
import sys

from .interruption import interruption


def main() -> None:
    """Entry point of the command."""
    interruption.install()
    from .cli import main as command

    try:
        command()
    except OSError as error:
        # Commands say themselves what is wrong with files. What is left are outputs that cannot be written
        # to; what they still hold back must not be tried again at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.exit(f"lissom: {error}")


if __name__ == "__main__":
    main()
