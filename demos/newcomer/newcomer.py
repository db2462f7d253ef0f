# %% [markdown]
# # Three blades as a newcomer has them
#
# Each blade of `blades.py` goes from its STEP file to the report: check, run, the advice that the
# program prints once, run again, report. The table of docs/newcomer.md has what came out.
#
# Run `python3 demos/newcomer/newcomer.py`, or with some of the names fan, turbine, vane.

# %%
import csv
import json
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

HERE = Path(__file__).parent
RESULTS = HERE / "results"

# %% [markdown]
# What the first runs said, as options of the second ones: advice on fan and vane. The turbine blade
# "breaks before it touches": its casing is nearer.

# %%
ADVICE = {
    "fan": ["mode.harmonics=15", "mode.samples=256"],
    "turbine": ["contact.casing.radius=0.27505"],
    "vane": ["reduction.modes=10"],
}


# %%
def seconds(*words: str | Path) -> float:
    """Run a command of the program and return its time; a run may end without all points."""
    begin = time.perf_counter()
    ended = subprocess.run([sys.executable, "-m", "fenics_nnm", *map(str, words)], check=False)
    if ended.returncode > 1:
        sys.exit(f"fenics-nnm {' '.join(map(str, words))} ended with {ended.returncode}")
    return time.perf_counter() - begin


def statuses(folder: Path) -> str:
    with (folder / "backbone.csv").open() as file:
        counts = Counter(row["status"] for row in csv.DictReader(file))
    return ", ".join(f"{count} {status}" for status, count in counts.items())


def row(name: str) -> str:
    """A line of the table."""
    study, first, second = HERE / f"{name}.toml", RESULTS / name, RESULTS / f"{name}-advised"
    checked = seconds("check", study, "--picture", RESULTS / f"{name}.png")
    run = seconds("run", study, "--output", first)
    changes = [word for change in ADVICE[name] for word in ("--set", change)]
    again = seconds("run", study, *changes, "--output", second)
    reported = seconds("report", second)
    summary = json.loads((first / "summary.json").read_text())
    cells = (
        name,
        summary["dofs"],
        f"{checked:.0f}",
        f"{run:.0f}",
        statuses(first),
        "; ".join(summary["advice"]),
        ", ".join(ADVICE[name]),
        f"{again:.0f}",
        statuses(second),
        f"{reported:.0f}",
    )
    return "| " + " | ".join(map(str, cells)) + " |"


# %%
if __name__ == "__main__":
    subprocess.run([sys.executable, HERE / "blades.py"], check=True)
    rows = [row(name) for name in sys.argv[1:] or ADVICE]
    print(
        "| blade | degrees of freedom | check (s) | run (s) | points of the first run "
        "| message of the program | change before the second run | run again (s) "
        "| points of the second run | report (s) |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    print("\n".join(rows))
