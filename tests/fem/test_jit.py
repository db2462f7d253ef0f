"""The compiler of forms: no options from the current folder, and nothing waits for what is dead."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import ffcx
import pytest
from dolfinx import jit

import fenics_nnm.fem.compat  # noqa: F401  # which makes it safe
from fenics_nnm.fem.jit import quick, whole
from fenics_nnm.processes import environment_of_child


def test_options_in_the_current_folder_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Code would be loaded from a folder that came with a study of somebody else."""
    before = jit.get_options(), ffcx.get_options()
    (tmp_path / "dolfinx_jit_options.json").write_text(json.dumps({"cache_dir": str(tmp_path)}))
    (tmp_path / "ffcx_options.json").write_text(json.dumps({"epsilon": 1.0}))
    monkeypatch.chdir(tmp_path)
    assert (jit.get_options(), ffcx.get_options()) == before


def test_a_compilation_that_was_killed_is_made_again(tmp_path: Path) -> None:
    source = tmp_path / "libffcx_forms_1.c"
    source.write_text("")

    def compile_() -> str:
        if source.exists():
            raise TimeoutError(f"JIT compilation timed out. Try (e.g. remove {source}) or wait.")
        return "compiled"

    assert whole(compile_)() == "compiled"
    source.write_text("")
    source.with_suffix(".c.cached").write_text("")
    with pytest.raises(TimeoutError):  # it has come to its end, so that something else is wrong
        whole(compile_)()


@pytest.mark.parametrize("fails", [False, True])
def test_ctrl_c_waits_for_a_compilation(fails: bool) -> None:
    """The C compiler may have got it, too."""
    done = []

    def compile_(**named: Any) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        if fails:
            raise ValueError("the C compiler was ended")
        done.append(named)

    with pytest.raises(KeyboardInterrupt):
        whole(compile_)(of="a form")
    assert done == ([] if fails else [{"of": "a form"}])


def test_files_of_options_in_the_current_folder_have_no_effect(tmp_path: Path) -> None:
    """PETSc would write a log, and matplotlib draw on red, in the folder of somebody's study."""
    (tmp_path / ".petscrc").write_text("-log_view :log\n")
    (tmp_path / "matplotlibrc").write_text("axes.facecolor: red\n")
    script = (
        "from fenics_nnm.fem import petsc_options\npetsc_options.begin()\n"
        "import fenics_nnm.output\nfrom matplotlib import rcParams\n"
        "from petsc4py import PETSc\nprint(PETSc.Options().getAll(), rcParams['axes.facecolor'])"
    )
    ended = subprocess.run(
        [sys.executable, "-P", "-c", script],
        cwd=tmp_path,
        env=environment_of_child(PETSC_OPTIONS=""),
        capture_output=True,
        text=True,
        check=True,
    )
    assert "log_view" not in ended.stdout and ended.stdout.endswith("white\n")
    assert not (tmp_path / "log").exists()


def test_sums_in_any_order_and_options_of_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiler takes the last of options that contradict each other."""
    own = {"cffi_extra_compile_args": ["-O1", "-fno-associative-math"]}
    monkeypatch.setattr(jit, "get_options", lambda: own)
    options = quick()["cffi_extra_compile_args"]
    assert options[-2:] == own["cffi_extra_compile_args"]
    assert "-fassociative-math" in options[:-2]
