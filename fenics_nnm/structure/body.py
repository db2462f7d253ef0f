"""From the sections of a study about its body to theory, materials, masses and springs."""

from __future__ import annotations

from collections.abc import Iterator

from fenics_nnm.fem.attachment import Attachment
from fenics_nnm.fem.loads import Pressure
from fenics_nnm.fem.pushes import FacetPressure, Force, Push, ShakenBase
from fenics_nnm.fem.regions import Region
from fenics_nnm.fem.solid import Body
from fenics_nnm.structure.rigid_facets import rigid_facets
from fenics_nnm.study import MeshStudy
from fenics_nnm.study.record import fitted


def body_of(study: MeshStudy, dim: int) -> Body:
    """The body of a study on a mesh of some dimension.

    Raises:
        ModelError: if a point or a stiffness has too few components.
    """
    return Body(
        theory=study.body.theory,
        regions=tuple(Region(each.material, each.cells or ()) for each in study.material),
        extent=study.body.extent,
        degree=study.body.degree,
        attachments=(*_masses(study, dim), *_springs(study, dim)),
        constraints=rigid_facets(study, dim),
    )


def excitations_of(study: MeshStudy, dim: int) -> Iterator[Push]:
    """What drives the body of a study on a mesh of some dimension.

    Raises:
        ModelError: if a point, a force or an acceleration has too few components.
    """
    for number, each in enumerate(study.excitation, start=1):
        key = f"excitation[{number}]" if len(study.excitation) > 1 else "excitation"
        point = _point(each.at, dim, key)
        facets = each.facets or ()
        if each.pressure is not None:
            yield FacetPressure(Pressure(key, facets, each.pressure))
        elif each.base is not None:
            yield ShakenBase(fitted(each.base, dim, f"{key}.base"))
        else:
            force = fitted(each.force or (), dim, f"{key}.force")
            yield Force(Attachment(key, "force", force, point, facets))


def dashpots_of(study: MeshStudy, dim: int) -> tuple[Attachment, ...]:
    """The dashpots of a study on a mesh of some dimension.

    Raises:
        ModelError: if a point or a damping has too few components.
    """
    found = []
    for number, each in enumerate(study.dashpot, start=1):
        key = f"dashpot[{number}]"
        point = _point(each.at, dim, key)
        values = fitted(each.damping, dim, f"{key}.damping")
        found.append(Attachment(key, "dashpot", values, point, each.facets or ()))
    return tuple(found)


def monitors_of(study: MeshStudy, dim: int) -> tuple[Attachment, ...]:
    """The places that a study watches on a mesh of some dimension.

    Raises:
        ModelError: if a point or a direction has too few components.
    """
    found = []
    for number, each in enumerate(study.monitor, start=1):
        key = f"monitor[{number}]"
        point = _point(each.at, dim, key)
        direction = fitted(each.direction, dim, f"{key}.direction")
        found.append(Attachment(key, "monitor", direction, point, each.facets or ()))
    return tuple(found)


def _point(at: tuple[float, ...] | None, dim: int, key: str) -> tuple[float, ...]:
    """Coordinates of a section with a point; none of one with facets."""
    return () if at is None else fitted(at, dim, f"{key}.at")


def _masses(study: MeshStudy, dim: int) -> Iterator[Attachment]:
    for number, each in enumerate(study.mass, start=1):
        key = f"mass[{number}]"
        point = _point(each.at, dim, key)
        yield Attachment(key, "mass", (each.mass,) * dim, point, each.facets or ())


def _springs(study: MeshStudy, dim: int) -> Iterator[Attachment]:
    for number, each in enumerate(study.spring, start=1):
        key = f"spring[{number}]"
        point = _point(each.at, dim, key)
        per_area = each.foundation is not None
        name = "foundation" if per_area else "stiffness"
        values = fitted(each.values or (0.0,) * dim, dim, f"{key}.{name}")
        cubic = fitted(each.cubic, dim, f"{key}.cubic") if each.cubic else ()
        yield Attachment(key, "spring", values, point, each.facets or (), per_area, cubic)
