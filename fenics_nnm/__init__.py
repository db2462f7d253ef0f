"""Nonlinear modes of elastic structures in unilateral contact."""

__version__ = "0.1.0"
