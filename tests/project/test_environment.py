"""The lists of packages, what reads them, and their copy in conda-forge's names agree."""

from __future__ import annotations

import re
import runpy
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
LISTS = ("environment/debian-packages.txt", "environment/pip-packages.txt")

#: conda-forge's names of Debian's packages; "" for what comes with another or with the system.
CONDA = {
    "ca-certificates": "",
    "python3": "python",
    "python3-dev": "",
    "python3-pip": "pip",
    "python3-setuptools": "setuptools",
    "python3-venv": "",
    "python3-dolfinx": "fenics-dolfinx",
    "python3-dolfinx-real": "petsc",  # its build for real numbers
    "python3-petsc4py-real": "petsc4py",
    "python3-slepc4py-real": "slepc4py",
    "python3-gmsh": "python-gmsh",
    "python3-h5py": "h5py",
    "python3-matplotlib": "matplotlib",
    "python3-meshio": "meshio",
    "python3-numpy": "numpy",
    "python3-pil": "pillow",
    "python3-pydantic": "pydantic",
    "python3-rich": "rich",
    "python3-scipy": "scipy",
    "libopenblas0-pthread": "libblas",  # its build with OpenBLAS
    "libegl1": "",
    "libgl1-mesa-dri": "",
    "g++": "cxx-compiler",
    "pkg-config": "pkg-config",
    "fonts-dejavu-core": "",
    "git": "git",
    "make": "make",
    "mypy": "mypy",
    "procps": "procps-ng",
    "python3-pytest": "pytest",
    "python3-pytest-xdist": "pytest-xdist",
}

#: Debian's names of modules that are not python3-MODULE.
MODULES = {
    "PIL": "python3-pil",
    "mypy": "mypy",
    "petsc4py": "python3-petsc4py-real",
    "slepc4py": "python3-slepc4py-real",
    "xdist": "python3-pytest-xdist",
}


def text(name: str) -> str:
    return (ROOT / name).read_text("utf-8")


def listed(name: str) -> list[str]:
    """Lines of a list without comments and blanks."""
    lines = (line.partition("#")[0].strip() for line in text(name).splitlines())
    return [line for line in lines if line]


def conda() -> dict[str, str]:
    """Constraint of each package of environment.yml."""
    below = text("environment.yml").partition("\ndependencies:\n")[2].partition("- pip:")[0]
    found = re.findall(r"^  - ([a-z0-9-]+)(.*)$", below, re.MULTILINE)
    return dict(found)


def requirements() -> dict[str, str]:
    """Constraint of each requirement of the package."""
    project = tomllib.loads(text("pyproject.toml"))["project"]["dependencies"]
    return {
        re.split("[><=]", line)[0]: line.lstrip("abcdefghijklmnopqrstuvwxyz") for line in project
    }


def test_conda_has_debians_packages() -> None:
    debian = listed(LISTS[0])
    assert set(debian) == set(CONDA)
    assert set(conda()) == {CONDA[name] for name in debian} - {""}
    assert conda()["petsc"] == "=*=real*"
    assert f"- -r {LISTS[1]}\n" in text("environment.yml")


def test_lowest_versions_agree() -> None:
    project = tomllib.loads(text("pyproject.toml"))
    assert conda()["python"] == project["project"]["requires-python"]
    assert "setuptools" + conda()["setuptools"] == project["build-system"]["requires"][0]
    assert conda()["pydantic"] == requirements()["pydantic"]
    lowest = conda()["fenics-dolfinx"].partition(",")[0].removeprefix(">=")
    assert f"printf '{lowest}\\n%s\\n'" in text("environment/host.sh")


def test_lists_have_what_the_package_requires() -> None:
    debian, pip = listed(LISTS[0]), dict(line.split("==") for line in listed(LISTS[1]))
    names = {"pillow": "python3-pil"}
    for name, constraint in requirements().items():
        assert names.get(name, f"python3-{name}") in debian or name in pip
        if name in pip and constraint:
            lowest, exact = (v.split(".") for v in (constraint.removeprefix(">="), pip[name]))
            assert [int(part) for part in exact] >= [int(part) for part in lowest]


def test_probe_looks_for_packages_of_the_list() -> None:
    needed = runpy.run_path(str(ROOT / "environment/probe.py"))["NEEDED"]
    assert len(needed) > 10
    for module in needed:
        assert MODULES.get(module, f"python3-{module}") in listed(LISTS[0])


def section(name: str) -> str:
    """A section of apptainer.def."""
    found = re.search(rf"^%{name}\n(.*?)(?=^%|\Z)", text("apptainer.def"), re.M | re.S)
    assert found
    return found[1]


def test_both_images_have_one_base_and_the_same_files() -> None:
    docker = text("Dockerfile")
    assert set(re.findall(r"^From: (.+)$", text("apptainer.def"), re.MULTILINE)) == set(
        re.findall(r"^FROM (\S+:\S+)", docker, re.MULTILINE)
    )
    copied = {
        name for line in re.findall(r"^COPY (.+) \S+$", docker, re.M) for name in line.split()
    }
    assert {*LISTS, "fenics_nnm"} < copied
    assert {line.split()[0] for line in section("files").splitlines() if line} == copied
    assert all((ROOT / name).exists() for name in copied)


def test_both_images_have_the_same_variables() -> None:
    docker = dict(
        re.findall(r"^(?:ENV|   ) (\w+)=(\S+)(?= \\$|$)", text("Dockerfile"), re.MULTILINE)
    )
    apptainer = dict(re.findall(r"(\w+)=(\S+)", section("environment")))
    assert "OMPI_MCA_btl" in docker
    # Apptainer runs in the home of the user who calls it
    assert apptainer == {name: value for name, value in docker.items() if name != "HOME"}


def test_commands_of_the_apptainer_recipe_are_shell() -> None:
    for name in ("post", "environment", "runscript", "test"):
        subprocess.run(["sh", "-n"], input=section(name), text=True, check=True)
    for name in LISTS:
        assert f"/opt/{name}" in section("post")
