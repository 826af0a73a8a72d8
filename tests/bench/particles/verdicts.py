"""tests/bench/particles/verdicts.py: what the paper says in each figure, as a criterion on a number, and whether the
kept runs meet it: those of its rods as printed and those of the matched rods.

Usage: verdicts.py [--data FOLDER]

Prints a row for each claim; notebooks/paper.ipynb shows the same rows below its pictures.  A claim agrees, agrees in
part or misses; its criterion is in its docstring and is the same for both kinds of rods.  A claim whose runs are
not kept is "not run"."""
import argparse
import csv
import json
import math
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

import drover

HERE = Path(__file__).resolve().parent
MODELS = HERE.parents[2] / "models"
WORDS = ("note", "quantity", "body", "program", "friction", "order", "bearing")
AGREES, IN_PART, MISSES, NOT_RUN = "agrees", "agrees in part", "misses", "not run"


def table(path):
    """Columns of a kept table: numbers, or words of the columns in WORDS."""
    with open(path, encoding="utf-8") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return {name: np.array([row[name] if name in WORDS else float(row[name] or "nan") for row in rows])
            for name in rows[0]}


class NotKept(Exception):
    """The runs that a claim asks for are not among the data."""


@dataclass(frozen=True)
class Found:
    """A claim beside what was found."""
    text: str
    verdict: str

    @staticmethod
    def of(text, *conditions):
        """All, some or none of the conditions hold."""
        held = sum(map(bool, conditions))
        return Found(text, AGREES if held == len(conditions) else IN_PART if held else MISSES)


class Rods:
    """The kept runs of one kind of rods: `name` is matched or printed."""

    def __init__(self, name, data):
        self.name, self.data, self.folder = name, data, data if name == "matched" else data / "printed"
        self.table_file = MODELS / f"{'matched' if name == 'matched' else 'paper'}.calibration" / "table.h5"

    def _flocks(self, folder):
        return json.loads((self.data / folder / "flocks.json").read_text())

    def keeps(self, what):
        """Whether the runs of one of its properties are kept."""
        try:
            getattr(self, what)
        except NotKept:
            return False
        return True

    def _kept(self, folder, name):
        if not (path := self.folder / folder / name).exists():
            raise NotKept(path)
        return path

    @cached_property
    def cases(self):
        """Rows of flocks.json by the name of the case."""
        return self._flocks("flocks" if self.name == "matched" else "printed")

    def case(self, name):
        """A row of flocks.json."""
        if name not in self.cases:
            raise NotKept(name)
        return self.cases[name]

    def order(self, case):
        """Mean of P over the second half of a case."""
        return float(self.case(case)["order_mean_second_half"])

    @cached_property
    def plane(self):
        """{(Phi_b, Phi_r): [P of each seed]} in the periodic cell of 45 mm."""
        found = {}
        if self.name == "matched":  # runs of 200 s where there are, else of 100 s
            named = {name: row for name, row in {**self.cases, **self._flocks("held")}.items()
                     if name.startswith(("point-", "seed-"))}
            places = {name: name.split("-")[1:3] for name in named}
        else:
            named = {name: row for name, row in self.cases.items() if name[0].isdigit()}
            places = {name: name.split("-")[:2] for name in named}
        for name in sorted(named):
            point = tuple(map(float, places[name]))
            found.setdefault(point, []).append(float(named[name]["order_mean_second_half"]))
        return found

    @cached_property
    def flowers(self):
        """{number: P about the centre, its series} of the flowers that were run."""
        folder = self.data / "flowers" if self.name == "matched" else self.folder
        rows = self._flocks("flowers") if self.name == "matched" else self.cases
        found = {int(name.split("-")[1]): (float(row["order_mean_second_half"]), table(folder / f"{name}.csv"))
                 for name, row in rows.items() if name.startswith("flower-") and name.split("-")[1].isdigit()}
        if not found:
            raise NotKept("flower-1")
        return found

    @cached_property
    def dense(self):
        """The series of a flock at (.60, .11)."""
        return table(self.folder / ("flocks/matched-dense.csv" if self.name == "matched" else "0.6-0.11-1.csv"))

    @cached_property
    def poor(self):
        """The series of rods at (.20, .11)."""
        return table(self.folder / ("flocks/matched-poor.csv" if self.name == "matched" else "0.2-0.11-1.csv"))

    @property
    def chance(self):
        """P of as many random directions."""
        return float(self.case("matched-poor" if self.name == "matched" else "0.2-0.11-1")["random_mean"])

    @cached_property
    def coefficients(self):
        """{name: {"beads", "value", "error"}} of the table, at .11 of rods where it depends on them."""
        found = {}
        for name, entry in drover.info(self.table_file)["coefficients"].items():
            points = [point for point in entry["points"]
                      if point["value"] is not None and point.get("rod_area_fraction", 0.11) == 0.11]
            beads, values, errors = ([point[key] for point in points]
                                     for key in ("bead_area_fraction", "value", "error"))
            found[name] = {"beads": beads, "value": np.array(values, float), "error": np.array(errors, float)}
        return found

    def coefficient(self, name):
        """One of the coefficients, at area fractions where it was measured."""
        if name not in self.coefficients:
            raise NotKept(name)
        return self.coefficients[name]

    @cached_property
    def onset(self):
        """What the table predicts (drover boundary)."""
        return drover.onset(self.table_file, cell=45.0)

    @cached_property
    def correlations(self):
        """{Phi_b: {quantity: (place, value)}} of a cell of 90 mm."""
        found = {}
        for beads in (0.2, 0.4, 0.6):
            rows = table(self._kept("correlations", f"correlations-{beads}.csv"))
            found[beads] = {
                name: (rows["place_mm"][rows["quantity"] == name], rows["value"][rows["quantity"] == name])
                for name in np.unique(rows["quantity"])}
        return found

    @cached_property
    def strays(self):
        """{free, held: (how fast stray rods turn back against the angle, its slope with the sine, its error)}."""
        found = {}
        for beads in ("free", "held"):
            rows = table(self._kept("stray", f"turning-{beads}.csv"))
            sine = np.sin(np.radians(rows["angle_deg"]))
            known = rows["error"] > 0.0
            weight = (sine[known] / rows["error"][known])**2
            found[beads] = (rows, np.sum(weight * rows["rate_rad_s"][known] / sine[known]) / weight.sum(),
                            weight.sum()**-0.5)
        return found

    @cached_property
    def wakes(self):
        """{Phi_b: (the flow around a rod, its speeds in rings of 1 mm from 2.5 mm, their errors)}."""
        return {beads: speeds_of(table(self._kept("wake", f"wake-{beads}.csv"))) for beads in (0.5, 0.6, 0.7)}


