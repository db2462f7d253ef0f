"""ParaView files: numbers in them against other ways to the same, and files of an export."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import BEAM, PLATE, Ended
from written_fields import Arrays, arrays_of, frames, hdf_frames, read_grid

from fenics_nnm.field_names import FIELDS
from fenics_nnm.fields.vtkhdf import in_hdf
from fenics_nnm.results.stored_branch import StoredBranch, read_stored_branch

Command = Callable[..., Ended]
StudyFile = Callable[..., Path]

VON_MISES = "von Mises stress (Pa)"
PRINCIPAL = [f"{which} principal stress (Pa)" for which in ("largest", "middle", "smallest")]

#: Without steady loads there is no displacement by them.
ALL_FIELDS = [name for name in FIELDS if name != "total_displacement"]


@pytest.fixture
def beam(study_file: StudyFile, command: Command, tmp_path: Path) -> Path:
    study = study_file(
        BEAM,
        mesh={"elements": [4, 2, 2]},
        contact={"direction": [0.0, 0.3, 1.0]},
        output={"fields": ALL_FIELDS},
    )
    assert command("run", study, "--output", "out").code == 0
    return tmp_path / "out"


def test_numbers_of_a_motion(beam: Path, command: Command) -> None:
    """One run, as it takes long: all that its files say of one motion."""
    branch = read_stored_branch(beam / "branch.h5")
    body = frames(beam / "fields" / "motion_1.1.pvd")
    contact = frames(beam / "fields" / "motion_1.1_contact.pvd")
    times = [time for time, _ in body]
    np.testing.assert_allclose(times, np.arange(24) / 24, atol=1e-12)
    assert [time for time, _ in contact] == times
    first = read_grid(beam / "fields" / "motion_1.1" / "frame_0000.vtu")
    assert set(first.celltypes) == {29}  # quadratic hexahedra stay what they are
    assert_velocity_is_the_derivative(branch, body)
    assert_principal_stresses_are_eigenvalues(body)
    assert_pressure_has_the_contact_force(branch, contact)
    assert_gap_is_the_distance(branch, contact)
    assert_peak_is_above_every_frame(beam / "fields" / "peak_stress_1.1.vtu", body)
    assert_shapes_are_closed_and_open(branch, beam / "fields" / "mode_shapes.vtu")
    again = ("--gamma", "1.1", "--fields", ",".join(ALL_FIELDS), "--format", "vtkhdf")
    assert command("export", "out", *again).code == 0
    assert_one_file_has_the_same(beam, body, contact)


def assert_one_file_has_the_same(out: Path, *listed: list[tuple[float, Arrays]]) -> None:
    """Of both formats, in VTK's own reader; single precision has seven digits."""
    again = out / "export"
    for name, expected in zip(("motion_1.1", "motion_1.1_contact"), listed, strict=True):
        found = hdf_frames(again / f"{name}.vtkhdf")
        assert [time for time, _ in found] == [time for time, _ in expected]
        for (_, one), (_, other) in zip(found, expected, strict=True):
            assert one.keys() == {in_hdf(field) for field in other}
            for field, values in other.items():
                scale = max(float(np.nanmax(np.abs(values))), 1e-300)
                np.testing.assert_allclose(one[in_hdf(field)], values, atol=1e-7 * scale, rtol=0)
    single = sum(file.stat().st_size for file in (out / "fields" / "motion_1.1").iterdir())
    assert (again / "motion_1.1.vtkhdf").stat().st_size < single / 3
    assert '"motion_1.1.vtkhdf"' in (again / "view.py").read_text()


def assert_velocity_is_the_derivative(
    branch: StoredBranch, body: list[tuple[float, Arrays]]
) -> None:
    point = branch.point(1.1)
    step = 1e-4
    for frame in (4, 9):  # away from the contact, where the velocity of massless points jumps
        phase = 2 * np.pi * body[frame][0] + np.array([-step, step])
        before, after = branch.displacement(point, phase)
        slope = (after - before) / (2 * step) * 2 * np.pi * point.motion.frequency
        velocity = body[frame][1]["velocity (m/s)"]
        np.testing.assert_allclose(velocity, slope, atol=1e-6 * np.abs(velocity).max())


def assert_principal_stresses_are_eigenvalues(body: list[tuple[float, Arrays]]) -> None:
    arrays = body[5][1]
    tensor = arrays["stress (Pa)"]
    xx, yy, zz, xy, yz, xz = tensor.T
    full = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    values = np.linalg.eigvalsh(full)
    found = np.array([arrays[name] for name in PRINCIPAL]).T
    np.testing.assert_allclose(found, values[:, ::-1], atol=1e-9 * np.abs(tensor).max())
    deviator = full - np.eye(3) * np.trace(full, axis1=1, axis2=2)[:, None, None] / 3
    mises = np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2)))
    np.testing.assert_allclose(arrays[VON_MISES], mises, rtol=1e-9)


