"""``python -m lissom`` is the command ``lissom``."""

from .cli import main

main()