def speeds_of(flow):
    """A flow around a rod, and its root mean square in each ring with error.  The flow is its own mirror image; what
    the two sides differ by is noise, whose square adds to that of the flow and is subtracted."""
    ahead, left, along, across = (flow[name] for name in ("ahead_mm", "left_mm", "along_mm_s", "across_mm_s"))
    place = {(round(x, 6), round(y, 6)): k for k, (x, y) in enumerate(zip(ahead, left))}
    mirror = np.array([place.get((round(x, 6), round(-y, 6)), -1) for x, y in zip(ahead, left)])
    noise = 0.5 * ((along - along[mirror])**2 + (across + across[mirror])**2)
    square, apart = along**2 + across**2, np.hypot(ahead, left)
    speeds, errors = [], []
    for ring in RINGS:
        inside = (mirror >= 0) & (apart >= ring) & (apart < ring + 1)
        of_noise = noise[inside].mean()
        speed = math.sqrt(max(square[inside].mean() - of_noise, 0.0))
        speeds.append(speed)
        errors.append(math.sqrt((2 * speed**2 * of_noise + 3 * of_noise**2) / inside.sum()) / max(2 * speed, 1e-9))
    return flow, np.array(speeds), np.array(errors)


RINGS = np.arange(2.5, 9.5)  # inner radii [mm]


def numbers(values, form=".2f"):
    return ", ".join(f"{value:{form}}" for value in values)


def aligns(rods):
    """P > .6 in each run at (.60, .11)."""
    orders = rods.plane[0.6, 0.11]
    return Found.of(f"P = {numbers(orders)}", all(order > 0.6 for order in orders))


def alone(rods):
    """Speed and 1/D_r of rods without beads within two errors of 3.6 mm/s and 2.5 s."""
    rows = table(rods.data / ("rod_matched.csv" if rods.name == "matched" else "paper_rod.csv"))
    at = (rows["gap"] == 1.177) & (rows["kick"] == 0.0265) if rods.name == "matched" else \
        (rows["area_fraction"] == 0.0) & (rows["kick"] == 0.015)
    speed, speed_error, time, error = (rows[name][at][0] for name in (
        "speed", "speed_error", "relaxation_time", "relaxation_time_error"))
    return Found.of(f"{speed:.2f} ± {speed_error:.2f} mm/s, {time:.1f} ± {error:.1f} s",
                    abs(speed - 3.6) < 2 * speed_error, abs(time - 2.5) < 2 * error)


