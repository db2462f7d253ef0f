"""Commands of the command line: each module adds one, and imports what it needs when it runs."""

from fenics_nnm.commands import (
    cache,
    campbell,
    check,
    convergence,
    export,
    new,
    plot,
    report,
    response,
    run,
    simulate,
    sweep,
)

COMMANDS = (
    new,
    check,
    run,
    plot,
    export,
    report,
    convergence,
    sweep,
    response,
    simulate,
    campbell,
    cache,
)
"""Modules with `add_to(commands)`, in the order of the help."""
