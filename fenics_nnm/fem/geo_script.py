"""Scripts of gmsh (.geo) that may build a geometry and nothing else.

gmsh's language can start programs and read and write files. A script is looked through word by
word, in the way gmsh's own scanner cuts it, before gmsh sees it; what gmsh gets is written anew
from these words, without comments, with the files it includes in their place.

In gmsh's grammar a command is any name followed by a text, as in `SystemCall "..."`; so a name
that is not known here and is followed by a text, or by what may stand for one, is refused.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fenics_nnm.errors import Code, MeshError

#: Words that start programs, read or write files, end gmsh, ask for input, or make other names.
_REFUSED = frozenset(
    """Abort AbsolutePath AdaptMesh AliasWithOptions ClientServer CommandLine CopyOptions CreateDir
    CurrentDir CurrentDirectory CurrentFileName DirName Draw Exit ExternalProcess FileExists
    FileName FixRelativePath GetEnv GetForcedStr GetString GetStringValue GmshExecutableName
    ListFromFile MergeWithBoundingBox MergeFile N2S NameToString NonBlockingSystemCall OnelabAction
    OnelabRun OpenProject Plugin Print S2N Save ServerAction SetString ShapeFromFile Sleep Solver
    StringToName Structured SyncModel System SystemCall UnsplitWindow""".split()
)

#: Words that give a text: after a name that is no word of the language they make it a command.
_TEXTS = frozenset(
    """CodeName DefineString LowerCase LowerCaseIn NameStruct DimNameSpace Sprintf Str StrCat
    StrChoice StrPrefix StrRelative StrReplace StrSub Today UpperCase""".split()
)

#: Words that a text, or a name, may follow.
_WORDS = frozenset(
    """Abs Acos Affine Alias Append ArcCos ArcSin ArcTan ArcTan2 Asin Atan Atan2 BSpline Betti
    Bezier Block BooleanCoherence BooleanCommon BooleanCut BooleanDifference BooleanFragments
    BooleanFuse BooleanIntersection BooleanSection BooleanUnion BoundingBox Box Call Catenary
    CatmullRom Ceil CenterOfMass Chamfer Characteristic Circle ClassifySurfaces Coherence Cohomology
    Color ColorTable Combine Compound Cone Coordinates Cos Cosh Cpu CreateGeometry CreateTopology
    Curve Cylinder DefineConstant DefineNumber Degenerated Delete Dilate Disk Ellipse Ellipsis
    Ellipsoid Elliptic Else ElseIf EndFor EndIf Error Euclidian Exists Exp Extrude Fabs Field Fillet
    Find Floor Fmod For Function GeoEntity GetForced GetNumber GetValue HealShapes Hide Hole
    Homology Hypot If In Intersect Knots Layers Length Levelset Line LinSpace List Log Log10
    LogSpace MPI_Rank MPI_Size Macro Mass MatrixOfInertia Max Memory MeshAlgorithm MeshSize
    MeshSizeFromBoundary Min Modulo NewModel Normal Nurbs Order Parametric Parent Periodic Physical
    Pi Plane Point PolarSphere Printf QuadTriAddVerts QuadTriNoNewVerts Quadric Rand RecombLaterals
    Recombine RecombineMesh Rectangle Recursive RefineMesh RelocateMesh RenumberMeshElements
    RenumberMeshNodes ReorientMesh Return Reverse ReverseMesh Rotate Round Ruled ScaleLastLayer
    SetChanged SetFactory SetMaxTag SetNumber SetPartition SetTag Sewing Show Sin Sinh Slide
    Smoother Sphere Spline Split Sqrt Step StrCmp StrFind StrLen Surface Symmetry TIME Tan Tanh
    TestLevel ThickSolid ThruSections Torus TotalMemory TransfQuadTri Transfinite TransformMesh
    Translate UndefineConstant Unique Using Volume Warning Wedge Wire

    Alternate Beta Bump Choices Closed Graph Help Highlight Label Left Loop Name OptimizeMesh
    Progression ReadOnly ReadOnlyRange Right SetName Units Visible""".split()
)

#: Words that take a text to print, and could write it to a file.
_PRINTING = frozenset({"Printf", "Error", "Warning"})

#: Categories of options; texts may be set in the first ones alone.
_OPTIONS = frozenset({"Mesh", "Geometry", "General"})
_TEXT_OPTIONS = frozenset({"Mesh", "Geometry"})

#: Endings of files that gmsh may merge.
_MERGED = (".step", ".stp", ".iges", ".igs", ".brep", ".stl", ".unv")

#: Longest text of gmsh's scanner; it takes what is left of a longer one for commands.
_LONGEST = 1000

#: Deepest chain of files that include each other, and characters of all of them.
_DEEPEST, _MOST_CHARACTERS = 10, 100_000_000

_TOKEN = re.compile(
    r"""(?P<space>[ \t\n\r\f]+)|(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<text>"[^"]*"|'[^']*')
    |(?P<number>\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?)|(?P<word>[A-Za-z_][A-Za-z0-9_]*)
    |(?P<sign>\.\.\.|::|\|\||&&|\+\+|--|[-+*/=!<>]=|>>|<<|[-+*/=!<>:;,.?%^~\#&|(){}\[\]@])""",
    re.VERBOSE | re.DOTALL,
)

#: Words at which gmsh goes on after what it skips.
_RESUMED = re.compile("EndIf|ElseIf|Else|EndFor|Return")

#: Gives the path under which gmsh gets a file to merge.
Given = Callable[[Path], Path]


@dataclass(frozen=True, slots=True)
class _Token:
    """A piece of a script.

    Attributes:
        kind: "text", "number", "word" or "sign"; "end" behind the last one.
        text: As it stands there.
        before: White space before it.
        line: Its line, from 1.
    """

    kind: str
    text: str
    before: str
    line: int


_END = _Token("end", "", "", 0)


def plain_script(path: Path, given: Given) -> str:
    """A script with what it includes, which builds a geometry and does nothing else.

    Args:
        path: The script.
        given: Gives the path under which gmsh gets a file to merge.

    Raises:
        MeshError: if a statement could do more; the message names it and its line.
    """
    return _plain(path, path.resolve().parent, given, 0)


def _plain(path: Path, folder: Path, given: Given, depth: int) -> str:
    if depth > _DEEPEST:
        raise MeshError(f"mesh file {path}: includes itself", code=Code.MESH_FILE)
    tokens = _tokens(path)
    parts: list[str] = []
    position = 0
    while position < len(tokens):
        token = tokens[position]
        following = [*tokens[position + 1 : position + 3], _END, _END]
        if token.text in ("Include", "Merge"):
            parts.append(token.before + _file(path, folder, token, following, given, depth))
            position += 3
            continue
        if token.kind == "word":
            _check_word(path, tokens, position, following)
        if token.kind == "text":
            _check_text(path, token)
        parts.append(token.before + token.text)
        position += 1
    return "".join(parts) + "\n"


def _tokens(path: Path) -> list[_Token]:
    """The pieces of a script, without comments."""
    if path.stat().st_size > _MOST_CHARACTERS:
        raise MeshError(
            f"mesh file {path}: has more than {_MOST_CHARACTERS} characters", code=Code.MESH_FILE
        )
    text = path.read_bytes().decode("latin-1").removeprefix("\xef\xbb\xbf")
    if "\0" in text:  # it would leave gmsh's parser unusable
        line = text.count("\n", 0, text.index("\0")) + 1
        raise MeshError(
            f"mesh file {path}, line {line}: gmsh cannot read it: is neither a mesh nor text",
            code=Code.MESH_FILE,
        )
    found, line, position, before = [], 1, 0, ""
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None or (text.startswith("/*", position) and match["comment"] is None):
            raise MeshError(
                f"mesh file {path}, line {line}: {text[position]!r} is no sign of gmsh's language",
                code=Code.MESH_FILE,
            )
        kind, piece = str(match.lastgroup), match[0]
        if kind in ("space", "comment"):
            before += piece.replace("\r", " ") if kind == "space" else _blank(piece)
        else:
            found.append(_Token(kind, piece, before, line))
            before = ""
        line += piece.count("\n")
        position = match.end()
    return found


def _blank(comment: str) -> str:
    return " " + "\n" * comment.count("\n")


def _check_word(path: Path, tokens: list[_Token], position: int, following: list[_Token]) -> None:
    """Refuse a word that is, or may be, a command of more than a geometry."""
    token, after = tokens[position], following[0]
    if token.text in _REFUSED:
        raise _refusal(path, token)
    known = token.text in _WORDS
    if after.kind == "text" or after.text in _TEXTS:
        if not known or (token.text in ("Macro", "Function") and after.kind == "text"):
            raise _refusal(path, token)
    elif after.kind == "word" and not known and after.text not in _WORDS:
        if position == 0 or tokens[position - 1].text not in ("Macro", "Function"):
            raise _refusal(path, token)
    if token.text in _PRINTING and _behind_brackets(tokens, position + 1).text != ";":
        raise _refusal(path, token)
    if after.text == "." and following[1].kind == "word":
        _check_option(path, tokens, position)


def _check_option(path: Path, tokens: list[_Token], position: int) -> None:
    """Refuse an option that is no number, but for those of mesh and geometry."""
    token = tokens[position]
    if position and tokens[position - 1].text == ".":
        return
    if token.text not in _OPTIONS:
        raise _refusal(path, token)
    if token.text in _TEXT_OPTIONS:
        return
    behind = [each for each in tokens[position + 3 : position + 6]] + [_END] * 3
    if behind[0].text != "=" or not (behind[1].kind == "number" or behind[1].text == "-"):
        raise _refusal(path, token)


def _check_text(path: Path, token: _Token) -> None:
    """Refuse a text in which gmsh could begin to read commands."""
    if len(token.text) > _LONGEST:
        raise MeshError(
            f"mesh file {path}, line {token.line}: a text of more than {_LONGEST} characters",
            code=Code.MESH_FILE,
        )
    if _RESUMED.search(token.text):
        raise _refusal(path, token)


def _behind_brackets(tokens: list[_Token], position: int) -> _Token:
    """The first token behind the brackets that open at a position."""
    depth = 0
    for token in tokens[position:]:
        if depth == 0 and token.text not in ("(", "["):
            return token
        depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
    return _END


def _file(
    path: Path, folder: Path, token: _Token, following: list[_Token], given: Given, depth: int
) -> str:
    """What stands for an included or merged file, which must lie in the folder of the script."""
    name, end = following[0], following[1]
    if name.kind != "text" or end.text != ";":
        raise _refusal(path, token)
    file = path.parent / name.text[1:-1]
    inside = "\0" not in name.text and file.resolve().is_relative_to(folder)
    if not inside or not file.is_file():
        raise MeshError(
            f"mesh file {path}, line {token.line}: {token.text} {name.text}: must be a file in "
            f"the folder of the script; {_TRUST}",
            code=Code.MESH_FILE,
        )
    if token.text == "Include" or file.suffix.lower() == ".geo":
        return "\n" + _plain(file, folder, given, depth + 1)
    if file.suffix.lower() not in (*_MERGED, ".msh"):
        raise MeshError(
            f"mesh file {path}, line {token.line}: Merge {name.text}: must end in "
            f"{', '.join(_MERGED)} or .msh; {_TRUST}",
            code=Code.MESH_FILE,
        )
    return f'Merge "{given(file)}";'


_TRUST = "scripts that you trust may do all with trust_script = true"


def _refusal(path: Path, token: _Token) -> MeshError:
    shown = token.text if len(token.text) <= 40 else token.text[:40] + "..."
    return MeshError(
        f"mesh file {path}, line {token.line}: {shown}: a script may build a geometry, not start "
        f"programs or read and write files; {_TRUST}",
        code=Code.MESH_FILE,
    )
