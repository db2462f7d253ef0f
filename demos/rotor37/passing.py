# %% [markdown]
# # NASA rotor 37 past a casing with four lobes
#
# The casing stands still, the blade turns in it: its lobes come by four times a turn, and where
# they reach the tip they drive the blade. The response over speed has a peak beyond the linear
# crossing of four times the speed and the first mode, as contact stiffens the blade, and falls at
# a fold. Coarse mesh of 6 mm, linear kinematics.
#
# The study file is `passing.toml`. Run with `python3 demos/rotor37/passing.py`; takes about half a
# minute.

# %%
import csv
import math
import os
from pathlib import Path

from fenics_nnm.cli import main

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "passing"

study = os.path.relpath(HERE / "passing.toml")
assert main(["response", "--output", str(RESULTS), study]) == 0

# %%
with (RESULTS / "response.csv").open() as file:
    rows = [row for row in csv.DictReader(file) if row["monitor"] == "contact 1"]


def turns(row: dict[str, str]) -> float:
    """Speed in rpm."""
    return float(row["speed_rad_s"]) * 30 / math.pi


highest = max(rows, key=lambda row: float(row["amplitude_m"]))
falls, comes_back = (turns(row) for row in rows if row["event"] == "fold in omega")
print(f"largest amplitude {1e3 * float(highest['amplitude_m']):.3f} mm at {turns(highest):.0f} rpm")
print(f"falls at {falls:.0f} rpm, comes back at {comes_back:.0f} rpm")

assert {row["status"] for row in rows} == {"converged"}  # linear kinematics are never verified
assert all("kinematics are linear" in row["reason"] and row["stability"] for row in rows)
assert max(float(row["energy_balance"]) for row in rows) < 1e-9
assert 17700 < turns(highest) < 17770
assert 17690 < comes_back < 17730 < falls < 17800
