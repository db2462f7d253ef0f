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
        ignored: Why the damping of the study is ignored, or nothing.
    """

    light: LightDamping | None = None
    maker: DampedMaker | None = None
    ratios: tuple[float, ...] = ()
    objection: str = ""
    ignored: str = ""

    @property
    def follows(self) -> bool:
        """Whether damped motions are followed."""
        return self.maker is not None

    @property
    def in_summary(self) -> dict[str, str]:
        """What summary.json says of it; nothing of a study without damping."""
        if self.ignored:
            return {"damping": f"ignored: {self.ignored}"}
        if self.light is None:
            return {}
        undamped = self.objection or "continuation.damped = false"
        return {"damping": "followed" if self.follows else f"to first order: {undamped}"}

    @property
    def warning(self) -> str:
        """What is to be said before a run, or nothing."""
        if self.ignored:
            return f"the damping of the study is ignored: {self.ignored}"
        if self.objection:
            return (
                f"{self.objection}: motions are undamped, and damping_ratio and resonance_force_N "
                "of first order"
            )
        return ""


#: Of a study without damping.
UNDAMPED = DampedRun()
