"""What vtk.js is told to draw: the state of a scene as its pages for scenes in a file read it.

Such a file is a ZIP archive with index.json: the objects of a scene within each other, with their
properties and what to call of them, and arrays by their names. The format is that of the module
`trame_vtk.modules.vtk.serializers` of trame-vtk.
"""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from numpy.typing import NDArray

from fenics_nnm.arrays import Array, Indices

Numbers = NDArray[Any]
"""Numbers of any type."""

_State = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the scene, as it is at first: the script moves and colours it.

    Attributes:
        places: Places of its nodes, shape (p, 3).
        cells: Nodes of its faces, lines or points, shape (c, k).
        kind: What the cells are: "polys", "lines" or "verts".
        look: Properties of vtk.js.
        coloured: Whether its nodes have colours of their own.
    """

    places: Array
    cells: Indices
    kind: str
    look: dict[str, Any] = field(default_factory=dict)
    coloured: bool = False


def scene_file(parts: Sequence[Part]) -> bytes:
    """The file of a scene; actors are in the order of the parts."""
    arrays: dict[str, Numbers] = {}
    actors = [_actor(f"part{number}", part, arrays) for number, part in enumerate(parts)]
    calls = [["addViewProp", [_instance(actor)]] for actor in actors]
    renderer = _object("renderer", "vtkRenderer", {"background": [1, 1, 1]}, actors, calls)
    window = _object(
        "window", "vtkRenderWindow", {}, [renderer], [["addRenderer", [_instance(renderer)]]]
    )
    hashes = {name: {"content": _encoded(array)} for name, array in arrays.items()}
    written = BytesIO()
    with ZipFile(written, "w", ZIP_DEFLATED) as file:
        file.writestr("index.json", json.dumps({"scene": window, "hashes": hashes}))
    return written.getvalue()


def _actor(name: str, part: Part, arrays: dict[str, Numbers]) -> _State:
    cells = np.hstack([np.full((len(part.cells), 1), part.cells.shape[1]), part.cells])
    properties: _State = {
        "points": _array(f"{name}-points", part.places.astype("<f4"), "vtkPoints", arrays),
        part.kind: _array(f"{name}-cells", cells.ravel().astype("<u4"), "vtkCellArray", arrays),
        "fields": [],
    }
    if part.coloured:
        grey = np.full(part.places.shape, 200, np.uint8)
        colours = _array(f"{name}-colours", grey, "vtkDataArray", arrays)
        properties["fields"] = [{**colours, "location": "pointData", "registration": "setScalars"}]
    data = _object(f"{name}-data", "vtkPolyData", properties)
    shown = {"scalarVisibility": part.coloured, "colorMode": 0, "scalarMode": 1}
    mapper = _object(
        f"{name}-mapper", "vtkMapper", shown, [data], [["setInputData", [_instance(data)]]]
    )
    look = _object(f"{name}-look", "vtkProperty", part.look)
    calls = [["setMapper", [_instance(mapper)]], ["setProperty", [_instance(look)]]]
    return _object(name, "vtkActor", {}, [mapper, look], calls)


def _object(
    name: str,
    kind: str,
    properties: _State,
    parts: Sequence[_State] = (),
    calls: Sequence[Any] = (),
) -> _State:
    """An object with those that it is made of."""
    for part in parts:
        part["parent"] = name
    return {
        "parent": "0x0",
        "id": name,
        "type": kind,
        "mtime": 1,
        "properties": properties,
        "dependencies": list(parts),
        "calls": list(calls),
    }


def _instance(state: _State) -> str:
    return f"instance:${{{state['id']}}}"


#: Types of arrays in JavaScript.
_TYPES = {"<f4": "Float32Array", "<u4": "Uint32Array", "|u1": "Uint8Array"}


def _array(name: str, values: Numbers, kind: str, arrays: dict[str, Numbers]) -> _State:
    """An array, whose values are kept apart."""
    arrays[name] = values
    components = values.shape[1] if values.ndim == 2 else 1
    return {
        "hash": name,
        "vtkClass": kind,
        "name": name,
        "dataType": _TYPES[values.dtype.str],
        "numberOfComponents": components,
        "size": values.size,
    }


def _encoded(array: Numbers) -> str:
    return b64encode(np.ascontiguousarray(array).tobytes()).decode()
