"""Fuzzing of scenes, of the Python API and of the solvers: ``python -m fuzz`` (docs/fuzzing.md)."""
