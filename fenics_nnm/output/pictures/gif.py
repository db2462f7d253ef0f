"""GIF files that go on and on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image as PillowImage

from fenics_nnm.output.pictures.renderer import Image
from fenics_nnm.output.pictures.style import OUTLINE, RED
from fenics_nnm.results.durable import replacing

#: How long a frame is shown in ms.
_SHOWN = 70

#: Rows of pure colours that the palette of a file must have, in pixels.
_SWATCH = 40


def write_gif(path: Path, frames: Sequence[Image]) -> None:
    """Write frames of one size as a GIF that goes on and on.

    Raises:
        OSError: if it cannot be written.
    """
    plain = PillowImage.Dither.NONE
    swatches = [
        np.full((_SWATCH, *frames[0].shape[1:]), [round(255 * part) for part in to_rgb(colour)])
        for colour in ("white", RED, OUTLINE, "black")
    ]
    shown = np.vstack([*frames[:: max(1, len(frames) // 4)], *swatches]).astype(np.uint8)
    palette = PillowImage.fromarray(shown).quantize(256, dither=plain)
    images = [
        PillowImage.fromarray(frame).quantize(palette=palette, dither=plain) for frame in frames
    ]
    keys = {"duration": _SHOWN, "loop": 0, "optimize": True}
    with replacing(path) as part:
        images[0].save(part, "GIF", save_all=True, append_images=images[1:], **keys)
