"""The command ``lissom``, also as ``python -m lissom``: hears Ctrl-C before it imports what takes time."""

from .interruption import interruption


def main() -> None:
    """Entry point of the command."""
    interruption.install()
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
