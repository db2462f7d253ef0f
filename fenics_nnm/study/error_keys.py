"""Keys of the study file that mend an error: the one place that knows both.

Numerical rooms name things in their own words and give each error a code. Here these words become
keys, so that the line that a user reads names what to change in the study file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from fenics_nnm.errors import Code, NonlinearModeError

#: The beginning of a word that is too long to be read, and the rest of it.
_LONG_WORD = re.compile(r"(\S{80})\S{220,}")

_MASSLESS = ("the massless reduction", 'reduction.method = "massless"')
_DIRECT = ("the direct solver", 'solver.linear "direct"')
_MESH_FILE = ("mesh file ", "mesh.file = ")

#: Words of an error with a code, each with the key that stands for it.
KEYS: Mapping[Code, tuple[tuple[str, str], ...]] = {
    Code.CELLS_OF_MATERIALS: (("cells of materials", "material.cells"),),
    Code.CONSTRAINED: (_DIRECT,),
    Code.CURVED_ELEMENTS: (
        _MESH_FILE,
        ("a smaller element size", "a smaller element_size"),
        ("elements of order 1", "order = 1"),
    ),
    Code.CYLINDRICAL_AXES: (("cylindrical axes: ", "material.orientation.cylindrical: "),),
    Code.DEGREE: (("degree = ", "body.degree = "), _DIRECT),
    Code.DEGREE_WITHOUT_MEMORY: (("degree = ", "body.degree = "),),
    Code.ELEMENT_SIZE: (("element size = ", "mesh.element_size = "),),
    Code.EXPANSION: (("no thermal expansion is", "material.expansion: is missing, and none is"),),
    Code.WARMING: (
        ("the change of temperature", "load.temperature: the change of temperature"),
        ("strains the material by", "times material.expansion is a strain of"),
    ),
    Code.FULL_ORDER_GAP: (("gap = ", "contact.gap = "), _MASSLESS),
    Code.GAP: (("gap ", "contact.gap "),),
    Code.GAP_WITH_FORCES: (("gap = ", "contact.gap = "),),
    Code.GAP_WITH_KINEMATICS: (("gap = ", "contact.gap = "),),
    Code.GAP_WITH_MASS: (("gap = ", "contact.gap = "), _MASSLESS),
    Code.KINEMATICS_AT_FULL_ORDER: (_MASSLESS,),
    Code.LENGTH_UNIT: (
        ("length unit ", "mesh.length_unit = "),
        ("the declared unit must be ignored", "ignore_declared_unit = true"),
    ),
    Code.MASS_AT_CONTACT: (_MASSLESS, ("full order with", '"none" with')),
    Code.MEMORY: (
        (
            "more memory for factors, or the iterative solver",
            'a larger solver.memory, or solver.linear = "iterative"',
        ),
    ),
    Code.MEMORY_OF_FACTORS: (("more memory for factors", "a larger solver.memory"),),
    Code.MEMORY_LIMIT: (_MESH_FILE, ("the memory limit", "the limit mesh.memory")),
    Code.MESHING: (_MESH_FILE, ("the element size", "element_size")),
    Code.MESH_FILE: (_MESH_FILE,),
    Code.MODE: (("mode = ", "mode.number = "),),
    Code.MODES: (("modes = ", "reduction.modes = "),),
    Code.HELD_MODES: (_DIRECT,),
    Code.MODES_OF_ITERATION: (("modes = ", "reduction.modes = "), _DIRECT),
    Code.NOT_HELD: (("facets that hold it", "facets that hold it in clamp.facets"),),
    Code.OUT_OF_PLANE: (
        ("the orientation turns", "material.orientation: turns"),
        ("a solid body", 'body.theory = "solid"'),
    ),
    Code.REFERENCE: (
        ("the reference displacement is missing", "contact.reference_displacement: is missing"),
    ),
    Code.REFINED_SIZE: (("refined size = ", "mesh.refine.size = "),),
    Code.STEADY_LOADS: (("steady loads", "steady loads, [rotation] and [load],"),),
    Code.STILL_MODE: (
        ("another mode or contact direction", "another mode.number or contact.direction"),
    ),
    Code.THEORY: (('theory "', 'body.theory = "'),),
    Code.TIME_LIMIT: (_MESH_FILE, ("the time limit", "mesh.time")),
    Code.TOO_MANY_MODES: (("fewer modes", "fewer reduction.modes"),),
}


def in_keys(error: NonlinearModeError) -> str:
    """Message of an error with the keys of the study file for what it is about."""
    message = str(error)
    for words, key in KEYS[error.code] if error.code else ():
        message = message.replace(words, key, 1)
    return message


def one_line(error: BaseException) -> str:
    """What is said of an error, of whatever kind, in one line with its notes."""
    message = "; ".join([_message(error), *getattr(error, "__notes__", ())])
    return _without_long_words(" ".join(message.split()))


def _without_long_words(line: str) -> str:
    """A line whose words that no one would read to the end are cut."""
    return _LONG_WORD.sub(r"\1...", line)


def _message(error: BaseException) -> str:
    if isinstance(error, NonlinearModeError):
        return in_keys(error)
    if isinstance(error, KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MemoryError):
        return "out of memory: use a coarser mesh or fewer reduction.modes"
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, OverflowError | FloatingPointError):
        return (
            f"a number becomes too large or too small to compute with ({error}): check lengths, "
            "units and material (--verbose shows where)"
        )
    return (
        f"this is a defect of fenics-nnm, please report it: {type(error).__name__}: {error} "
        "(--verbose shows where)"
    )
