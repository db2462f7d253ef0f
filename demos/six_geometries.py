# %% [markdown]
# # Six geometries, from a file to a report
#
# A blade in a STEP file, a bracket in an .inp file, a shrouded blade in the plane, a bladed sector
# with its root block, NASA rotor 67, and a tuning fork with two facing pads. Each is checked with a
# picture of its groups, run, plotted and reported by the command line, untouched by hand. Then the
# advice of the run is followed once: the numbers that it proposes are set, and it runs again.
#
# Run with `python3 demos/six_geometries.py`, or with some names; results go to demos/NAME/results.

# %%
import csv
import re
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass
from json import loads
from pathlib import Path

HERE = Path(__file__).parent
GOOD = {"verified", "converged", "inside resonance"}


@dataclass(frozen=True)
class Geometry:
    """A study, and what must come out.

    Attributes:
        study: Study file below demos.
        title: What it is.
        first: Band of the frequency of the linear mode that is followed, Hz.
        last: Band of the frequency ratio of the point of greatest energy.
        points: Contact points.
        verified: Least number of verified points.
        maker: Script that writes the mesh or geometry, if any.
    """

    study: str
    title: str
    first: tuple[float, float]
    last: tuple[float, float]
    points: int
    verified: int
    maker: str | None = None

    @property
    def name(self) -> str:
        return Path(self.study).parent.name


# %% [markdown]
# The linear frequencies depend on geometry, mesh and material, the last ratios on the whole chain.
# Bands are 1 % of a frequency and some percent of a ratio.

# %%
GEOMETRIES = (
    Geometry(
        "step/blade.toml", "blade from a STEP file", (367, 374), (1.08, 1.14), 8, 2, "step/blade.py"
    ),
    Geometry(
        "inp/bracket.toml",
        "bracket from an .inp file",
        (625, 639),
        (1.07, 1.11),
        6,
        8,
        "inp/bracket.py",
    ),
    Geometry(
        "shroud/shroud.toml", "shroud between two stops, plane", (244, 249), (1.72, 1.83), 10, 8
    ),
    Geometry(
        "sector/sector.toml", "bladed sector with root block", (625, 637), (1.006, 1.015), 20, 12
    ),
    Geometry("rotor67/rotor67.toml", "NASA rotor 67", (367, 374.5), (1.008, 1.02), 24, 12),
    Geometry("fork/fork.toml", "tuning fork, two facing pads", (452, 462), (1.17, 1.24), 9, 8),
)


# %%
def command(*words: str | Path) -> None:
    """Run a command of the program; anything but success ends the study."""
    arguments = [sys.executable, "-m", "fenics_nnm", *map(str, words)]
    ended = subprocess.run(arguments, capture_output=True, text=True, check=False)
    if ended.returncode or "Warning" in ended.stderr:
        shown = " ".join(map(str, words))
        sys.exit(f"fenics-nnm {shown} ended with {ended.returncode}:\n{ended.stderr}")


def from_file_to_report(geometry: Geometry) -> Path:
    """Run a study by the command line and return its results folder."""
    study = HERE / geometry.study
    results = study.parent / "results"
    results.mkdir(exist_ok=True)
    if geometry.maker:
        subprocess.run([sys.executable, HERE / geometry.maker], check=True, capture_output=True)
    folder = results / study.stem
    command("check", study, "--picture", results / "groups.png")
    command("run", study, "--output", folder)
    command("plot", folder)
    command("report", folder)
    return folder


def statuses(folder: Path) -> str:
    """How many points of a branch have each status."""
    with (folder / "backbone.csv").open() as file:
        counts = Counter(row["status"] for row in csv.DictReader(file))
    return ", ".join(f"{count} {status}" for status, count in counts.items())


def proposed(folder: Path) -> list[str]:
    """Numbers that a run proposes to set, as KEY=VALUE."""
    lines = loads((folder / "summary.json").read_text())["advice"]
    pairs = (pair for line in lines for pair in re.findall(r"(\w+\.\w+) = (\d+)", line))
    return [f"{key}={value}" for key, value in pairs]


def advised(geometry: Geometry, folder: Path) -> str:
    """What was set after the advice of a run, and the statuses that this gives."""
    settings = proposed(folder)
    if not settings:
        return "none | "
    again = folder.with_name(f"{folder.name}-advised")
    words = [word for each in settings for word in ("--set", each)]
    ended = subprocess.run(
        [
            sys.executable,
            "-m",
            "fenics_nnm",
            "run",
            HERE / geometry.study,
            *words,
            "--output",
            again,
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    if ended.returncode > 1:
        sys.exit(f"{geometry.name} with {', '.join(settings)}: {ended.stderr}")
    return f"{', '.join(f'`{each}`' for each in settings)} | {statuses(again)}"


def within(value: float, band: tuple[float, float]) -> bool:
    return band[0] < value < band[1]


def judge(geometry: Geometry, folder: Path, seconds: float) -> None:
    """Print a row of the table, and check the results against what must come out."""
    summary = loads((folder / "summary.json").read_text())
    with (folder / "backbone.csv").open() as file:
        rows = list(csv.DictReader(file))
    statuses = Counter(row["status"] for row in rows)
    last = max(rows, key=lambda row: float(row["gamma_ratio"]))
    frequency, ratio = float(last["frequency_Hz"]), float(last["frequency_ratio"])
    linear = frequency / ratio
    size = (folder / "report.html").stat().st_size
    verdicts = ", ".join(f"{count} {status}" for status, count in statuses.items())
    print(
        f"| {geometry.title} | {summary['dofs']} | {summary['contact_points']} | {linear:.2f} "
        f"| {frequency:.2f} | {ratio:.3f} | {verdicts} | {seconds:.0f} s | {size / 1e6:.1f} MB "
        f"| {advised(geometry, folder)} |",
        flush=True,
    )
    assert within(linear, geometry.first), f"{geometry.name}: first frequency {linear} Hz"
    assert within(ratio, geometry.last), f"{geometry.name}: last frequency ratio {ratio}"
    assert summary["contact_points"] == geometry.points
    assert len(rows) >= 7
    assert set(statuses) <= GOOD, verdicts
    assert statuses["verified"] >= geometry.verified, verdicts
    assert 0.3e6 < size < 30e6, f"{geometry.name}: report of {size} bytes"
    assert "<img" in (folder / "report.html").read_text("utf-8")
    assert (folder.parent / "groups.png").stat().st_size > 20_000


# %%
if __name__ == "__main__":
    chosen = set(sys.argv[1:])
    unknown = chosen - {geometry.name for geometry in GEOMETRIES}
    if unknown:
        sys.exit(f"no geometry {', '.join(sorted(unknown))}")
    shown = "" if chosen else "docs: six_geometries\n"
    print(
        f"{shown}| study | degrees of freedom | contact points | linear frequency (Hz) "
        "| frequency at the largest energy (Hz) | frequency ratio at the largest energy "
        "| points of the first run | elapsed time | size of the report | proposed values "
        "| points of the second run |\n" + "|---" * 11 + "|"
    )
    for geometry in GEOMETRIES:
        if not chosen or geometry.name in chosen:
            begin = time.perf_counter()
            folder = from_file_to_report(geometry)
            judge(geometry, folder, time.perf_counter() - begin)