def among_beads(rods):
    """1/D_r of rods among beads at .67 over that without within two errors of 13.6/2.5 = 5.4."""
    rows = table(rods.data / ("rod_in_bed.csv" if rods.name == "matched" else "paper_rod.csv"))
    kick = 0.0265 if rods.name == "matched" else 0.015
    at = [(rows["area_fraction"] == fraction) & (rows["kick"] == kick) for fraction in (0.67, 0.0)]
    bed, free = (rows["relaxation_time"][row][0] for row in at)
    bed_error, free_error = (rows["relaxation_time_error"][row][0] for row in at)
    ratio, error = bed / free, bed / free * math.hypot(bed_error / bed, free_error / free)
    return Found.of(f"{ratio:.1f} ± {error:.1f} times as long", abs(ratio - 13.6 / 2.5) < 2 * error)


def two_states(rods):
    """Each run has P > .6 at (.60, .11), and each run P < .3 at (.20, .11)."""
    dense, poor = rods.plane[0.6, 0.11], rods.plane[0.2, 0.11]
    return Found.of(f"P = {numbers(dense)} and {numbers(poor)} (random: {rods.chance:.2f})",
                    all(order > 0.6 for order in dense), all(order < 0.3 for order in poor))


def flowers(rods):
    """The mean over seeds of P about the centre is > .5 in the dense flower, and P < .3 in the poor one."""
    orders, poor = [order for order, _ in rods.flowers.values()], rods.order("flower-poor")
    return Found.of(f"of {len(orders)} seeds {sum(order > 0.5 for order in orders)} with P > 1/2 after 30 s, mean "
                    f"{np.mean(orders):.2f}; fewer beads: {poor:.2f}", np.mean(orders) > 0.5, poor < 0.3)


def phase_plane(rods):
    """P > 1/2 where Phi_b + 2 Phi_r > .65, and there alone: at all points, or in part at 80 % of them."""
    right = [(np.mean(orders) > 0.5) == (beads + 2 * fraction > 0.65)
             for (beads, fraction), orders in rods.plane.items()]
    return Found.of(f"{sum(right)} of {len(right)} points", all(right), np.mean(right) >= 0.8)


def half_order(rods, fraction):
    """Phi_b at which the mean over seeds of P passes 1/2 at an area fraction of rods; None if it does not."""
    means = sorted((beads, np.mean(orders)) for (beads, of), orders in rods.plane.items() if of == fraction)
    for (low, before), (high, after) in zip(means, means[1:]):
        if before < 0.5 <= after:
            return low + (high - low) * (0.5 - before) / (after - before)
    return None


def onset(rods):
    """P = 1/2 is passed within the 16 to 84 % of the predicted onset, at each area fraction of rods that has both."""
    line, field = rods.onset.groups["line"], rods.onset.groups["field"].mean_deviation
    texts, within = [], []
    for fraction in sorted({fraction for _, fraction in rods.plane}):
        found = half_order(rods, fraction)
        if found is None or not field.rod_fraction.min() <= fraction <= field.rod_fraction.max():
            continue
        at = line.sel(line_rod_fraction=fraction, method="nearest")
        low, place, high = (float(at[name]) for name in ("mean_low", "mean", "mean_high"))
        excess = field.interp(rod_fraction=fraction)  # over its error: -1 to 1 in the band, also below the table
        if not math.isfinite(high):
            high = float(excess.bead_fraction[(excess > 1.0).values.argmax()])
        within.append(abs(float(excess.interp(bead_fraction=found))) <= 1.0)
        low, place, high = (f"{value:.2f}" if math.isfinite(value) else "below .20" for value in (low, place, high))
        texts.append(f"at {fraction:g} of rods {found:.2f}, predicted {place} ({low} to {high})")
    return Found.of("; ".join(texts), *within)


def decay_of(rods, beads):
    """Separations beyond contact and G(r) relative to the first, at an area fraction of beads."""
    place, value = rods.correlations[beads]["polar_correlation"]
    near = place > 1.0  # closer rods overlap unless they are side by side
    return place[near], value[near] / value[near][0]


