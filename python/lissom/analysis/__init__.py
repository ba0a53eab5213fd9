"""Analyses of models and runs: derivatives, identification, linear models, sweeps, advice."""