def assert_pressure_has_the_contact_force(
    branch: StoredBranch, contact: list[tuple[float, Arrays]]
) -> None:
    """Each facet is a rectangle with a bilinear pressure: area times the mean of its corners."""
    grid = branch.contact_facets
    nodes = np.unique(grid)
    corners = np.searchsorted(nodes, grid)[:, :4]
    force = branch.forces(branch.point(1.1), 2 * np.pi * np.array([t for t, _ in contact]))
    assert force.max() > 0
    for (_, arrays), forces in zip(contact, force, strict=True):
        a, b, _, d = (arrays["Points"][corners[:, i]] for i in range(4))
        area = np.linalg.norm(np.cross(b - a, d - a), axis=1)
        assert area.sum() == pytest.approx(0.15 * 0.1, rel=1e-12)
        pressure = arrays["contact pressure (Pa)"]
        total = float(area @ pressure[corners].mean(axis=1))
        assert total == pytest.approx(forces.sum(), rel=1e-10, abs=1e-10 * force.max())
        middle = pressure[np.searchsorted(nodes, grid)[:, 4]]
        np.testing.assert_allclose(middle, pressure[corners[:, :2]].mean(axis=1))


def assert_gap_is_the_distance(branch: StoredBranch, contact: list[tuple[float, Arrays]]) -> None:
    towards = np.array([0.0, 0.3, 1.0]) / np.hypot(0.3, 1.0)
    nodes = np.unique(branch.contact_facets)
    vertices = np.searchsorted(nodes, branch.contact_nodes)
    for _, arrays in contact:
        distance = 1e-3 - arrays["displacement (m)"][vertices] @ towards
        np.testing.assert_allclose(arrays["gap (m)"][vertices], distance, atol=1e-12)


def assert_peak_is_above_every_frame(file: Path, body: list[tuple[float, Arrays]]) -> None:
    peak = arrays_of(file)
    mises = np.array([arrays[VON_MISES] for _, arrays in body])
    tension = np.array([arrays[PRINCIPAL[0]] for _, arrays in body])
    less = 1e-12 * mises.max()  # round-off of products of other sizes
    assert np.all(peak["peak von Mises stress (Pa)"] >= mises.max(axis=0) - less)
    assert np.all(peak["peak largest principal stress (Pa)"] >= tension.max(axis=0) - less)
    when = peak["phase of peak von Mises stress (periods)"]
    assert np.all((when >= 0) & (when < 1))
    linear = peak["peak von Mises stress of the linear mode at this energy (Pa)"]
    above = peak["peak von Mises stress above that of the linear mode (Pa)"]
    np.testing.assert_allclose(above, peak["peak von Mises stress (Pa)"] - linear, atol=1e-3)
    # bending moves towards the clamp: same order of size, and more than none where it touches
    assert 0.5 < linear.max() / peak["peak von Mises stress (Pa)"].max() < 1.5
    assert above.max() > 0.05 * linear.max()


def assert_shapes_are_closed_and_open(branch: StoredBranch, file: Path) -> None:
    arrays = arrays_of(file)
    assert set(arrays) == {
        "Points",
        "gamma 1.1 closed: displacement (m)",
        "gamma 1.1 open: displacement (m)",
    }
    towards = np.array([0.0, 0.3, 1.0]) / np.hypot(0.3, 1.0)
    nodes = branch.contact_nodes
    closed = arrays["gamma 1.1 closed: displacement (m)"][nodes] @ towards
    opened = arrays["gamma 1.1 open: displacement (m)"][nodes] @ towards
    assert closed.max() == pytest.approx(1e-3, rel=1e-6)
    assert opened.max() < -1e-3


