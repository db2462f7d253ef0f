"""What a study means, in words and numbers, before it is run."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.study import Study

#: Multiples of the frequency within this part of another one are named.
_NEAR = 0.05


def describe(study: Study, analysis: LinearAnalysis) -> str:
    """Mesh, groups, contact and linear modes of a study as text; the same on all ranks."""
    tagged, interface = analysis.solid.tagged, analysis.interface
    mode = study.mode.number - 1
    amplitude = analysis.model.grazing_amplitude(mode)
    energy = (analysis.model.omega[mode] * amplitude) ** 2 / 2
    lines = [
        study.title or "(no title)",
        f"mesh             {_cells(analysis)} cells, {analysis.solid.dofs} degrees of freedom",
        f"bounding box     {_box(analysis)} m",
        f"facet groups     {', '.join(sorted(tagged.facets))}",
        f"contact          {interface.count} points, {interface.areas.sum():.6g} m^2, "
        f"gap {interface.gap.min():.4g} m",
        f"grazing          at {energy:.6g} J for mode {study.mode.number}, first at "
        f"{_point(analysis, mode)} m",
        f"largest motion   {_largest(analysis, mode, amplitude):.4g} m when it grazes",
        "",
        " mode   frequency (Hz)   motion at contact (kg^-1/2)",
    ]
    for number, hertz in enumerate(analysis.modes.frequencies):
        reach = np.abs(analysis.model.Phi[:, number]).max()
        lines.append(f"{number + 1:5d}   {hertz:14.6g}   {reach:10.4g}")
    lines += ["", f"no mode missed below {analysis.modes.checked_below / 2 / np.pi:.6g} Hz"]
    return "\n".join(lines + _resonances(study, analysis))


def _largest(analysis: LinearAnalysis, mode: int, amplitude: float) -> float:
    """Largest displacement component of a mode when it just touches, in m."""
    shape = np.abs(analysis.reduction.shapes[:, mode]).max(initial=0.0) * amplitude
    return float(analysis.solid.tagged.mesh.comm.allreduce(shape, op=MPI.MAX))


def _cells(analysis: LinearAnalysis) -> int:
    mesh = analysis.solid.tagged.mesh
    return int(mesh.topology.index_map(mesh.topology.dim).size_global)


def _box(analysis: LinearAnalysis) -> str:
    mesh, dim = analysis.solid.tagged.mesh, analysis.solid.tagged.dim
    pieces = [piece for piece in mesh.comm.allgather(mesh.geometry.x[:, :dim]) if len(piece)]
    points = np.concatenate(pieces)
    ranges = zip(points.min(axis=0), points.max(axis=0), strict=True)
    return " x ".join(f"[{low:.6g}, {high:.6g}]" for low, high in ranges)


def _point(analysis: LinearAnalysis, mode: int) -> str:
    motion = np.maximum(np.abs(analysis.model.Phi[:, mode]), 1e-300)
    first = int(np.argmin(analysis.interface.gap / motion))
    return "(" + ", ".join(f"{x:.5g}" for x in analysis.interface.points[first]) + ")"


def _resonances(study: Study, analysis: LinearAnalysis) -> list[str]:
    """Linear frequencies near a multiple of the followed one: internal resonances to expect."""
    omega = analysis.modes.omega
    first = omega[study.mode.number - 1]
    lines = []
    for number, other in enumerate(omega):
        harmonic = round(float(other / first))
        close = abs(other / (harmonic * first) - 1) if harmonic else np.inf
        if number + 1 != study.mode.number and harmonic <= study.mode.harmonics and close < _NEAR:
            lines.append(
                f"mode {number + 1} lies at {other / first:.4f} times mode {study.mode.number}: "
                f"internal resonance with harmonic {harmonic} is near"
            )
    return lines
