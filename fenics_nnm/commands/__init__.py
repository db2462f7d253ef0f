"""Commands of the command line: each module adds one, and imports what it needs when it runs."""

from fenics_nnm.commands import (
    campbell,
    check,
    convergence,
    export,
    new,
    plot,
    report,
    response,
    run,
    sweep,
)

COMMANDS = (new, check, run, plot, export, report, convergence, sweep, response, campbell)
"""Modules with `add_to(commands)`, in the order of the help."""
