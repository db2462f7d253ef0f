"""Mass spread over the top of a square on the ranks that run this; rank 0 writes it to a file."""

import json
import sys
from pathlib import Path

import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI

from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.mesh import TaggedMesh
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body, assemble_solid
from fenics_nnm.materials.elasticity import Isotropic
from fenics_nnm.materials.material import Material

comm = MPI.COMM_WORLD
mesh = dmesh.create_unit_square(comm, 6, 6, dmesh.CellType.quadrilateral)
mesh.topology.create_connectivity(1, 2)
left, top = (
    dmesh.locate_entities_boundary(mesh, 1, lambda x, axis=axis, at=at: np.isclose(x[axis], at))
    for axis, at in ((0, 0.0), (1, 1.0))
)
spread = Attachment("[[mass]] 1", "mass", (100.0, 300.0), facets=("top",))
material = Material(Isotropic(2e11, 0.3), 7800.0)
body = Body("plane-strain", (Region(material),), attachments=(spread,))
solid = assemble_solid(TaggedMesh(mesh, {"top": top}, {}), body, left)
moved = solid.mass.createVecRight()
moved.array[0::2], moved.array[1::2] = 1.0, 2.0
found = moved.dot(solid.mass * moved)
if comm.rank == 0:
    Path(sys.argv[1]).write_text(json.dumps(found))
