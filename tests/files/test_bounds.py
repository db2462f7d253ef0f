"""Files whose heads say more than they have, or that lead to other files."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy import sparse
from scipy.io import savemat

from fenics_nnm.errors import ModelError
from fenics_nnm.structure.matrix_files import read_matrix


def refused(path: Path) -> str:
    with pytest.raises(ModelError) as error:
        read_matrix(path)
    message = str(error.value)
    assert message.startswith(f"{path}: ") and "\n" not in message
    return message


def head_of_array(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        file, {"descr": kind, "fortran_order": False, "shape": shape}
    )
    return file.getvalue()


def test_a_head_without_its_numbers(tmp_path: Path) -> None:
    path = tmp_path / "K.npy"
    path.write_bytes(head_of_array((10**6, 10**6)) + b"few")
    assert "fewer bytes than its shape" in refused(path)


def test_an_archive_that_unpacks_to_more_than_there_is(tmp_path: Path) -> None:
    """Its directory claims 2^50 bytes."""
    path = tmp_path / "K.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", head_of_array((2**47,)) + bytes(1000))
        archive.infolist()[0].file_size = 2**50
    assert "GiB" in refused(path)


def test_objects_of_python_are_not_made(tmp_path: Path) -> None:
    done = tmp_path / "done"

    class Runs:
        def __reduce__(self) -> Any:
            return Path.touch, (done,)

    for name, save in (("K.npy", np.save), ("K.npz", np.savez)):
        save(tmp_path / name, np.array([Runs()], dtype=object), allow_pickle=True)
        refused(tmp_path / name)
    assert not done.exists()


@pytest.mark.parametrize("kind", ["csr", "csc", "coo"])
def test_indices_outside_of_the_matrix(kind: str, tmp_path: Path) -> None:
    matrix = sparse.eye(4, format=kind)
    if kind == "coo":
        matrix.row[2] = 10**6
    else:
        matrix.indices[2] = 10**6
    sparse.save_npz(tmp_path / "K.npz", matrix)
    refused(tmp_path / "K.npz")


def test_sizes_of_matrix_market(tmp_path: Path) -> None:
    path = tmp_path / "K.mtx"
    head = "%%MatrixMarket matrix coordinate real general\n"
    path.write_text(head + "4 4 1000000000000\n1 1 1\n")
    assert "names 1000000000000 entries" in refused(path)
    path.write_text(head + "1000000000000 4 1\n1 1 1\n")
    assert "has the shape (1000000000000, 4)" in refused(path)


def test_hdf5_that_leads_to_other_files(tmp_path: Path) -> None:
    other, path = tmp_path / "other.h5", tmp_path / "K.mat"
    with h5py.File(other, "w") as file:
        file["K"] = np.eye(3)
    with h5py.File(path, "w") as file:
        file["K"] = h5py.ExternalLink(str(other), "/K")
    assert f"/K is a link to the file {other}" in refused(path)
    with h5py.File(path, "w") as file:
        layout = h5py.VirtualLayout(shape=(3, 3), dtype="f8")
        layout[:] = h5py.VirtualSource(str(other), "K", shape=(3, 3))
        file.create_virtual_dataset("K", layout)
    assert "/K has its values in other files" in refused(path)
    with h5py.File(path, "w") as file:
        file.create_dataset("K", (3, 3), "f8", external=[(str(other), 0, 72)])
    assert "/K has its values in other files" in refused(path)
    with h5py.File(path, "w") as file:
        file.create_dataset("K", (10**7, 10**7), "f8", chunks=(1000, 1000))
    assert "GiB" in refused(path)


def test_matlab_matrices_of_too_many_rows(tmp_path: Path) -> None:
    path = tmp_path / "K.mat"
    savemat(path, {"K": np.eye(3)})
    np.testing.assert_array_equal(read_matrix(path), np.eye(3))
    path.write_bytes(path.read_bytes()[:150])
    refused(path)
