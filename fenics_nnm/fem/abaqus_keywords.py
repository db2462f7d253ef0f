"""Which keywords of Abaqus and CalculiX are followed, which have no effect here, which cannot be.

What is on neither list is refused by its name: it may change the structure.
"""

from __future__ import annotations

from collections.abc import Iterable

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.abaqus_cards import Card

#: Keywords that say nothing of the structure.
_SILENT = """
    HEADING, PREPRINT, RESTART, ASSEMBLY, END ASSEMBLY, PART, END PART, INSTANCE, END INSTANCE,
    NODE PRINT, NODE FILE, NODE OUTPUT, EL PRINT, EL FILE, ELEMENT OUTPUT, CONTACT PRINT,
    CONTACT FILE, CONTACT OUTPUT, FACE PRINT, SECTION PRINT, SECTION FILE, OUTPUT, FILE FORMAT,
    MONITOR, TIME POINTS, FILTER, DIAGNOSTICS
"""

#: Keywords of what the study states itself, or that have no effect on mass and stiffness.
_STATED = """
    MATERIAL, END MATERIAL, ELASTIC, DENSITY, EXPANSION, CONDUCTIVITY, SPECIFIC HEAT, PLASTIC,
    CYCLIC HARDENING, CREEP, VISCO, VISCOELASTIC, DAMPING, STRUCTURAL DAMPING, DEPVAR,
    USER MATERIAL, USER OUTPUT VARIABLES, HYPERELASTIC, HYPERFOAM, MOHR COULOMB,
    MOHR COULOMB HARDENING, DEFORMATION PLASTICITY, RATE DEPENDENT, LATENT HEAT,
    ELECTRICAL CONDUCTIVITY, MAGNETIC PERMEABILITY, FLUID CONSTANTS, DAMAGE INITIATION,
    DAMAGE EVOLUTION, SPECIFIC GAS CONSTANT, SOLID SECTION, SHELL SECTION, SHELL GENERAL SECTION,
    MEMBRANE SECTION, SURFACE SECTION, SECTION CONTROLS, HOURGLASS STIFFNESS,
    TRANSVERSE SHEAR STIFFNESS, ORIENTATION, DISTRIBUTION, DISTRIBUTION TABLE,
    AMPLITUDE, BOUNDARY, TRANSFORM,
    INITIAL CONDITIONS, PHYSICAL CONSTANTS, VALUES AT INFINITY, SURFACE INTERACTION,
    SURFACE BEHAVIOR, FRICTION, GAP CONDUCTANCE, GAP HEAT GENERATION, CONTACT, CONTACT PAIR,
    CONTACT INCLUSIONS, CONTACT EXCLUSIONS, CONTACT PROPERTY ASSIGNMENT, CONTACT FORMULATION,
    CONTACT CONTROLS, CONTACT CONTROLS ASSIGNMENT, CONTACT INITIALIZATION ASSIGNMENT,
    CONTACT INITIALIZATION DATA, CONTACT DAMPING, CHANGE FRICTION, SURFACE PROPERTY ASSIGNMENT,
    CLEARANCE, CLOAD, DLOAD, DSLOAD, DFLUX, CFLUX, DSFLUX, FILM, SFILM, RADIATE, TEMPERATURE,
    NORMAL, BASE MOTION
"""


def _squeezed(name: str) -> str:
    """A keyword without blanks, as CalculiX compares it."""
    return "".join(name.split())


_SILENT_NAMES = {_squeezed(name) for name in _SILENT.split(",")}
_STATED_NAMES = {_squeezed(name) for name in _STATED.split(",")}

_MERGE = "it joins surfaces: merge the nodes of both sides"

#: What keywords that change the structure do.
_REASONS = {
    "DISTRIBUTINGCOUPLING": "joins nodes",
    "EMBEDDEDELEMENT": "joins parts",
    "SHELLTOSOLIDCOUPLING": "joins parts",
    "FASTENER": "joins parts",
    "PRE-TENSIONSECTION": "joins nodes",
    "CYCLICSYMMETRYMODEL": "joins the two sides of a sector",
    "NONSTRUCTURALMASS": "adds mass: must be [[mass]] of the study",
    "DASHPOT": "adds damping",
    "CONNECTORSECTION": "joins nodes",
    "GAP": "adds contact: must be [contact] of the study",
    "BEAMSECTION": "adds beams",
    "BEAMGENERALSECTION": "adds beams",
    "SYSTEM": "moves nodes: they must be in global coordinates",
    "PARAMETER": "stands for numbers: they must be written out",
    "MODELCHANGE": "removes elements: they must be left out of the file",
}
_MAKES_MESH = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SUBMODEL", "MATRIXINPUT")


def is_stated(card: Card) -> bool:
    """Whether a keyword is left out because the study states it, or it has no effect.

    Raises:
        MeshError: if the keyword changes the structure, or is not known.
    """
    name = _squeezed(card.keyword)
    if _joins_surfaces(card):
        raise MeshError(f"{card.place}: *{card.keyword} with TIED cannot be followed: {_MERGE}")
    changes = _changes_body(card)
    if changes:
        raise MeshError(f"{card.place}: *{card.keyword} cannot be followed: {changes}")
    if name in _SILENT_NAMES or name in _STATED_NAMES:
        return name in _STATED_NAMES
    if name in _MAKES_MESH:
        reason = "the mesh must be written out, node by node and element by element"
    elif name in _REASONS:
        reason = f"it {_REASONS[name]}"
    else:
        reason = "it is not known, and may change the structure: must be left out of the file"
    raise MeshError(f"{card.place}: *{card.keyword} cannot be followed: {reason}")


def _changes_body(card: Card) -> str:
    """What a keyword does with some options that it does not do without, empty for nothing."""
    if card.keyword == "INITIAL CONDITIONS" and card.options.get("TYPE", "").upper() == "STRESS":
        return "it stresses the body"
    if card.keyword == "SURFACE SECTION" and "DENSITY" in card.options:
        return "its DENSITY adds mass"
    return ""


def _joins_surfaces(card: Card) -> bool:
    """Whether a keyword of contact ties surfaces for good."""
    values = {value.upper() for value in card.options.values()}
    return card.keyword.startswith(("CONTACT", "SURFACE")) and (
        "TIED" in card.options or "TIED" in values or "NO SEPARATION" in card.options
    )


def left_out(names: Iterable[str], where: str) -> tuple[str, ...]:
    """A line on the keywords of a file that were not read, none for none.

    Args:
        names: Keywords.
        where: What follows them in the line.
    """
    shown = ", ".join(f"*{name}" for name in dict.fromkeys(names))
    return (f"not read: {shown}{where}",) if shown else ()
