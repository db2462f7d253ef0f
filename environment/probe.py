"""Tell environment/run what this Python has, as lines of shell-readable words.

dolfinx VERSION      or nothing if there is no dolfinx
missing MODULE       one line for each other module that is needed and not there
pip REQUIREMENT      one line for each line of the pip list that is not fulfilled
path FOLDER          one line for each folder that packages are searched in
"""

import importlib.metadata
import importlib.util
import os
import sys

NEEDED = ["PIL", "gmsh", "h5py", "matplotlib", "meshio", "mypy", "numpy", "petsc4py"]
NEEDED += ["pydantic", "pytest", "rich", "scipy", "slepc4py", "xdist"]


def dolfinx_version() -> str:
    """Return the version of dolfinx, or an empty string."""
    if importlib.util.find_spec("dolfinx") is None:
        return ""
    try:
        return importlib.metadata.version("fenics-dolfinx")
    except importlib.metadata.PackageNotFoundError:
        import dolfinx

        return str(dolfinx.__version__)


def fulfilled(requirement: str) -> bool:
    """Tell whether a requirement NAME==VERSION is installed."""
    name, _, version = requirement.partition("==")
    try:
        return importlib.metadata.version(name) == version
    except importlib.metadata.PackageNotFoundError:
        return False


def main() -> None:
    """Print the lines."""
    for folder in sys.path:
        if os.path.isdir(folder):
            print("path", folder)
    version = dolfinx_version()
    if not version:
        return
    print("dolfinx", version)
    for module in NEEDED:
        if importlib.util.find_spec(module) is None:
            print("missing", module)
    for requirement in sys.argv[1:]:
        if not fulfilled(requirement):
            print("pip", requirement)


if __name__ == "__main__":
    main()
