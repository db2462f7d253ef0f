"""Which commands of Ansys files change a structure in a way that is not followed."""

from __future__ import annotations

from fenics_nnm.errors import MeshError
from fenics_nnm.fem.ansys_blocks import Block

_BLOCKS_ONLY = "must be NBLOCK and EBLOCK"
_ONE_FILE = "must be one file"

#: Why commands cannot be followed. Ansys looks at their first four letters alone.
_REASONS = {
    **dict.fromkeys(("CE", "CP", "CEBLOCK", "CPNGEN", "CPLGEN", "CPSGEN"), "it joins nodes"),
    **dict.fromkeys(("CPINTF", "CPCYC", "CPMERGE", "CEGEN", "CESGEN", "CECYC"), "it joins nodes"),
    **dict.fromkeys(("CEINTF", "EINTF", "SWGEN", "SWADD"), "it joins parts"),
    **dict.fromkeys(("RBE3", "CEDISP"), "it joins nodes"),
    "CERIG": "it makes nodes rigid",
    **dict.fromkeys(("GCDEF", "GCGEN"), "contact must be [contact] of the study"),
    "CYCLIC": "it joins the two sides of a sector",
    "NUMMRG": "it merges nodes: they must be merged in NBLOCK and EBLOCK",
    "ENDRELEASE": "it opens joints",
    "SE": "it adds a superelement",
    "INISTATE": "it stresses the body",
    **dict.fromkeys(("EKILL", "EDELE", "NDELE"), "must be left out of NBLOCK and EBLOCK"),
    **dict.fromkeys(("E", "EN", "EMORE", "EGEN", "ENGEN", "EMODIF", "ESYM", "ENSYM"), _BLOCKS_ONLY),
    **dict.fromkeys(("EREFINE", "NREFINE", "ESURF"), _BLOCKS_ONLY),
    **dict.fromkeys(("N", "NGEN", "NMODIF", "NSYM", "NSCALE", "FILL", "MOVE"), _BLOCKS_ONLY),
    **dict.fromkeys(("TRANSFER", "UPGEOM", "MORPH", "EMSYM"), _BLOCKS_ONLY),
    **dict.fromkeys(("CDREAD", "/INPUT", "NREAD", "EREAD", "*USE", "*ULIB"), _ONE_FILE),
    "/CLEAR": "it begins anew",
}

#: Letters of a command that count.
_LETTERS = 4

_SHORT_REASONS = {name[:_LETTERS]: reason for name, reason in _REASONS.items()}

#: Elements in a plane, and what their third option makes of them.
_PLANES = (2, 42, 82, 182, 183)
_STATES = {1: "axisymmetric", 5: "of generalised plane strain"}

#: The third option of an element type in ET, and the values of KEYOPT.
_THIRD_IN_ET = 5


def assert_followed(block: Block) -> None:
    """Refuse a command that changes the structure.

    Raises:
        MeshError: if it does.
    """
    reason = _SHORT_REASONS.get(block.name[:_LETTERS])
    ends_nodes = block.name == "N" and block.words[1:2] and block.words[1].upper().startswith("R5")
    if reason and not ends_nodes:
        raise MeshError(f"{block.place}: {block.name} cannot be followed: {reason}")


def assert_plane(block: Block, types: dict[int, int]) -> None:
    """Refuse options of plane elements that make another theory of them than the study's.

    Args:
        block: ET or KEYOPT.
        types: Ansys's number of each type of elements.

    Raises:
        MeshError: if the elements are axisymmetric.
    """
    third = _third_option(block)
    if len(block.words) > 1 and third in _STATES and types.get(block.whole(1)) in _PLANES:
        raise MeshError(
            f"{block.place}: {block.name} cannot be followed: elements of type {block.words[1]} "
            f"are {_STATES[third]}: must be plane or solid"
        )


def _third_option(block: Block) -> int:
    """What ET or KEYOPT sets the third option to, 0 for nothing."""
    if block.name == "ET" and len(block.words) > _THIRD_IN_ET and block.words[_THIRD_IN_ET]:
        return block.whole(_THIRD_IN_ET)
    if block.name.startswith("KEYO") and len(block.words) > 3 and block.words[2] == "3":
        return block.whole(3) if block.words[3] else 0
    return 0