def correlation(rods):
    """G(r) falls to a tenth at a distance that is half as long again among .4 of beads as among .2 and .6."""
    tenths = {}
    for beads in rods.correlations:
        place, decay = decay_of(rods, beads)
        tenths[beads] = float(place[decay < 0.1][0])
    return Found.of(f"a tenth of G at {numbers(tenths.values(), '.0f')} mm among {numbers(tenths, 'g')} of beads",
                    tenths[0.4] > 1.5 * max(tenths[0.2], tenths[0.6]))


def plateau(rods):
    """G_tot beyond 40 mm is more than .9 of P^2 among .6 of beads."""
    found = {}
    for beads, of in rods.correlations.items():
        place, value = of["polar_correlation_total"]
        found[beads] = value[place > 40].mean() / of["polar_order"][1][0]**2
    return Found.of(f"beyond 40 mm {numbers(found.values())} of P² among {numbers(found, 'g')}", found[0.6] > 0.9)


def spread_of(rods, beads):
    """Mean numbers of rods in boxes, and their deviation relative to independent rods in a cell of 90 mm."""
    of = rods.correlations[beads]
    (side, number), (_, deviation) = of["rod_number"], of["rod_number_deviation"]
    return number, deviation / np.sqrt(number * (1 - (side / 90)**2))


def fluctuations(rods):
    """The deviation of the number of rods, relative to independent ones, is larger by .1 in the largest boxes than in
    the smallest: in flocks and without."""
    found = {beads: spread_of(rods, beads)[1][[0, -1]] for beads in rods.correlations}
    return Found.of("relative to independent rods " + "; ".join(
        f"{first:.2f} to {last:.2f} among {beads:g}" for beads, (first, last) in found.items()),
        *(last > first + 0.1 for first, last in found.values()))


def flow_and_order(rods):
    """The flow of beads along the order and P have a correlation of more than .9 in time."""
    series = rods.dense
    together = np.corrcoef(series["polar_order"], series["bead_velocity_along_order"])[0, 1]
    return Found.of(f"correlation {together:.2f}", together > 0.9)


def stray(rods):
    """Stray rods that touch none turn back, by three errors; with the mean flow of beads held they do not."""
    (_, free, free_error), (_, held, held_error) = rods.strays["free"], rods.strays["held"]
    header = (rods.folder / "stray" / "turning-free.csv").read_text(encoding="utf-8")
    flow = float(header.split("along the order: ")[1].split()[0])
    single = rods.coefficient("weathercock_single")
    at = single["beads"].index(0.6)
    return Found.of(f"{free:.3f} ± {free_error:.3f} rad/s times sin of the angle (lambda_s v of single rods: "
                    f"{single['value'][at] * flow:.3f} ± {single['error'][at] * flow:.3f}); {held:.3f} ± "
                    f"{held_error:.3f} with the beads held", free > 3 * free_error, abs(held) < 3 * held_error)


def wake(rods):
    """The flow of beads at 9 mm from a rod, relative to that at 3 mm, is stronger among .7 of beads than among .5."""
    reach = {beads: speeds[-1] / speeds[0] for beads, (_, speeds, _) in rods.wakes.items()}
    shown = ", ".join(f"{reach[beads]:.2f} ± {reach[beads] * math.hypot(*(errors / speeds)[[0, -1]]):.2f}"
                      for beads, (_, speeds, errors) in rods.wakes.items())
    return Found.of(f"at 9 mm {shown} of that at 3 mm among {numbers(reach, 'g')}", reach[0.7] > reach[0.5])


def weathercock(rods):
    """The flow turns rods along it, lambda_s > 0 by two errors, at every area fraction."""
    found = rods.coefficient("weathercock_single")
    return Found.of(f"lambda_s from {min(found['value']):.3f} to {max(found['value']):.3f} /mm",
                    np.all(found["value"] > 2 * found["error"]))


def change(found):
    """Last value less the first, in their errors."""
    return (found["value"][-1] - found["value"][0]) / math.hypot(found["error"][-1], found["error"][0])


def crossing(rods):
    """alpha/Gamma grows with the beads and a/lambda falls, by two errors each, and they cross."""
    drag, ratio = rods.coefficient("drag"), rods.coefficient("relaxation_over_weathercock")
    return Found.of(f"{drag['value'][0]:.1f} to {drag['value'][-1]:.1f} mm/s, {ratio['value'][0]:.0f} to "
                    f"{ratio['value'][-1]:.1f} mm/s", change(drag) > 2, change(ratio) < -2,
                    drag["value"][-1] > ratio["value"][-1])


