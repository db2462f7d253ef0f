"""Commands of the command line: each module adds one, and imports what it needs when it runs."""

from fenics_nnm.commands import check, convergence, plot, report, run

COMMANDS = (run, check, plot, report, convergence)
"""Modules with `add_to(commands)`, in the order of the help."""
