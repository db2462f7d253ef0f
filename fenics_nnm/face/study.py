"""A study in Python: read or made, changed, looked at and run."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fenics_nnm.face.words import in_words_of_study
from fenics_nnm.study.reading import read_study as checked_study
from fenics_nnm.study.reading import study_from
from fenics_nnm.study.settings import Setting, parts_of, study_with
from fenics_nnm.study.study import Study as CheckedStudy
from fenics_nnm.study.toml_text import toml_text

if TYPE_CHECKING:
    from fenics_nnm.face.branch import Branch
    from fenics_nnm.face.check import Check
    from fenics_nnm.face.diagrams import Campbell, Sweep
    from fenics_nnm.face.response import Response
    from fenics_nnm.face.running import Asked
    from fenics_nnm.face.simulation import Simulation
    from fenics_nnm.structure.shared_analysis import SharedAnalysis

#: Name of the file that a study made of values stands for, in messages.
_NAME = "study.toml"


@dataclass(slots=True)
class _Kept:
    """The linear analysis of a study, and of those made of it that differ in gaps alone."""

    _shared: SharedAnalysis | None = None

    @property
    def analyse(self) -> SharedAnalysis:
        """The analysis, which is made when it is first called."""
        if self._shared is None:
            from fenics_nnm.structure.shared_analysis import SharedAnalysis

            self._shared = SharedAnalysis()
        return self._shared


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Study:
    """A study with all its values; made by `read_study`, `make_study` or `new_study`.

    Studies are never changed: `with_values` makes another one. Modes are kept for studies that are
    made of each other and differ in gaps and motions alone.

    Attributes:
        text: Text of the study file.
        path: The study file; files that it names are relative to its folder.
    """

    text: str
    path: Path
    _checked: CheckedStudy
    _kept: _Kept = field(default_factory=_Kept)

    def __repr__(self) -> str:
        return f"Study({self.title!r}, {str(self.path)!r})"

    @property
    def title(self) -> str:
        """Title of the study; may be empty."""
        return self._checked.title

    @property
    def values(self) -> dict[str, Any]:
        """Values as in the study file: sections are dictionaries, several of a kind a list."""
        return tomllib.loads(self.text)

    @in_words_of_study
    def with_values(self, changes: Mapping[str, Any]) -> Study:
        """The study with other values of some keys.

        Args:
            changes: Values by key, as in `{"contact.gap": "0.3 mm", "mode.number": 2}`; of several
                sections one is `"contact.patch[2].gap"`.

        >>> rod = make_study(
        ...     {
        ...         "mesh": {"model": "rod", "length": 1.0, "elements": 4},
        ...         "body": {"theory": "rod", "area": 9e-4},
        ...         "material": {"young": 2.1e11, "density": 7800.0},
        ...         "clamp": {"facets": "left"},
        ...         "contact": {"facets": "right", "direction": [1.0], "gap": 1e-3},
        ...         "mode": {"number": 1, "harmonics": 3, "samples": 32},
        ...         "reduction": {"modes": 2},
        ...         "continuation": {"energies": {"from": 0.8, "to": 1.1, "step": 0.1}},
        ...     }
        ... )
        >>> rod.with_values({"contact.gap": "0.3 mm"}).values["contact"]["gap"]
        '0.3 mm'
        >>> rod.with_values({"contact.gap": "0.3 furlongs"})
        Traceback (most recent call last):
            ...
        fenics_nnm.errors.StudyError: with contact.gap = "0.3 furlongs": study.toml: contact.gap = \
