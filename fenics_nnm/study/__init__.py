"""The study file as typed records."""

from fenics_nnm.study.reading import read_study, study_from
from fenics_nnm.study.study import MatrixStudy, MeshStudy, Study

__all__ = ["MatrixStudy", "MeshStudy", "Study", "read_study", "study_from"]
