"""Motions of a driven structure."""
