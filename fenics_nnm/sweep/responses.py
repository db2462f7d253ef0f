"""The responses of a sweep: run, looked at in their folders, and put in a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mpi4py import MPI

from fenics_nnm.errors import StudyError
from fenics_nnm.response.levels import Response
from fenics_nnm.response.peaks import Peak
from fenics_nnm.response.point import Status
from fenics_nnm.results import response_file, response_folder
from fenics_nnm.results.response_file import NAME
from fenics_nnm.results.response_resume import response_leaves
from fenics_nnm.results.resume import difference
from fenics_nnm.running.responding import ResponseJob, missing_of, respond
from fenics_nnm.stages import Stages
from fenics_nnm.structure.driven import assert_drivable
from fenics_nnm.structure.shared_analysis import SharedAnalysis
from fenics_nnm.study import Study
from fenics_nnm.sweep.asked import Asked
from fenics_nnm.sweep.case import Case, Outcome, Plan, RunState
from fenics_nnm.sweep.cells import printed
from fenics_nnm.sweep.levels import largest_peak, levels
from fenics_nnm.sweep.outcome import state_of_ended

#: Columns of each level, with the level behind: of the largest peak of the first place that is
#: watched, and of the phase resonance with the largest amplitude.
_OF_PEAK = ("peak_frequency_Hz", "peak_amplitude_m", "peak_phase_deg")
_OF_RESONANCE = ("resonance_frequency_Hz", "resonance_force_N", "damping_ratio")


@dataclass(frozen=True, slots=True)
class Responses:
    """Motions of driven structures over frequency, as `fenics-nnm response` finds them."""

    command: str = "response"

    def assert_possible(self, study: Study) -> None:
        """Refuse a study that cannot be driven."""
        assert_drivable(study, "sweep --response")

    def ratios(self, cases: Sequence[Case], asked: Asked) -> tuple[float, ...]:
        """Responses have none."""
        for value in (*(f"--gamma {ratio:g}" for ratio in asked.ratios), *asked.amounts):
            raise StudyError(f"{value}: has no effect: responses have levels")
        return ()

    def state(self, case: Case) -> RunState:
        """How far a study is."""
        file = case.folder / NAME
        if file.exists():
            header = response_file.read(file).header
            return state_of_ended(case, header.study, header.inputs, response_leaves)
        begun = response_folder.stored(case.folder)
        same = [not difference(each.header.study, case.text, response_leaves) for _, each in begun]
        return RunState.BEGUN if any(same) else RunState.NEW

    def run(self, case: Case, *, go_on: bool, stages: Stages, shared: SharedAnalysis) -> None:
        """Find the response of a study on this process alone."""
        respond(ResponseJob(case.study, case.text, go_on, MPI.COMM_SELF, stages), case.folder)

    def ended(self, case: Case) -> Outcome:
        """What the folder of a study that ended holds."""
        found = response_file.read(case.folder / NAME).found
        missing = list(missing_of(case.study, found))
        status = "incomplete" if missing else "complete"
        return Outcome(case, status, "; ".join(missing), response=found)

    def columns(self, plan: Plan) -> list[str]:
        """Names of its columns of sweep.csv."""
        return [
            *(f"{n}_level_{level:g}" for level in levels(plan) for n in _OF_PEAK + _OF_RESONANCE),
            "points",
            *(f"points_{status}" for status in Status),
            "points_unstable",
        ]

    def cells(self, plan: Plan, outcome: Outcome) -> Iterator[str]:
        """Its cells of the row of a study."""
        found = outcome.response
        for level in levels(plan):
            yield from _peak_cells(largest_peak(found, level))
            yield from _resonance_cells(found, level)
        known = bool(found.points)
        counts = Counter(point.status for point in found.points)
        yield str(len(found.points)) if known else ""
        for status in Status:
            yield str(counts[status]) if known else ""
        unstable = sum(p.judgement.stability not in ("", "stable") for p in found.points)
        yield str(unstable) if known else ""

    def draw(self, plan: Plan, outcomes: Sequence[Outcome], title: str) -> list[str]:
        """Draw the curves, and the peaks over the key if one number is swept."""
        from fenics_nnm.sweep.response_pictures import draw_responses

        return draw_responses(plan, outcomes, title)


def _peak_cells(peak: Peak | None) -> list[str]:
    if peak is None:
        return [""] * len(_OF_PEAK)
    return [printed(value) for value in (peak.frequency, peak.amplitude, peak.phase)]


def _resonance_cells(found: Response, level: float) -> list[str]:
    own = [each for each in found.backbone.points if each.point.level == level]
    if not own:
        return [""] * len(_OF_RESONANCE)
    best = max(own, key=lambda each: float(each.point.amplitude[0]))
    return [printed(value) for value in (best.point.frequency, best.force, best.damping_ratio)]
