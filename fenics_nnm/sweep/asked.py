"""Points that the table of a sweep is asked for, besides those of the studies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fenics_nnm.errors import StudyError
from fenics_nnm.study.settings import Setting

#: The key of a study that holds values which its points are wanted at.
_KEY = "continuation.report_at"


@dataclass(frozen=True, slots=True)
class Asked:
    """Points for the table.

    Attributes:
        ratios: Gamma ratios at which the studies have a point.
        amounts: Amounts with units, as "2 mm" or "300 MPa", that each study is followed to.
    """

    ratios: tuple[float, ...] = ()
    amounts: tuple[str, ...] = ()

    def settings(self, values: dict[str, Any], swept: Sequence[str]) -> tuple[Setting, ...]:
        """The key that gives every study its points at the amounts; none without amounts.

        Args:
            values: Values of the study file.
            swept: Keys that the sweep sets.

        Raises:
            StudyError: if the sweep sets this key itself.
        """
        if not self.amounts:
            return ()
        if {_KEY, "continuation"} & set(swept):
            raise StudyError(
                f"{self.amounts[0]}: is asked for beside --set {_KEY}: name all values in one place"
            )
        section = values.get("continuation")
        given = section.get("report_at", []) if isinstance(section, dict) else []
        known = list(given) if isinstance(given, list) else [given]
        more = [text for text in dict.fromkeys(self.amounts) if text not in known]
        return (Setting(_KEY, [*known, *more]),)