def test_export_gives_the_files_of_the_run(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(PLATE, continuation={"report_at": [1.0, 1.1]})
    assert command("run", study, "--output", "out").code == 0
    study.unlink()
    ended = command("export", "out/branch.h5", "--gamma", "1.0", "1.12", "--output", "again")
    assert ended.code == 0, ended.err
    assert "gamma ratio 1:" in ended.out and "gamma ratio 1.1:" in ended.out
    assert "asked for 1.12, which is not computed: the nearest computed is 1.1\n" in ended.out
    assert "asked for 1," not in ended.out
    run, again = tmp_path / "out" / "fields", tmp_path / "again"
    names = {p.relative_to(again) for p in again.rglob("*") if p.is_file()}
    assert {p.relative_to(run) for p in run.rglob("*") if p.is_file()} - names == {
        Path("linear_modes.vtu")
    }
    assert all((run / name).read_bytes() == (again / name).read_bytes() for name in names)
    far = command("export", "out", "--gamma", "1.0", "5", "--output", "far")
    assert far.code == 1
    assert far.out.splitlines()[-1] == ("--gamma 5: no such point, the nearest has gamma ratio 1.1")


def test_export_of_chosen_fields_and_frames(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    assert command("run", study_file(PLATE), "--output", "out").code == 0
    chosen = ("--fields", "von_mises", "--frames", "30")
    assert command("export", "out", "--gamma", "1.0", *chosen).code == 0
    period = frames(tmp_path / "out" / "export" / "motion_1.pvd")
    assert len(period) == 30
    assert set(period[0][1]) == {"Points", VON_MISES}
    names = {path.name for path in (tmp_path / "out" / "export").iterdir()}
    assert names == {"motion_1", "motion_1.pvd", "mode_shapes.vtu"}
    ended = command("export", "out", "--gamma", "1.0")
    ended.assert_one_line(1, "out/export: is there already", "--output")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("out", "--gamma", "1.1", "--fields", "heat"), 2, ("--fields heat", "von_mises")),
        (("out", "--gamma", "nan"), 2, ("--gamma nan", "must be a number")),
        (("out", "--gamma", "1.1", "--frames", "3"), 2, ("--frames 3", "at least 24")),
        (("out", "--gamma", "1.1", "--frames", "100000"), 2, ("--frames 100000", "10000 at most")),
        (("out", "--amplitude", "1e-3"), 2, ("--amplitude 1e-3", "must be a number with a unit")),
        (("nowhere.h5", "--gamma", "1.1"), 1, ("nowhere.h5: cannot be read",)),
    ],
)
def test_export_refuses(
    arguments: tuple[str, ...], code: int, words: tuple[str, ...], command: Command
) -> None:
    command("export", *arguments).assert_one_line(code, *words)


def test_full_order_keeps_the_whole_motion_of_reported_points_alone(
    study_file: StudyFile, command: Command, tmp_path: Path
) -> None:
    study = study_file(PLATE, reduction={"method": "none", "modes": 4})
    assert command("run", study, "--output", "out").code == 0
    with h5py.File(tmp_path / "out" / "branch.h5") as file:
        (inertia,) = file["inertia"].values()
        assert inertia.shape[0] == 4 and np.abs(inertia[:]).max() > 0
    assert command("export", "out", "--gamma", "1.1", "--output", "whole").code == 0
    for name in ("motion_1.1/frame_0002.vtu", "motion_1.1_contact/frame_0000.vtu"):
        run, export = tmp_path / "out" / "fields" / name, tmp_path / "whole" / name
        assert run.read_bytes() == export.read_bytes()
    arrays = arrays_of(tmp_path / "out" / "fields" / "motion_1.1_contact" / "frame_0001.vtu")
    branch = read_stored_branch(tmp_path / "out" / "branch.h5")
    vertices = np.searchsorted(np.unique(branch.contact_facets), branch.contact_nodes)
    distance = 1e-3 - arrays["displacement (m)"][vertices, 1]
    np.testing.assert_allclose(arrays["gap (m)"][vertices], distance, atol=1e-9 * 1e-3)
    ended = command("export", "out", "--gamma", "0.9")
    ended.assert_one_line(1, "gamma ratio 0.9: at full order", "report_at are kept whole: 1.1")


def test_rod_has_its_axial_stress(study_file: StudyFile, command: Command, tmp_path: Path) -> None:
    ended = command("run", study_file(), "--output", "out")
    assert ended.code == 0, ended.err
    branch = read_stored_branch(tmp_path / "out" / "branch.h5")
    phase = np.array([2 * np.pi * 5 / 24])
    (displacement,) = branch.displacement(branch.point(1.1), phase)
    x, u = branch.nodes[:, 0], displacement[:, 0]
    order = np.argsort(x)
    strain = np.diff(u[order]) / np.diff(x[order])
    inner = (strain[1:] + strain[:-1]) / 2
    _, arrays = frames(tmp_path / "out" / "fields" / "motion_1.1.pvd")[5]
    np.testing.assert_allclose(arrays[VON_MISES][order][1:-1], 2.1e11 * np.abs(inner), rtol=1e-6)
    pressure = frames(tmp_path / "out" / "fields" / "motion_1.1_contact.pvd")[0][1]
    force = branch.forces(branch.point(1.1), np.zeros(1))
    assert pressure["contact pressure (Pa)"] == pytest.approx(force[0] / 9e-4)
