"""`python -m fenics_nnm` is `fenics-nnm`."""

import sys

from fenics_nnm.processes import without_current_folder

sys.path[:] = without_current_folder(sys.path)

from fenics_nnm.cli import main  # noqa: E402  # from the path without the current folder

sys.exit(main())
