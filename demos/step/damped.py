# %% [markdown]
# # A damped blade against a stop
#
# Undamped motions of bare metal against a stop come in families: at one energy the blade has 405,
# 399 or 397 Hz with 4, 10 or 20 modes. With the damping of a test rig there is one to follow
# from heavy damping down (docs/damped_backbone.md), and its frequency settles with the modes.
#
# `python3 demos/step/damped.py` runs `damped.toml` with 3 % and 1 % of critical damping and several
# numbers of modes and harmonics, some minutes a run, and prints a table of frequencies. It ends
# with 1 if they are more than 0.5 % apart. `damped.py 0.003` takes another damping ratio.

# %%
import runpy
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fenics_nnm as nnm

HERE = Path(__file__).parent

#: Modes, harmonics and samples of the runs, and the gamma ratios of the table.
NUMBERS = ((20, 25, 256), (30, 40, 512), (40, 50, 512), (40, 80, 512), ("auto", "auto", "auto"))
RATIOS = (1.2, 1.4, 2.0)

#: Largest part that the frequencies at one gamma ratio may be apart.
APART = 5e-3


# %%
def frequencies(study: nnm.Study) -> dict[float, tuple[float, str]]:
    """Frequency in Hz and status of the motions of a study, by gamma ratio."""
    branch = study.branch()
    rows = zip(branch.gamma_ratio, branch.frequency_Hz, branch.status, strict=True)
    return {round(float(ratio), 6): (float(hertz), str(status)) for ratio, hertz, status in rows}


def runs(study: nnm.Study, damping: float) -> Iterator[dict[float, tuple[float, str]]]:
    """Print a row of the table for each run, and give what it found."""
    for modes, harmonics, samples in NUMBERS:
        begun = time.process_time()
        values: dict[str, Any] = {"reduction.modes": modes, "mode.harmonics": harmonics}
        values |= {"mode.samples": samples, "damping.ratio": damping}
        try:
            found = frequencies(study.with_values(values))
        except nnm.NonlinearModeError as error:
            print(f"| {100 * damping:g} % | {modes}, {harmonics} | {error} | | | |", flush=True)
            continue
        cells = [f"{found[r][0]:.2f}, {found[r][1]}" if r in found else "-" for r in RATIOS]
        seconds = time.process_time() - begun
        row = f"{100 * damping:g} % | {modes}, {harmonics} | {' | '.join(cells)} | {seconds:.0f} s"
        print(f"| {row} |", flush=True)
        yield found


def main(dampings: list[float]) -> int:
    """Print the table; 1 if frequencies are too far apart, or one is missing."""
    runpy.run_path(str(HERE / "blade.py"))  # writes the STEP file
    study, worst, missing = nnm.read_study(HERE / "damped.toml"), 0.0, 0
    print("docs: damped_blade")
    heads = " | ".join(f"frequency (Hz) and status at gamma ratio {ratio}" for ratio in RATIOS)
    print(f"| damping ratio | modes J, harmonics N | {heads} | CPU time |")
    print("|---|---|---|---|---|---|")
    for damping in dampings:
        every = list(runs(study, damping))
        for ratio in RATIOS:
            hertz = [found[ratio][0] for found in every if ratio in found]
            missing += len(NUMBERS) - len(hertz)
            worst = max(worst, max(hertz) / min(hertz) - 1 if hertz else 0.0)
    print(f"\nlargest difference of frequencies: {100 * worst:.2f} %; missing motions: {missing}")
    return int(worst > APART or missing > 0)


if __name__ == "__main__":
    sys.exit(main([float(word) for word in sys.argv[1:]] or [0.03, 0.01]))
