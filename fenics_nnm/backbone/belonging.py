"""By what a motion is known to be one of the branch of the followed mode."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_nnm.mechanics.rest import RestState

#: With points that are closed or touch at rest the mode alone opens and closes others ...
_SMALLEST_CONTACT_PRESSED = 0.05

#: ... and the shape changes as they open or close.
_SMALLEST_SHARE_PRESSED = 0.1


@dataclass(frozen=True, slots=True)
class Belonging:
    """Thresholds that decide which motion is meant.

    Attributes:
        linear_until: Gamma ratio where the motion of the followed mode ceases to be linear.
        lifts_off: Whether closed points lift off along the branch. There harmonics of the motion
            meet modes at once if these have frequencies near multiples of the first; far above,
            the forces at rest hardly matter, so the branch is better followed from there down.
        smallest_contact: A motion with less than this part of the contact of the followed mode
            alone avoids it.
        smallest_share: A motion whose followed mode, in its first harmonic, has less than this
            share of m^ has left it.
        suspect: A motion with more than this part of the energy that marks a resonance is looked
            at twice.
        frequency_jump: Where closed points lift off, a larger relative change of frequency asks
            for a second look.
        far: There a motion whose frequency is farther from that of its neighbour is hardly of its
            branch.
    """

    linear_until: float
    lifts_off: bool
    smallest_contact: float = 0.3
    smallest_share: float = 0.5
    suspect: float = 0.6
    frequency_jump: float = 0.02
    far: float = 0.05

    @classmethod
    def about(cls, rest: RestState, mode: int) -> Belonging:
        """What holds for a mode about a state of rest."""
        linear_until = 1.0 if rest.is_linear(mode) else 0.0
        lifts_off = bool(rest.closed.any())
        if not rest.pressed:
            return cls(linear_until, lifts_off)
        return cls(
            linear_until,
            lifts_off,
            smallest_contact=_SMALLEST_CONTACT_PRESSED,
            smallest_share=_SMALLEST_SHARE_PRESSED,
        )

    def refusal(self, contact: float, share: float) -> str:
        """Why a converged motion is not on the branch of the followed mode; empty if it is.

        Args:
            contact: Its contact over that of the followed mode alone.
            share: Share of its kinetic energy in the first harmonic of the followed mode.
        """
        if contact < self.smallest_contact:
            return (
                f"converged to a motion with {contact:.2g} of the contact that the followed mode "
                "alone has at this energy: an internal resonance lets it avoid the obstacle"
            )
        if share < self.smallest_share:
            return (
                f"converged to a motion that carries only {share:.0%} of its kinetic energy in the "
                "first harmonic of the followed mode: another family (internal resonance)"
            )
        return ""
