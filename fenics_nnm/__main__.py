"""`python -m fenics_nnm` is `fenics-nnm`."""

import sys

from fenics_nnm.processes import without_current_folder

sys.path[:] = without_current_folder(sys.path)

from fenics_nnm.interrupts import ending_at_once  # noqa: E402  # from the path without that folder


def main() -> int:
    """Run the command line and return its exit code; a Ctrl-C on the way to it ends in silence."""
    ending_at_once()
    from fenics_nnm.cli import main as run

    code = run()
    ending_at_once()
    return code


if __name__ == "__main__":
    sys.exit(main())
