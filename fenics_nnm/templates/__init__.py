"""Commented studies that run as they are, and what they need beside them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import OutputError, StudyError
from fenics_nnm.templates.example_data import write_bracket, write_chain

_HERE = Path(__file__).parent

KINDS = ("blade", "rod", "plate", "mesh", "matrices")
"""Kinds of studies that can be begun with."""

ROTORS = (37, 67)
"""NASA rotors whose blade is at hand."""


@dataclass(frozen=True, slots=True)
class _Template:
    """A study, and functions that write the files that it needs, by their names."""

    study: str
    files: dict[str, Callable[[Path], None]]


def write_template(kind: str, target: Path, *, rotor: int = 37) -> list[Path]:
    """Write a study and what it needs.

    Args:
        kind: One of `KINDS`.
        target: The study's file, if it ends in .toml, or its folder, made if there is none.
        rotor: One of `ROTORS`, for a blade.

    Returns:
        The files written, the study first.

    Raises:
        StudyError: If one of the files is there already; nothing is written then.
        OutputError: If a file cannot be written.
    """
    template = _template(kind, rotor)
    study = target if target.suffix == ".toml" else target / f"{kind}.toml"
    others = {study.with_name(name): write for name, write in template.files.items()}
    for path in (study, *others):
        if path.exists():
            raise StudyError(f"{path}: is there already, and is not overwritten")
    text = (_HERE / template.study).read_text(encoding="utf-8")
    text = text.replace(f" {kind}.toml", f" {study.name}")
    try:
        study.parent.mkdir(parents=True, exist_ok=True)
        for path, write in others.items():
            write(path)
        study.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{error.filename or study}: {error.strerror}") from error
    return [study, *others]


def _template(kind: str, rotor: int) -> _Template:
    if kind == "blade":
        tables = [f"rotor{rotor}_{table}.csv" for table in ("blade_sections", "hub_shroud")]
        return _Template(f"blade_rotor{rotor}.toml", {name: _copy(name) for name in tables})
    if kind == "mesh":
        return _Template("mesh.toml", {"bracket.msh": write_bracket})
    if kind == "matrices":
        return _Template("matrices.toml", {"matrices.npz": write_chain})
    return _Template(f"{kind}.toml", {})


def _copy(name: str) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.write_bytes((_HERE / name).read_bytes())

    return write