"0.3 furlongs": the unit "furlongs" is not known: must be m, cm, mm, um, in, ft or mil (initial \
gap in m, negative for an interference)

        Raises:
            StudyError: if a key or a value is wrong.
        """
        settings = tuple(Setting(key, _plain(value)) for key, value in changes.items())
        for setting in settings:
            parts_of(setting.key)
        checked, text = study_with(self.values, self.path, settings)
        return Study(text, self.path, checked, self._kept)

    @in_words_of_study
    def check(self) -> Check:
        """What the study means, up to its linear modes: as `fenics-nnm check`.

        Raises:
            NonlinearModeError: if it cannot be run.
        """
        from fenics_nnm.face.check import check_of

        return check_of(self._checked, self._kept.analyse)

    @in_words_of_study
    def branch(self, folder: str | Path | None = None, *, resume: bool = False) -> Branch:
        """Follow the nonlinear mode in this process: as `fenics-nnm run`.

        A branch without all the points that were asked for is returned too, with `complete` False.

        Args:
            folder: Folder of the results. Without one they are in a temporary folder, for as long
                as the branch is used; `Branch.save` copies them.
            resume: Begin with the points of a stopped, or finished, run of this study in `folder`.

        Raises:
            NonlinearModeError: if the study cannot be run, or the results not be written.
            ConvergenceError: if no point was found.
        """
        from fenics_nnm.face.running import followed

        return followed(self._asked, None if folder is None else Path(folder), resume=resume)

    @in_words_of_study
    def response(self, folder: str | Path | None = None, *, resume: bool = False) -> Response:
        """Find the response of a driven structure in this process: as `fenics-nnm response`.

        Args:
            folder: Folder of the results. Without one they are in a temporary folder, for as long
                as the response is used.
            resume: Go on from the levels of an interrupted, or finished, response in `folder`.

        Raises:
            NonlinearModeError: if the study cannot be driven, or the results not be written.
        """
        from fenics_nnm.face.running import responded

        return responded(self._asked, None if folder is None else Path(folder), resume=resume)

    @in_words_of_study
    def sweep(
        self, values: Mapping[str, Sequence[Any]], folder: str | Path, *, response: bool = False
    ) -> Sweep:
        """Run the study with all combinations of values: as `fenics-nnm sweep`, without pictures.

        Args:
            values: Values of each key, as in `{"contact.gap": [1e-4, 2e-4]}`.
            folder: Folder of the sweep. Studies that are done there are not run again.
            response: Responses of driven structures in place of branches.

        Raises:
            NonlinearModeError: if a key or a value is wrong, or results cannot be written.
        """
        from fenics_nnm.face.making import sweep_of

        plain = {key: _plain(list(given)) for key, given in values.items()}
        return sweep_of(self._asked, Path(folder), plain, response=response)

    @in_words_of_study
    def campbell(
        self,
        speeds_rad_per_s: Sequence[float],
        folder: str | Path,
        *,
        modes: int = 6,
        orders: Sequence[int] = (1, 2, 3, 4),
        energies_J: Sequence[float] = (),
        amplitudes_m: Sequence[float] = (),
    ) -> Campbell:
        """Make a Campbell diagram in this process: as `fenics-nnm campbell`.

        Args:
            speeds_rad_per_s: Speeds, ascending.
            folder: Folder of the results.
            modes: Number of linear modes.
            orders: Engine orders.
            energies_J: Energies of nonlinear lines.
            amplitudes_m: Largest displacements of nonlinear lines.

        Raises:
            NonlinearModeError: if it cannot be made, or the results not be written.
            ValueError: if a number is none, or out of bounds.
        """
        from fenics_nnm.face.making import Lines, campbell_of

        lines = Lines.given(speeds_rad_per_s, modes, orders, energies_J, amplitudes_m)
        return campbell_of(self._asked, Path(folder), lines)

    @in_words_of_study
    def simulate(
        self,
        folder: str | Path,
        *,
        frequency_Hz: float | None = None,
        periods: int | None = None,
        way: str = "both",
        level: float = 1.0,
    ) -> Simulation:
        """Follow the driven structure in time from rest: as `fenics-nnm simulate`.

        Args:
            folder: Folder of the results.
            frequency_Hz: Constant frequency; a sweep through those of [response] if not given.
            periods: Periods in all, 500 if not given; or at each frequency of a sweep, 20.
            way: Way of a sweep: "up", "down" or "both".
            level: Factor of all forces.

        Raises:
            NonlinearModeError: if the study cannot be driven, or the results not be written.
            ValueError: if a number is none.
        """
        from fenics_nnm.face.arguments import integer, number
        from fenics_nnm.face.making import simulation
        from fenics_nnm.structure.simulated import asked_of

        frequency = None if frequency_Hz is None else number("frequency_Hz", frequency_Hz)
        count = None if periods is None else integer("periods", periods)
        wanted = asked_of(frequency, count, way, number("level", level))
        return simulation(self._asked, Path(folder), wanted)

    @property
    def _asked(self) -> Asked:
        from fenics_nnm.face.running import Asked

        return Asked(self._checked, self.text, self.path, self._kept.analyse)


@in_words_of_study
def read_study(path: str | Path) -> Study:
    """Read and check a study file.

    Args:
        path: Study file (.toml).

    Raises:
        StudyError: with one line that names the key, its value and what would be right.
    """
    path = Path(path)
    return Study(_text(path), path, checked_study(path))


def _text(path: Path) -> str:
    """Text of a study file; empty if it cannot be read, of which `read_study` has the message."""
    try:
        return path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return ""


@in_words_of_study
def make_study(values: Mapping[str, Any], folder: str | Path = ".") -> Study:
    """Make a study of values, as a study file has them.

    Args:
        values: Sections by name, each a mapping of keys to values; of several sections a list.
        folder: Where files that the study names are.

    Raises:
        StudyError: with one line that names the key, its value and what would be right.
    """
    plain, path = _plain(values), Path(folder) / _NAME
    return Study(toml_text(plain), path, study_from(plain, path))


@in_words_of_study
def new_study(kind: str, folder: str | Path = ".", *, rotor: int = 37) -> Study:
    """Write a commented study that runs, and what it needs, and read it: as `fenics-nnm new`.

    Args:
        kind: "blade", "rod", "plate", "mesh" or "matrices".
        folder: Folder, made if there is none, or the study's file if that ends in .toml.
        rotor: NASA rotor of a blade: 37 or 67.

    Raises:
        StudyError: if the kind is unknown, or a file is there already.
        OutputError: if a file cannot be written.
    """
    from fenics_nnm.errors import StudyError
    from fenics_nnm.templates import KINDS, ROTORS, write_template

    for name, value, known in (("kind", kind, KINDS), ("rotor", rotor, ROTORS)):
        if value not in known:
            raise StudyError(f"{name} = {value!r}: must be one of {', '.join(map(str, known))}")
    return read_study(write_template(kind, Path(folder), rotor=rotor)[0])


def _plain(value: Any) -> Any:
    """A value as a study file has it: of tuples, arrays, paths and numbers of NumPy."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return str(value) if isinstance(value, Path) else value
