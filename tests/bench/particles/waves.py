"""tests/bench/particles/waves.py: couplings of order and flow from the fluctuations of beds without a flock.

Usage: waves.py --drover PROGRAM --output FOLDER [--only POINT ...]

Runs matched rods in beads from disorder for 400 s (5 to 10 minutes of one core each) at area fractions without a flock,
and fits the means of order and bead velocity (drover fit) at several spacings of the frames: a second route to the
coefficients of models/matched.calibration, which are from aligned or single rods.  FOLDER/waves.json gets an entry for
each point and spacing; a point that is there is not run again.
"""
import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from flocks import MODELS

KEYS = ["relaxation.rate", "weathercock.strength", "drag.coefficient", "driving.strength"]
POINTS = {f"{beads}-0.05": (beads, 0.05) for beads in (0.2, 0.4, 0.5, 0.6)}
FRAME, SPACINGS, WARM_UP = 0.1, (0.5, 1.0, 2.0, 4.0), 20.0


def settings(*pairs):
    return [word for pair in pairs for word in ("--set", pair)]


def run(program, beads, rods, archive):
    words = settings(f"beads.area_fraction={beads}", f"rods.area_fraction={rods}", "time.dt=5e-5",
                     "contacts.substep=5e-5", "time.end=400.0", f"output.frame_every={FRAME}", "run.threads=1")
    subprocess.run([program, "run", str(MODELS / "bead-flock.toml"), "--quiet", "--output", str(archive), *words],
                   check=True, stdout=subprocess.DEVNULL)


def fit(program, beads, rods, archive, spacing):
    """Estimates by key, and alpha/Gamma, whose error is smaller than those of its parts: they go together."""
    words = settings(f"calibrated.bead_area_fraction={beads}", f"calibrated.rod_area_fraction={rods}")
    printed = subprocess.run([program, "fit", str(archive), *KEYS, "--scene", str(MODELS / "calibrated-flock.toml"),
                              *words, "--max-wavenumber", "0.1", "--from", str(WARM_UP), "--every",
                              str(round(spacing / FRAME)), "--json"], check=True, capture_output=True, text=True)
    rows = json.loads(printed.stdout)["coefficients"]
    found = {row["key"]: {"value": row["value"], "error": row["error"], "table": row["scene"]} for row in rows}
    drag, driving = rows[KEYS.index("drag.coefficient")], rows[KEYS.index("driving.strength")]
    parts = [row["error"] / row["value"] for row in (drag, driving)]
    together = drag["correlations"][KEYS.index("driving.strength")]
    ratio = driving["value"] / drag["value"]
    error = ratio * math.sqrt(max(parts[0]**2 + parts[1]**2 - 2.0 * together * parts[0] * parts[1], 0.0))
    found["driving/drag"] = {"value": ratio, "error": error, "table": driving["scene"] / drag["scene"]}
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path, help="folder of the table")
    parser.add_argument("--only", nargs="*", default=list(POINTS), choices=list(POINTS), help="points to run")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    file = arguments.output / "waves.json"
    rows = json.loads(file.read_text()) if file.exists() else {}
    for name in arguments.only:
        if name in rows:
            continue
        with tempfile.TemporaryDirectory(dir=arguments.output) as folder:
            archive = Path(folder) / "run.h5"
            run(arguments.drover, *POINTS[name], archive)
            rows[name] = {str(spacing): fit(arguments.drover, *POINTS[name], archive, spacing) for spacing in SPACINGS}
        file.write_text(json.dumps(rows, indent=1) + "\n")
        print(name, {key: (round(one["value"], 4), round(one["error"], 4), round(one["table"], 4))
                     for key, one in rows[name]["2.0"].items()}, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
