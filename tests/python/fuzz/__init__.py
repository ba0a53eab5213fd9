"""Fuzzing of scenes, the Python API and the solvers, and attacks: ``python -m fuzz``.

docs/development/fuzzing.md explains it.
"""

#: Names of the harnesses, which are modules here. Random cases depend on the order.
HARNESSES = ("scenes", "api", "solvers", "robots", "files", "stores", "endings", "pages")
