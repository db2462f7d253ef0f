"""What the damping of a study does in a run."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.backbone.damped_branch import DampedMaker
from fenics_nnm.mechanics.light_damping import LightDamping


@dataclass(frozen=True, slots=True)
class DampedRun:
    """What the damping of a study does in a run.

    Attributes:
        light: Damping for undamped motions; None without any, see `structure.light_damping`.
        maker: Makes damped motions; None where they are not followed.
        ratios: Gamma ratios of the damped motions.
        objection: Why they are not, though there is damping, or nothing.
    """

    light: LightDamping | None = None
    maker: DampedMaker | None = None
    ratios: tuple[float, ...] = ()
    objection: str = ""


#: Of a study without damping.
UNDAMPED = DampedRun()
