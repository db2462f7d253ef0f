"""Nonlinear modes of a reduced model; NumPy and SciPy only."""
