"""Fuzzing of scenes, of the Python API and of the solvers: ``python -m fuzz`` (docs/fuzzing.md)."""

#: Names of the harnesses, which are modules here. Random cases depend on the order.
HARNESSES = ("scenes", "api", "solvers", "robots")
