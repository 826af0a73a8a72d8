"""tests/bench/particles/predicted.py: the order of flocks.py beside the prediction of a table of coefficients.

Usage: predicted.py --drover PROGRAM --table TABLE.h5 --flocks FOLDER/flocks.json

For each case point-BEADS-RODS: g and the order of as few rods in mean field (drover boundary TABLE --cell 45), and the
order of the run, the mean of its second half.  The g of the run is that whose few rods have its order.  A point is on
the line within two standard errors of g = 2; elsewhere its prediction is right or wrong, or within the error of the
line where the prediction is. """
import argparse
import json
import subprocess
import sys

LINE = 2.0  # g of the threshold
ERRORS = 2.0


def predictions(arguments, points):
    words = [arguments.drover, "boundary", arguments.table, "--cell", "45", "--json"]
    for beads, rods in points:
        words += ["--point", f"{beads},{rods}"]
    return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)["cells"]


def side(g, error):
    """-1 and 1: below and above the line; 0: within error of it."""
    return 0 if abs(g - LINE) <= ERRORS * error else 1 if g > LINE else -1


def verdict(row, found, error):
    """The order of the line is that of these rods at g = 2; the run fluctuates about its mean."""
    predicted = side(row["alignment"], row["alignment_error"])
    line = row["order_line"]
    seen = 0 if abs(found - line) <= ERRORS * error else 1 if found > line else -1
    if predicted == 0 or seen == 0:
        return "within error of the line"
    return "right" if predicted == seen else "wrong"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--table", required=True, help="table of coefficients (HDF5)")
    parser.add_argument("--flocks", required=True, help="flocks.json of flocks.py")
    arguments = parser.parse_args()
    with open(arguments.flocks) as file:
        runs = {tuple(map(float, name.split("-")[1:])): row for name, row in json.load(file).items()
                if name.startswith("point-")}
    print("| Phi_b | Phi_r | rods | g | P of these rods | at g -+ error | P in the run | (run - prediction)/error |"
          " |\n|---|---|---|---|---|---|---|---|---|")
    counts = {}
    for (beads, rods), row in zip(sorted(runs), predictions(arguments, sorted(runs))):
        run = runs[beads, rods]
        found, error = float(run["order_mean_second_half"]), float(run["order_error"])
        far = row["order_high"] if found > row["order"] else row["order_low"]
        apart = (found - row["order"]) / max((error**2 + (far - row["order"])**2)**0.5, 1e-9)
        words = verdict(row, found, error)
        counts[words] = counts.get(words, 0) + 1
        print(f"| {beads:g} | {rods:g} | {row['rods']:g} | {row['alignment']:.2f}({row['alignment_error']:.2f}) | "
              f"{row['order']:.2f} | {row['order_low']:.2f} to {row['order_high']:.2f} | {found:.2f}({error:.2f}) | "
              f"{apart:+.1f} | {words} |")
    print("\n" + ", ".join(f"{count} {words}" for words, count in sorted(counts.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
