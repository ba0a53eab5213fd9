"""Test problems with known difficulty, for solvers of every kind."""
