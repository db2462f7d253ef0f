"""Sphinx's settings for the pages as a site; `docs/site/build.py` runs it."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

#: Pages by chapter, in the order of the site's navigation.
NAVIGATION = {
    "Begin": (
        "docs/installation",
        "docs/user_guide",
        "docs/sweeps",
        "docs/newcomer",
        "docs/large_models",
        "docs/python",
        "docs/gallery",
        "docs/faq",
    ),
    "Reference": (
        "docs/study_file",
        "docs/study_contact",
        "docs/study_driven",
        "docs/study_matrices",
        "docs/loads",
        "docs/mesh_files",
        "docs/blade",
        "docs/results",
        "docs/results_driven",
        "docs/families",
        "api",
        "docs/glossary",
        "docs/security",
        "meshes/README",
    ),
    "Theory": (
        "docs/theory",
        "docs/theory_motion",
        "docs/driven_motions",
        "docs/damped_backbone",
        "docs/passing_casings",
    ),
    "Verification": (
        "docs/verification",
        "docs/verification_bodies",
        "docs/verification_contact",
        "docs/verification_random",
        "docs/paper_figures",
        "benchmarks/README",
    ),
}

project = "fenics_nnm"
project_copyright = "the authors of fenics_nnm, MIT licence"
root_doc = "README"
include_patterns = ["README.md", "api.md", "docs/*.md", "meshes/*.md", "benchmarks/*.md"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 6  # as GitHub has them
suppress_warnings = ["myst.header"]  # README's table of contents is the navigation

html_theme = "furo"
html_title = "fenics_nnm"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": False}

linkcheck_timeout = 20

add_module_names = False
default_role = "code"
smartquotes = False  # q' is a derivative
napoleon_include_special_with_doc = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
#: What the face is a face of: it is described without being imported.
autodoc_mock_imports = [
    "h5py",
    "matplotlib",
    "mpi4py",
    "fenics_nnm.backbone",
    "fenics_nnm.fem",
    "fenics_nnm.fields",
    "fenics_nnm.interrupts",
    "fenics_nnm.output",
    "fenics_nnm.response",
    "fenics_nnm.results",
    "fenics_nnm.run",
    "fenics_nnm.running",
    "fenics_nnm.structure",
    "fenics_nnm.study",
]


def _navigation() -> str:
    """The pages as tables of contents that are not shown on the first page."""
    return "\n".join(
        f"\n```{{toctree}}\n:hidden:\n:caption: {chapter}\n\n" + "\n".join(pages) + "\n```\n"
        for chapter, pages in NAVIGATION.items()
    )


def _add_navigation(app: object, name: str, source: list[str]) -> None:
    if name == root_doc:
        source[0] += _navigation()


def setup(app: object) -> None:
    """Connect what is done while pages are read."""
    app.connect("source-read", _add_navigation)  # type: ignore[attr-defined]
