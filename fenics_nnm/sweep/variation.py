"""How the studies of a sweep differ: keys that vary on their own, and those that go with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fenics_nnm.study.messages import shown
from fenics_nnm.study.toml_text import toml_value
from fenics_nnm.study.units import unit_of
from fenics_nnm.sweep.case import Case, Plan


@dataclass(frozen=True, slots=True)
class Variation:
    """A key that varies, with keys whose values follow from its value.

    Attributes:
        keys: The key, and those that go with it.
        label: Keys with their units.
        values: Value of the key in each study, in the order of the studies.
        names: Values of all keys in each study, as text.
    """

    keys: tuple[str, ...]
    label: str
    values: tuple[Any, ...]
    names: tuple[str, ...]

    @property
    def numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(type(value) in (int, float) for value in self.values)

    @property
    def levels(self) -> list[str]:
        """Different values as text: numbers ascending, others in the order of the studies."""
        pairs = dict(zip(self.names, self.values, strict=True))
        return sorted(pairs, key=lambda name: pairs[name]) if self.numeric else list(pairs)


def variations(plan: Plan) -> list[Variation]:
    """Keys that vary from study to study, in the order of the command line."""
    groups: list[list[int]] = []
    for index in range(len(plan.keys)):
        texts = _texts(plan.cases, [index])
        if len(set(texts)) == 1:
            continue
        leader = next((g for g in groups if _follows(texts, _texts(plan.cases, g[:1]))), None)
        if leader is None:
            groups.append([index])
        else:
            leader.append(index)
    return [_variation(plan, group) for group in groups]


def _variation(plan: Plan, group: Sequence[int]) -> Variation:
    keys = tuple(plan.keys[index] for index in group)
    study = plan.cases[0].study
    units = [unit_of(study, key) for key in keys]
    return Variation(
        keys=keys,
        label=", ".join(f"{k} ({u})" if u else k for k, u in zip(keys, units, strict=True)),
        values=tuple(case.values[group[0]] for case in plan.cases),
        names=tuple(_texts(plan.cases, group)),
    )


def _texts(cases: Sequence[Case], group: Sequence[int]) -> list[str]:
    return [", ".join(_text(case.values[index]) for index in group) for case in cases]


def _text(value: Any) -> str:
    return shown(value if isinstance(value, str) else toml_value(value)).strip('"')


def _follows(texts: Sequence[str], leaders: Sequence[str]) -> bool:
    """Whether each value of a leading key comes with one value alone."""
    return len(set(zip(leaders, texts, strict=True))) == len(set(leaders))
