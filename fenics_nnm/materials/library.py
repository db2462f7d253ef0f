"""A small library of materials at room temperature, with a source for each."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import Any

from fenics_nnm.errors import ModelError
from fenics_nnm.materials.elasticity import Isotropic, Orthotropic
from fenics_nnm.materials.material import STRENGTHS, Material
from fenics_nnm.materials.orientation import XYZ, Orientation


def library_material(name: str, orientation: Orientation = XYZ) -> Material:
    """A material of the library.

    Args:
        name: Its name, a key of `library`.
        orientation: Its material axes, if it is not isotropic.

    Raises:
        ModelError: if there is none of that name; the message has the names.
    """
    known = library()
    if name not in known:
        lower = {each.lower(): each for each in known}
        close = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=0.5)
        hint = f'did you mean "{lower[close[0]]}"? ' if close else ""
        names = ", ".join(f'"{each}"' for each in known)
        raise ModelError(f'name = "{name}": is not in the library: {hint}it has {names}')
    return replace(known[name], orientation=orientation)


@cache
def library() -> Mapping[str, Material]:
    """All materials of the library by name."""
    text = resources.files(__package__).joinpath("library.toml").read_text(encoding="utf-8")
    return {name: _material(name, values) for name, values in tomllib.loads(text).items()}


def _material(name: str, values: dict[str, Any]) -> Material:
    law: Isotropic | Orthotropic
    if "shear" in values:
        law = Orthotropic(*(tuple(values[key]) for key in ("young", "poisson", "shear")))
    else:
        law = Isotropic(values["young"], values["poisson"])
    expansion = values["expansion"]
    along = tuple(expansion) if isinstance(expansion, list) else (expansion,) * 3
    return Material(
        law,
        values["density"],
        name=name,
        source=values["source"],
        expansion=along,
        **{key: values[key] for key in (*STRENGTHS, "strength_source") if key in values},
    )
