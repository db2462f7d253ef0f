"""Studies of matrices: the same results as from the mesh that the matrices are of."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from conftest import BEAM, PLATE, ROD, Ended, changed
from mpi4py import MPI
from ranks import on_ranks, own_lines
from scipy import sparse
from scipy.io import mmwrite, savemat

from fenics_nnm.errors import ModelError
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.results import branch_file
from fenics_nnm.structure.analysis import linear_analysis
from fenics_nnm.structure.matrix_files import read_matrix
from fenics_nnm.study import study_from

StudyFile = Callable[..., Path]
Command = Callable[..., Ended]
Triple = tuple[Any, Any, Any]

CRAIG_BAMPTON = {"method": "craig-bampton", "interface": "contact"}
OF_A_MESH = {"mesh": None, "body": None, "material": None, "clamp": None}
FILES = {"stiffness": "K.mtx", "mass": "M.mtx", "contact_rows": "B.npy"}


def matrices_of(base: dict[str, Any]) -> tuple[LinearAnalysis, Triple]:
    """Stiffness, mass and contact rows of the unknowns of a mesh that are not clamped."""
    analysis = linear_analysis(study_from(dict(base), Path("study.toml")), MPI.COMM_SELF)
    assert isinstance(analysis, LinearAnalysis)
    solid = analysis.solid
    free = np.setdiff1d(np.arange(solid.owned), solid.clamped)
    K, M = _scipy(solid.stiffness), _scipy(solid.mass)
    B = analysis.interface.unit_forces(solid.owned).T
    return analysis, (K[free][:, free], M[free][:, free], B[:, free])


def _scipy(matrix: Any) -> sparse.csr_matrix:
    rows, columns, values = matrix.getValuesCSR()
    return sparse.csr_matrix((values, columns, rows), shape=matrix.getSize())


def save_three(folder: Path, matrices: Triple) -> dict[str, str]:
    """Matrix Market files, one of them of a lower triangle, and an array."""
    K, M, B = matrices
    mmwrite(folder / "K.mtx", K, symmetry="symmetric", precision=17)
    mmwrite(folder / "M.mtx", M, symmetry="general", precision=17)
    np.save(folder / "B.npy", B)
    return FILES


def save_sparse_npz(folder: Path, matrices: Triple) -> dict[str, str]:
    for name, matrix in zip("KMB", matrices, strict=True):
        sparse.save_npz(folder / f"{name}.npz", sparse.csr_matrix(matrix))
    return {"stiffness": "K.npz", "mass": "M.npz", "contact_rows": "B.npz"}


def save_npz(folder: Path, matrices: Triple) -> dict[str, str]:
    K, M, B = matrices
    np.savez(folder / "model.npz", K=K.toarray(), M=M.toarray(), B=B)
    return {"file": "model.npz"}


def save_mat(folder: Path, matrices: Triple) -> dict[str, str]:
    K, M, B = matrices
    savemat(folder / "model.mat", {"Kff": K, "Mff": M, "B": B, "remark": "from elsewhere"})
    return {"file": "model.mat", "stiffness": "Kff", "mass": "Mff"}


def save_mat73(folder: Path, matrices: Triple) -> dict[str, str]:
    """As MATLAB's `save -v7.3` does: 512 bytes of its own, then HDF5."""
    K, M, B = matrices
    with h5py.File(folder / "model.mat", "w", userblock_size=512) as file:
        for name, matrix in (("K", K), ("M", M)):
            columns = sparse.csc_matrix(matrix)
            group = file.create_group(name)
            group.attrs["MATLAB_class"] = np.bytes_("double")
            group.attrs["MATLAB_sparse"] = np.uint64(columns.shape[0])
            group["data"] = columns.data
            group["ir"] = columns.indices.astype(np.uint64)
            group["jc"] = columns.indptr.astype(np.uint64)
        file["B"] = np.asarray(B).T
        file.create_group("#refs#")
    with (folder / "model.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    return {"file": "model.mat"}


SAVERS = [save_three, save_sparse_npz, save_npz, save_mat, save_mat73]


@pytest.fixture
def matrix_study(study_file: StudyFile, tmp_path: Path) -> Callable[..., Path]:
    """A function that writes the matrices of a mesh study, and the study of these."""

    def write(base: dict[str, Any], save: Any = save_three, **changes: Any) -> Path:
        section = save(tmp_path, matrices_of(base)[1])
        contact = {"=": {"gap": base["contact"]["gap"]}}
        given = {**OF_A_MESH, "matrices": section, "contact": contact, **changes}
        return study_file(base, name="matrices.toml", **given)

    return write


@pytest.fixture
def rod_study(study_file: StudyFile, tmp_path: Path) -> Callable[..., Path]:
    """A function that writes a study of a small rod's matrices with some keys changed."""
    section = save_three(tmp_path, matrices_of(ROD)[1])
    base = changed(ROD, {**OF_A_MESH, "matrices": section, "contact": {"=": {"gap": 1e-3}}})
    return lambda **changes: study_file(base, **changes)


def backbone(folder: Path) -> list[dict[str, str]]:
    with (folder / "backbone.csv").open() as file:
        return list(csv.DictReader(file))


def assert_same_backbone(one: Path, other: Path, tolerance: float) -> None:
    rows, others = backbone(one), backbone(other)
    assert [row["status"] for row in rows] == [row["status"] for row in others]
    for column in ("gamma_ratio", "frequency_Hz", "frequency_ratio", "energy_J"):
        values, expected = ([float(r[column]) for r in table] for table in (rows, others))
        np.testing.assert_allclose(values, expected, rtol=tolerance, err_msg=column)


#: A rod of which the frequencies, odd multiples of the first, are known.
FINE_ROD = changed(
    ROD,
    {
        "mesh": {"elements": 100},
        "body": {"degree": 2},
        "reduction": {"modes": 6},
        "mode": {"harmonics": 6, "samples": 64},
        "continuation": {"energies": {"to": 1.6, "step": 0.2}, "report_at": [1.3]},
    },
)


@pytest.mark.parametrize(
    ("base", "reduction", "tolerance"),
    [
        (FINE_ROD, {}, 1e-8),
        (FINE_ROD, CRAIG_BAMPTON, 1e-8),
        (PLATE, {}, 1e-8),
        (PLATE, CRAIG_BAMPTON, 1e-8),
        (BEAM, {"modes": 3}, 1e-8),
    ],
    ids=["rod", "rod-craig-bampton", "plate", "plate-craig-bampton", "beam"],
)
def test_matrices_of_a_mesh_give_its_backbone(
    base: dict[str, Any],
    reduction: dict[str, Any],
    tolerance: float,
    matrix_study: StudyFile,
    study_file: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    base = changed(base, {"reduction": reduction})
    for name, study in (("mesh", study_file(base)), ("matrices", matrix_study(base))):
        ended = command("run", study, "--output", name)
        assert ended.code == 0, ended.err
    assert_same_backbone(tmp_path / "matrices", tmp_path / "mesh", tolerance)
    assert len(backbone(tmp_path / "mesh")) >= 4
    assert float(backbone(tmp_path / "mesh")[-1]["frequency_ratio"]) > 1.001
    names = {path.name for path in (tmp_path / "matrices").iterdir()}
    assert names == {"backbone.csv", "backbone.png", "branch.h5", "summary.json"}


def test_summary_of_a_rod(rod_study: StudyFile, matrix_study: StudyFile, command: Command) -> None:
    assert command("run", matrix_study(FINE_ROD), "--output", "out").code == 0
    summary = json.loads(Path("out/summary.json").read_text())
    first = np.sqrt(2.1e11 / 7800) / 4
    exact = first * np.arange(1, 13, 2)
    np.testing.assert_allclose(summary["linear_frequencies_Hz"], exact, rtol=1e-6)
    assert (summary["dofs"], summary["contact_points"]) == (200, 1)
    assert summary["no_mode_missed_below_Hz"] == pytest.approx(first * 12, rel=0.02)
    # at grazing the tip moves by the gap: E = m (omega g)^2 / 4
    energy = 7800 * 9e-4 * (2 * np.pi * first * 1e-3) ** 2 / 4
    assert summary["grazing_energy_J"] == pytest.approx(energy, rel=1e-6)
    assert "contact_area_m2" not in summary
    assert set(summary["timings"]) == {
        "matrices",
        "modes",
        "attachments",
        "backbone",
        "stress",
        "output",
    }


@pytest.mark.parametrize("save", SAVERS[1:], ids=lambda save: save.__name__)
def test_all_files_give_the_same(
    save: Any, matrix_study: StudyFile, command: Command, tmp_path: Path
) -> None:
    for name, chosen in (("three", save_three), ("other", save)):
        assert command("run", matrix_study(PLATE, chosen), "--output", name).code == 0
    assert_same_backbone(tmp_path / "other", tmp_path / "three", 1e-10)


def test_a_gap_for_each_row(matrix_study: StudyFile, command: Command, tmp_path: Path) -> None:
    for name, gap in (("one", 1e-3), ("list", [1e-3, 1e-3]), ("wide", [1e-3, 5e-3])):
        study = matrix_study(PLATE, contact={"=": {"gap": gap}})
        assert command("run", study, "--output", name).code == 0
    assert_same_backbone(tmp_path / "list", tmp_path / "one", 1e-10)
    last = [float(backbone(tmp_path / name)[-1]["frequency_ratio"]) for name in ("one", "wide")]
    assert 1.001 < last[1] < last[0]


def test_check_describes_matrices(matrix_study: StudyFile, command: Command) -> None:
    ended = command("check", matrix_study(PLATE, contact={"=": {"gap": [1e-3, 2e-3]}}))
    assert ended.code == 0, ended.err
    assert "matrices         48 unknowns, 0 without mass" in ended.out
    assert "contact          2 rows, gap 0.001 to 0.002 m" in ended.out
    assert "first at contact row 1" in ended.out
    on_mesh = command("check", matrix_study(PLATE).with_name("matrices.toml"))
    assert "no mode missed below" in on_mesh.out


SNIPPET = re.compile(r"```python\n(# displacement.*?)```", re.DOTALL)


def test_displacements_by_the_snippet_of_the_docs(
    matrix_study: StudyFile, study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    """Contact points reach the obstacle and no further; and the mesh moves in the same way."""
    (snippet,) = SNIPPET.findall((Path(__file__).parents[2] / "docs/results.md").read_text())
    analysis, (_, _, B) = matrices_of(PLATE)
    free = np.setdiff1d(np.arange(analysis.solid.owned), analysis.solid.clamped)
    for reduction in ({}, CRAIG_BAMPTON):
        base = changed(PLATE, {"reduction": reduction})
        study = matrix_study(base)
        assert command("run", study, "--output", "results/blade").code == 0
        found: dict[str, Any] = {}
        exec(snippet.replace("1.5", "1.1"), found)
        u, time = found["u"], found["time"]
        assert u.shape == (len(free), len(time))
        reached = (B @ u).max(axis=1)
        assert reached.max() == pytest.approx(1e-3, rel=1e-6)
        _, points = branch_file.read(tmp_path / "results/blade/branch.h5")
        assert time[1] * len(time) == pytest.approx(1 / points[-1].motion.frequency)
        on_mesh = linear_analysis(study_from(base, Path("study.toml")), MPI.COMM_SELF)
        start = on_mesh.reduction.displacement(
            points[-1].motion.q.sum(axis=0), points[-1].motion.force[0]
        )
        np.testing.assert_allclose(u[:, 0], start[free], atol=1e-6 * np.abs(u).max())


def test_two_ranks_give_the_backbone_of_one(
    matrix_study: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = matrix_study(PLATE)
    assert command("run", study, "--output", "one").code == 0
    ended = on_ranks(2, "-m", "fenics_nnm", "run", study, "--output", "two", folder=tmp_path)
    assert ended.code == 0, ended.err
    assert ended.out.count("results in two") == 1  # of all ranks the first one prints
    assert len(own_lines(ended)) <= 1  # a warning is told once
    assert_same_backbone(tmp_path / "two", tmp_path / "one", 1e-12)


def test_bad_matrices_are_told_once_on_two_ranks(rod_study: StudyFile, tmp_path: Path) -> None:
    study = rod_study(matrices={"mass": "none.mtx"})
    ended = on_ranks(2, "-m", "fenics_nnm", "run", study, folder=tmp_path)
    (line,) = own_lines(ended)
    assert ended.code == 2 and "none.mtx: cannot be read as a matrix: No such file" in line


def section(**keys: Any) -> dict[str, Any]:
    return {"matrices": {"=": keys}}


WRONG = [
    ({"mesh": ROD["mesh"]}, "mesh: does not go with [matrices]", "whole structure"),
    ({"body": ROD["body"]}, "body: does not go with [matrices]", "whole structure"),
    ({"material": {"young": 1.0}}, "material: does not go with [matrices]", "whole structure"),
    ({"clamp": {"facets": "left"}}, "clamp: does not go with [matrices]", "held by its clamp"),
    ({"contact": {"facets": "x"}}, "contact.facets: belongs to [mesh]", "contact row"),
    ({"contact": {"direction": "normal"}}, "contact.direction: belongs", "with its direction"),
    ({"contact": {"points": 2}}, "contact.points: belongs to [mesh]", "contact row"),
    ({"contact": {"axis": "x"}}, "contact.axis: belongs to [mesh]", "contact row"),
    ({"contact": {"origin": [0.0]}}, "contact.origin: belongs to [mesh]", "contact row"),
    ({"contact": {"gap": None}}, "contact.gap: is missing", "initial gap in m"),
    ({"contact": {"gap": "a"}}, 'contact.gap = "a"', "interference: one number, or a list"),
    (
        {"contact": {"gap": 0.0}},
        "contact.reference_displacement: is missing",
        "displacement in m of these points at gamma ratio 1",
    ),
    (
        {"contact": {"gap": -1.0, "reference_displacement": 1.0}},
        "contact.reference_displacement = 1: has no effect",
        "touches without force at rest",
    ),
    (
        {"contact": {"gap": 0.0, "reference_displacement": 0.0}},
        "contact.reference_displacement = 0.0",
        "positive",
    ),
    (
        {"contact": {"gap": -1e-3}, "reduction": {"method": "craig-bampton"}},
        "contact.gap = -0.001: must be positive where contact points carry mass",
        'reduction.method = "massless"',
    ),
    ({"contact": {"gap": []}}, "contact.gap = []", "a list with one a contact row"),
    ({"contact": {"gap": [1.0, 2.0]}}, "contact.gap has 2 values", "each of the 1 contact rows"),
    ({"contact": {"gpa": 1.0}}, "contact.gpa: unknown key", 'did you mean "gap"?'),
    ({"output": {"frames": 30}}, "output.frames: belongs to [mesh]", "no ParaView files"),
    (
        {"reduction": {"method": "none"}},
        'reduction.method = "none"',
        'must be "massless" or "craig-bampton"',
    ),
    (
        {"reduction": {"method": "craig-bampton", "interface": "all"}},
        'reduction.interface = "all"',
        '"contact"',
    ),
    ({"reduction": {"interface": "contact"}}, "reduction.interface", "craig-bampton"),
    ({"reduction": {"modes": 9}}, "reduction.modes = 9", "not above 4"),
    ({"contact": {"law": "augmented-lagrangian"}}, "contact.law", "craig-bampton"),
    ({"matrices": {"=": 3}}, "matrices = 3", "must be a section"),
    (section(), "matrices.stiffness: is missing", ".mtx"),
    (section(file="K.mtx"), "matrices.file = ", "must be a .npz or .mat file"),
    (section(file=3), "matrices.file = 3", "name in quotes"),
    (section(file="a.npz", stifness="K"), "matrices.stifness: unknown", '"stiffness"'),
    (section(file="a.npz", mass=""), 'matrices.mass = ""', "name of the mass"),
    (section(file="a.npz"), "a.npz: cannot be read as a matrix", "No such file"),
    (section(file="wide.npz"), 'has no matrix "B"', "it has K, M, notes"),
    (section(file="wide.npz", contact_rows="notes"), '"notes" is not an array', "savemat"),
    (section(file="K.npz"), "holds one sparse matrix", "a file for each matrix"),
    (section(file="bad.npz"), "bad.npz: cannot be read as a matrix", ""),
    (section(file="bad.mat"), "bad.mat: cannot be read as a matrix", ""),
    ({"matrices": {"mass": "wide.npz"}}, "wide.npz: has several matrices", "K, M, notes"),
    ({"matrices": {"mass": "M.txt"}}, "M.txt: must be a .mtx", ".mat file"),
    ({"matrices": {"mass": "bad.mtx"}}, "bad.mtx: cannot be read as a matrix", ""),
    ({"matrices": {"mass": "B.npy"}}, "mass M has shape (1, 4)", "must be (4, 4)"),
    ({"matrices": None, "matrics": FILES}, "matrics: unknown key", 'did you mean "matrices"?'),
    ({"matrices": None}, "mesh: is missing", "[matrices]"),
]


@pytest.mark.parametrize(("changes", "named", "right"), WRONG)
@pytest.mark.parametrize("action", ["run", "check"])
def test_wrong_study_of_matrices(
    action: str,
    changes: dict[str, Any],
    named: str,
    right: str,
    rod_study: StudyFile,
    command: Command,
    tmp_path: Path,
) -> None:
    notes = np.array([{"a": 1}])
    np.savez(tmp_path / "wide.npz", K=np.eye(4), M=np.eye(4), notes=notes)
    sparse.save_npz(tmp_path / "K.npz", sparse.eye(4).tocsc())
    for name in ("bad.npz", "bad.mat", "bad.mtx"):
        (tmp_path / name).write_bytes(bytes(range(256)))
    before = {path.name for path in tmp_path.iterdir()}
    command(action, rod_study(**changes)).assert_one_line(2, named, right)
    assert {path.name for path in tmp_path.iterdir()} == {*before, "study.toml"}


def test_mesh_takes_no_list_of_gaps(study_file: StudyFile, command: Command) -> None:
    ended = command("check", study_file(contact={"gap": [1e-3]}))
    ended.assert_one_line(2, "contact.gap = [0.001]: must be one number in m", "[matrices]")
    command("check", study_file(contact={"facets": None})).assert_one_line(2, "contact.facets")


def test_files_are_sought_beside_the_study(
    rod_study: StudyFile, command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = rod_study()
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert command("check", study).code == 0


def test_files_hold_the_matrix_that_was_saved(tmp_path: Path) -> None:
    K, M, B = matrices_of(ROD)[1]
    for save in SAVERS:
        places = study_from(
            {"matrices": save(tmp_path, (K, M, B)), "contact": {"gap": 1.0}},
            tmp_path / "study.toml",
        ).matrices.places
        for (path, name), expected in zip(places, (K.toarray(), M.toarray(), B), strict=True):
            found = read_matrix(path, name)
            found = found.toarray() if sparse.issparse(found) else found
            np.testing.assert_array_equal(found, expected)


def test_missing_matrix_is_named(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"K": np.eye(2)})
    np.testing.assert_array_equal(read_matrix(tmp_path / "a.mat"), np.eye(2))
    with pytest.raises(ModelError, match=r'a\.mat: has no matrix "C"; it has K'):
        read_matrix(tmp_path / "a.mat", "C")
