"""Everything that needs dolfinx, PETSc, SLEPc or gmsh."""
