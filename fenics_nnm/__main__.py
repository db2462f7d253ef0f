"""`python -m fenics_nnm` is `fenics-nnm`."""

import sys

from fenics_nnm.cli import main

sys.exit(main())
