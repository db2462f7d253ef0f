"""Files and pictures."""

from fenics_nnm.files.in_root import in_root

with in_root():  # a matplotlibrc in the current folder may be somebody else's
    import matplotlib  # noqa: F401
