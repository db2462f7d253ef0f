"""Types of the names of the face, which `__init__.py` imports when they are first used."""

from fenics_nnm.errors import ConvergenceError as ConvergenceError
from fenics_nnm.errors import GeometryError as GeometryError
from fenics_nnm.errors import MeshError as MeshError
from fenics_nnm.errors import ModelError as ModelError
from fenics_nnm.errors import NonlinearModeError as NonlinearModeError
from fenics_nnm.errors import OutputError as OutputError
from fenics_nnm.errors import StudyError as StudyError
from fenics_nnm.face.branch import Branch as Branch
from fenics_nnm.face.branch import load_branch as load_branch
from fenics_nnm.face.check import Check as Check
from fenics_nnm.face.diagrams import Campbell as Campbell
from fenics_nnm.face.diagrams import Sweep as Sweep
from fenics_nnm.face.diagrams import load_campbell as load_campbell
from fenics_nnm.face.diagrams import load_sweep as load_sweep
from fenics_nnm.face.histories import ContactHistory as ContactHistory
from fenics_nnm.face.histories import MotionHistory as MotionHistory
from fenics_nnm.face.histories import UnknownsHistory as UnknownsHistory
from fenics_nnm.face.point import Point as Point
from fenics_nnm.face.response import Response as Response
from fenics_nnm.face.response import load_response as load_response
from fenics_nnm.face.response_curve import ResponseCurve as ResponseCurve
from fenics_nnm.face.simulation import Simulation as Simulation
from fenics_nnm.face.study import Study as Study
from fenics_nnm.face.study import make_study as make_study
from fenics_nnm.face.study import new_study as new_study
from fenics_nnm.face.study import read_study as read_study

__version__: str