def damping(rods):
    """The largest Gamma over area fractions of beads is at most a quarter more than the smallest."""
    found = rods.coefficient("damping_rate")["value"]
    return Found.of(f"{numbers(found, '.2g')} /s", max(found) < 1.25 * min(found))


def chirality(rods):
    """As many flowers turn one way as the other, within two deviations of even chances."""
    if len(rods.flowers) < 5:  # four that all turn one way are two deviations from even chances
        raise NotKept("flower-5")
    about = [series["rod_velocity_azimuthal"][series["time"] > 30].mean() for _, series in rods.flowers.values()]
    one, other = sum(value > 1 for value in about), sum(value < -1 for value in about)
    return Found.of(f"faster than 1 mm/s: {one} counter-clockwise, {other} clockwise of {len(about)}",
                    one + other and abs(one - other) <= 2 * math.sqrt(one + other))


def amorphous(rods):
    """P > .7 among beads of five sizes."""
    return Found.of(f"P = {rods.order('amorphous'):.2f}", rods.order("amorphous") > 0.7)


def circle(rods):
    """More rods are within a rod length of the wall of a circle than if their places were even."""
    share, even = (float(rods.case("circle-dense")[name]) for name in ("share_at_wall", "share_at_wall_even"))
    return Found.of(f"{share:.2f} of them within a rod length of it (even places: {even:.2f})", share > even)


# Figure, what the paper says, how it is made, how it is judged.
CLAIMS = (
    ("1", "rods align", "drover run", aligns),
    ("2a", "3.6 mm/s, 2.5 s", "study.py paper_rod, rod_matched", alone),
    ("2a", "direction lost 5.4 times as slowly among beads", "study.py paper_rod, rod_in_bed", among_beads),
    ("2k-n", "order at .60 of beads, none at .20", "printed.py, flocks.py", two_states),
    ("2g-j", "flower: order at .66, none at .48", "printed.py, flocks.py", flowers),
    ("3a-d", "flocks above Φ_b + 2Φ_r = .65", "printed.py, flocks.py", phase_plane),
    ("3e-f", "G(r) decays slowest near the boundary", "correlations.py", correlation),
    ("S: G_tot", "decays to a plateau in flocks", "correlations.py", plateau),
    ("5", "ΔN/√N grows with N, in flocks and without", "correlations.py", fluctuations),
    ("4", "the flow of beads tracks the order", "printed.py, flocks.py", flow_and_order),
    ("6", "the flow of beads turns a stray rod", "stray.py", stray),
    ("S: flow", "around a rod it decays more slowly among more beads", "wake.py", wake),
    ("7a", "flow turns rods along it", "drover calibrate", weathercock),
    ("7b", "α/Γ grows, a/λ falls, they cross", "drover calibrate", crossing),
    ("7b", "flocks begin where they cross", "drover boundary", onset),
    ("Methods", "Γ stays constant", "drover calibrate", damping),
    ("S: chirality", "flowers turn either way", "printed.py, flocks.py", chirality),
    ("S: amorphous", "flocks without crystal", "printed.py, flocks.py", amorphous),
    ("S: circle", "rods collect at the wall", "printed.py, flocks.py", circle),
)


def judged(claim, rods):
    """What was found for a claim; not run where its data are not kept."""
    try:
        return claim(rods)
    except NotKept:
        return Found("", NOT_RUN)


def verdicts(data=HERE / "data"):
    """Rows: figure, what the paper says, command, found with the rods as printed and with the matched ones."""
    kinds = Rods("printed", data), Rods("matched", data)
    return [(*words, *(judged(claim, rods) for rods in kinds)) for *words, claim in CLAIMS]


def counts(rows, kind):
    """{verdict: how many} of the printed (0) or matched (1) rods."""
    found = [row[3 + kind].verdict for row in rows]
    return {verdict: found.count(verdict) for verdict in (AGREES, IN_PART, MISSES, NOT_RUN)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=HERE / "data", help="folder of the kept tables")
    rows = verdicts(parser.parse_args().data)
    for figure, says, command, *found in rows:
        print(f"{figure}: {says} ({command})")
        for kind, one in zip(("printed", "matched"), found):
            print(f"  {kind}: {one.verdict}: {one.text}")
    for kind, name in enumerate(("printed", "matched")):
        print(f"{name}: " + ", ".join(f"{number} {verdict}" for verdict, number in counts(rows, kind).items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
