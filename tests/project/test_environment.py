"""The lists of packages, what reads them, and their copy in conda-forge's names agree."""

from __future__ import annotations

import re
import runpy
import subprocess
import tomllib
from pathlib import Path

import fenics_nnm
from fenics_nnm.output.live_motion.library import installed_library

ROOT = Path(__file__).parents[2]
LISTS = ("environment/debian-packages.txt", "environment/pip-packages.txt")
HASHES = "environment/pip-hashes.txt"

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
    "libsuitesparse-dev": "suitesparse",
    "python3-cffi": "cffi",
    "libopenblas0-pthread": "libblas",  # its build with OpenBLAS
    "python3-platformdirs": "",  # pip has it for pooch
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
        re.split("[><=]", line)[0]: line.lstrip("-abcdefghijklmnopqrstuvwxyz") for line in project
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


def stage(name: str) -> str:
    """A stage of the Dockerfile."""
    found = re.search(rf"^FROM \S+ AS {name}\n(.*?)(?=^FROM|\Z)", text("Dockerfile"), re.M | re.S)
    assert found
    return found[1]


def copied(part: str) -> set[str]:
    """Files that a stage copies from the checkout."""
    return {name for line in re.findall(r"^COPY (.+) \S+$", part, re.M) for name in line.split()}


def test_both_images_have_one_base_and_the_same_files() -> None:
    bases = set(re.findall(r"^ARG BASE=(.+)$", text("Dockerfile"), re.MULTILINE))
    assert set(re.findall(r"^From: (.+)$", text("apptainer.def"), re.MULTILINE)) == bases
    docker = copied(stage("base")) | copied(stage("run"))
    assert {*LISTS, HASHES, "fenics_nnm"} < docker
    files = {line.split()[0] for line in section("files").splitlines() if line}
    # Apptainer is given certificates by --bind, and takes the packages of the day
    assert docker - files == {"environment/certificates", "environment/debian-snapshot"}
    assert files < docker
    assert all((ROOT / name).exists() for name in docker)


def test_both_images_have_the_same_variables() -> None:
    docker = dict(re.findall(r"^(?:ENV|   ) (\w+)=(\S+)(?= \\$|$)", stage("base"), re.MULTILINE))
    apptainer = dict(re.findall(r"(\w+)=(\S+)", section("environment")))
    assert "OMPI_MCA_btl" in docker
    # Apptainer runs in the home of the user who calls it
    assert apptainer == {name: value for name, value in docker.items() if name != "HOME"}


def test_images_to_run_studies_have_no_tools_of_tests() -> None:
    """The last stage is the one that a plain "docker build" makes; tools stand behind a heading."""
    heading = "# Tests, checks"
    tools = text(LISTS[0]).partition(heading)[2].splitlines()
    assert {"mypy", "python3-pytest", "git"} < set(tools)
    for part in (stage("base"), section("post")):
        assert f"/^{heading}/,$d" in part
        assert "pip-packages.txt ruff" in part
    stages = re.findall(r"^FROM (\S+) AS (\w+)$", text("Dockerfile"), re.MULTILINE)
    assert stages[-1] == ("base", "run")
    assert ("environment", "tests") in stages
    assert "--mount=" not in text("Dockerfile"), "Docker without BuildKit has no such option"


def test_no_file_of_the_program_is_ignored_by_images() -> None:
    """A pattern such as **/results would leave out a room of the package."""
    patterns = listed(".dockerignore")
    assert not {name for name in patterns if name.startswith("**/") and "cache" not in name}
    names = {path.name for path in ROOT.glob("fenics_nnm/*")} | {"fenics_nnm", "tests"}
    assert not {name for name in patterns if "/" not in name} & (names - {"results", "__pycache__"})


def test_pip_takes_files_that_are_known() -> None:
    locked = {line.split()[0]: line.split()[1:] for line in listed(HASHES)}
    assert set(listed(LISTS[1])) < set(locked)
    for package, digests in locked.items():
        assert digests, package
        assert all(re.fullmatch(r"--hash=sha256:[0-9a-f]{64}", each) for each in digests)
    assert len(locked["vtk==" + dict(line.split("==") for line in listed(LISTS[1]))["vtk"]]) == 8


def test_install_pip_leaves_out_a_package(tmp_path: Path) -> None:
    """Run with a python3 that writes down what it is given."""
    fake = tmp_path / "bin/python3"
    fake.parent.mkdir()
    fake.write_text(
        '#!/bin/sh\ncase "$*" in *venv*) mkdir -p "$4/bin"; cp "$0" "$4/bin/python3" ;;\n'
        '*) echo "$*"; for last; do :; done; cat "$last" ;; esac\n'
    )
    fake.chmod(0o755)
    ended = subprocess.run(
        ["sh", ROOT / "environment/install-pip", tmp_path / "venv", ROOT / LISTS[1], "ruff"],
        env={"PATH": f"{fake.parent}:/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "install --quiet --no-deps --require-hashes --requirement" in ended.stdout
    assert "\nvtk==" in ended.stdout
    assert "ruff" not in ended.stdout


def test_recipe_of_conda_has_what_the_package_needs() -> None:
    recipe = text("recipe/meta.yaml")
    run = recipe.partition("\n  run:\n")[2].partition("\ntest:")[0]
    names = {name.split()[0].removesuffix("-base") for name in re.findall(r"- (.+)", run)}
    tools = {CONDA[name] for name in listed_after("# Tests, checks")}
    needed = set(conda()) - tools - {"pip", "setuptools"} | {"pyvista", "trame-vtk", "vtk"}
    assert names == needed
    version = re.search(r'version: "(.+)"', recipe)
    assert version and version[1] == fenics_nnm.__version__
    for name in ("python", "fenics-dolfinx", "pydantic"):
        assert f"- {name} {conda()[name]}\n" in run


def test_reports_have_vtk_js_in_this_environment() -> None:
    """That of the lists, and of no other version."""
    library = installed_library()
    (line,) = re.findall(r"^trame-vtk==(.+)$", text(LISTS[1]), flags=re.MULTILINE)
    assert library is not None and f"trame-vtk {line}," in library.notice
    assert "Redistribution" in library.notice
    assert "https://kitware.github.io/vtk-js/icon" not in library.script
    assert "WebGL2RenderingContext" in library.script or "webgl2" in library.script


def listed_after(heading: str) -> list[str]:
    """Packages of Debian's list behind a heading."""
    behind = text(LISTS[0]).partition(heading)[2].splitlines()[1:]
    return [line for line in behind if line and not line.startswith("#")]


def test_all_files_of_the_package_are_in_the_wheel() -> None:
    patterns = tomllib.loads(text("pyproject.toml"))["tool"]["setuptools"]["package-data"]
    package = ROOT / "fenics_nnm"
    given = {path for pattern in patterns["fenics_nnm"] for path in package.glob(pattern)}
    files = {
        path for path in package.rglob("*") if path.is_file() and "__pycache__" not in str(path)
    }
    assert {path for path in files if path.suffix != ".py"} == given
    folders = {path.parent for path in files if path.suffix == ".py"}
    assert all((folder / "__init__.py").exists() for folder in folders)


def test_commands_of_the_apptainer_recipe_are_shell() -> None:
    for name in ("post", "environment", "runscript", "test"):
        subprocess.run(["sh", "-n"], input=section(name), text=True, check=True)
    for name in LISTS:
        assert f"/opt/{name}" in section("post")
