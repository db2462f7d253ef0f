"""Commands of the command line: each module adds one, and imports what it needs when it runs."""

from fenics_nnm.commands import check, convergence, export, plot, run

COMMANDS = (run, check, plot, export, convergence)
"""Modules with `add_to(commands)`, in the order of the help."""
