"""The stress that the linear mode has when it first touches, before anything is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from mpi4py import MPI

from fenics_nnm.backbone.extremes import Extremes
from fenics_nnm.fem.blocks import Blocks
from fenics_nnm.fem.conducting import led
from fenics_nnm.fem.linear import LinearAnalysis
from fenics_nnm.fields.extremes import extremes_of
from fenics_nnm.fields.kept_bases import KeptBases
from fenics_nnm.fields.strength import Strengths, strengths_of
from fenics_nnm.results import branch_file
from fenics_nnm.results.stored_branch import read_stored_branch
from fenics_nnm.running.headers import header_of
from fenics_nnm.structure.prepared import Prepared


def first_contact_lines(prepared: Prepared, comm: MPI.Comm) -> list[str]:
    """What a mode has of stress where its linear motion ends; to be called on all ranks.

    Nothing of matrices, and at full order.
    """
    body = prepared.linear.body
    if body is None or prepared.study.full_order:
        return []
    return ["", *_lines(prepared.study.mode.number, _at_first_contact(prepared, body, comm))]


def _lines(mode: int, found: Extremes) -> list[str]:
    peak, anywhere = found.von_mises.away, found.von_mises.anywhere
    if not peak.known:
        return [
            f"stress           mode {mode} has {_pascal(anywhere.value)} at first contact, but no "
            "cell lies away from contact points and the clamp's edge: refine the mesh"
        ]
    stress = f"{_pascal(peak.value)} at ({', '.join(f'{x:.4g}' for x in peak.place)}) m"
    margin = found.yield_margin
    if not margin.known:
        return [f"stress           mode {mode} has {stress} at first contact; strength not known"]
    limit = f"(yield {_pascal(margin.value * peak.value)})"
    lines = [f"stress           at first contact mode {mode} has {stress} {limit}"]
    if margin.value < 1:
        lines[0] += ": it breaks before it touches"
    elif found.goodman_margin.value < 1:
        lines[0] += (
            f": beyond its fatigue strength, Goodman margin {found.goodman_margin.value:.3g}"
        )
    return lines


def _pascal(value: float) -> str:
    return f"{value / 1e9:.3g} GPa" if value >= 1e9 else f"{value / 1e6:.3g} MPa"


def _at_first_contact(prepared: Prepared, body: LinearAnalysis, comm: MPI.Comm) -> Extremes:
    """Extremes of the linear motion at gamma ratio 1, from a file of results for a moment."""
    data = prepared.linear.data()
    strengths = strengths_of([region.material for region in body.solid.body.regions])

    def measured(blocks: Mapping[str, Blocks]) -> Extremes:
        with TemporaryDirectory() as folder:
            path = Path(folder) / "branch.h5"
            header = header_of(prepared.study, prepared.model_in_contact, prepared.series)
            branch_file.create(path, header, replace(data, blocks=blocks))
            return _of_file(path, prepared, strengths)

    return led(comm, data.blocks, measured)


def _of_file(path: Path, prepared: Prepared, strengths: Strengths) -> Extremes:
    branch = read_stored_branch(path)
    measure = extremes_of(branch, prepared.study.output.frames, strengths, KeptBases())
    rest = branch.header.model.at_rest()
    return measure.of_mode(prepared.mode, rest.amplitude(prepared.mode))
