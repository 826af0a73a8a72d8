#!/usr/bin/python3
"""tests/bench/particles/study.py: how rods and beads depend on time step, contact law, gap and kick, as small tables.

    study.py PART --drover PROGRAM --output FOLDER [--seeds N] [--time FACTOR] [--first N]

writes FOLDER/PART.csv, one row per case, and skips existing rows: re-run to resume.  Two runs at a
time, or --workers N.  PART, and what it takes on two cores (estimates at half a microsecond a step of one rod and 25 ns
a step of one bead):

    rod_step       rod alone: time step and substep from 2e-4 to 2e-6 s, kick off and on                     8 minutes
    matched_step   the matched rod, all of one size: time step and substep, kick off and on                  3 minutes
    rod_laws       rod alone: laws of contact at gaps from 1.18 to 1.26 mm, dt = 2e-5 s                     30 minutes
    rod_kick       rod alone: loss of direction against the strength of the kick                             3 minutes
    rod_symmetric  rods of which head and tail are alike: their drift                                        2 minutes
    bed_step       beads at area fractions 0.3 and 0.6: temperature, impacts, decay of a flow, by time step 10 minutes
    bed_groups     beads at 0.7, where they touch in groups: how finely the impact of a group is followed    4 minutes
    rod_in_bed     relaxation time of the matched rod in a bed of area fraction 0.67 and without            10 minutes
    paper_rod      the same of the rod of the paper as printed, at two strengths of the kick                40 minutes
    pairwise_rod   the rod of the paper: step, order and friction of the pairwise law, and plain_rod.cpp     15 minutes

--time scales all times of runs (whole frames: 0.1 will do), --seeds is how many starts each case has, --first how
many cases: to try a part.  Rows of other seeds or times are other rows.  A start is a random direction, height and
tilt between the plates, at rest, at one phase of them.  Drover's own packing does not tilt rods: its starts differ in
height alone, and a rod of which head and tail are alike would start the same from both ends.  A rod in a bed starts
as it is packed, and so does its fellow without.

Columns: `speed` is the displacement over a frame along the direction at its start, mm/s; of one start, its mean after
a warm-up.  A start moves head-first when that is > 0; head_first_share is how many do, from head_first_low to
head_first_high by Wilson's interval of one standard error. head_first_time_share counts times, in windows of half a
second, instead: a rod may change its gait.  rotational_diffusion, rad2/s, is fitted to the correlation of directions
of all starts, as measure/trajectories.hpp has it, with the jackknife over starts.  failed counts the starts whose run
ended with an error, of which note has the last. """
import argparse
import csv
import json
import math
import multiprocessing
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy

import parts

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import settings_of, version_of  # noqa: E402

MODELS = Path(__file__).resolve().parents[3] / "models"
WORKERS = 2


class RunFailed(Exception):
    """A run that did not end well, with the last line that it wrote."""


def run(program, scene, settings, archive):
    """The results of one run, from --json."""
    words = [program, "run", str(scene), "--json", "--quiet", "--overwrite", "--output", str(archive),
             *settings_of({**settings, "run.threads": 1})]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        raise RunFailed((ended.stderr.strip().splitlines() or ["no words"])[-1])
    return json.loads(ended.stdout)["results"]


def tilted_start(program, case, seed, archive):
    """Settings for a rod as it is packed, but of a random tilt and height, both as free as the plates let them."""
    settings = {**case.settings, "run.seed": seed}
    run(program, MODELS / case.scene, {**settings, "time.dt": 1e-6, "time.end": 2e-6, "output.frame_every": 0.0,
                                       "output.sample_every": 0.0}, archive)
    random = numpy.random.default_rng(seed)
    with h5py.File(archive, "r+") as file:
        rods = file["bodies/rods"]
        at, radii = rods["sphere_at"][0], rods["sphere_radius"][0]
        floor = 2.0 * case.amplitude
        slack = case.gap - 2.0 * radii.max()
        tilt = random.uniform(-0.9, 0.9) * slack / numpy.ptp(at)
        low, high = (radii - tilt * at).max(), (case.gap - radii - tilt * at).min()
        axis = rods["axis/value"][0, 0]
        flat = axis[:2] / numpy.hypot(*axis[:2]) * math.sqrt(1.0 - tilt**2)
        rods["axis/value"][0, 0] = [*flat, tilt]
        rods["position/value"][0, 0, 2] = floor + random.uniform(low, high)
    return {"packing.kind": "file", "packing.file": str(archive), "packing.frame": 0}


def rod_run(program, case, seed, folder):
    """One start of one rod: angles and speeds from frame to frame after the warm-up."""
    if case.plain:
        return plain_run(case, seed, folder)
    archive = folder / "rod.h5"
    warm_up = 0.1 * case.seconds
    settings = {**case.settings, "run.seed": seed, "time.end": case.seconds, "analysis.warm_up": warm_up}
    if case.tilted:
        settings.update(tilted_start(program, case, seed, folder / "start.h5"))
    results = run(program, MODELS / case.scene, settings, archive)
    with h5py.File(archive) as file:
        times = file["bodies/rods/position/time"][:]
        places, axes = (file[f"bodies/rods/{name}/value"][:, 0, :2] for name in ("position", "axis"))
    used = times >= warm_up - 1e-9
    angles, spacing = numpy.arctan2(axes[used, 1], axes[used, 0]), times[1] - times[0]
    steps = numpy.diff(places[used], axis=0)
    along = (steps[:, 0] * numpy.cos(angles[:-1]) + steps[:, 1] * numpy.sin(angles[:-1])) / spacing
    return {"speed": results["rod_speed"]["mean"], "along": along, "angles": angles, "spacing": spacing}


def plain_run(case, seed, folder):
    """rod_run() by plain_rod.cpp, with starts of its own."""
    spacing, program = 0.025, folder / "plain_rod"
    source = Path(__file__).resolve().parent / "plain_rod.cpp"
    subprocess.run(["c++", "-O2", "-std=c++20", str(source), "-o", str(program)], check=True)
    ended = subprocess.run([str(word) for word in (program, seed, case.seconds, spacing, *case.plain)], check=True,
                           capture_output=True, text=True)
    frames = numpy.array([line.split() for line in ended.stdout.splitlines()], dtype=float)
    frames = frames[round(0.1 * case.seconds / spacing):]
    angles = numpy.arctan2(frames[:, 3], frames[:, 2])
    steps = numpy.diff(frames[:, :2], axis=0)
    along = (steps[:, 0] * numpy.cos(angles[:-1]) + steps[:, 1] * numpy.sin(angles[:-1])) / spacing
    return {"speed": along.mean(), "along": along, "angles": angles, "spacing": spacing}


def line_slope(times, values):
    """Of a straight line by least squares with the weights 1/t^2."""
    weights = 1.0 / times**2
    middle = (weights * times).sum() / weights.sum()
    return (weights * (times - middle) * values).sum() / (weights * (times - middle)**2).sum()


def jackknife(units, function):
    """A function of the means over units, with its error; `units` has one row for each."""
    whole = function(units.mean(axis=0))
    if len(units) < 2:
        return whole, math.nan
    left_out = numpy.array([function(numpy.delete(units, u, axis=0).mean(axis=0)) for u in range(len(units))])
    return whole, math.sqrt((len(units) - 1.0) * left_out.var())


def rotational_diffusion(paths, spacing, drop=0.5):
    """D_r with its error from angles of several starts: the fit of src/measure/trajectories.cpp."""
    most = (min(map(len, paths)) - 1) // 2
    if most < 2:
        return math.nan, math.nan
    units = numpy.array([[numpy.cos(path[lag:] - path[:len(path) - lag]).mean() for lag in range(most + 1)]
                         for path in paths])
    whole = units.mean(axis=0)
    end = 1
    while end <= most and whole[end] > math.exp(-drop):
        end += 1
    first = max(1, math.ceil((end - 1) / 8.0 - 1e-9))
    if end - first < 2:
        return math.nan, math.nan
    lags = numpy.arange(first, end)
    return jackknife(units[:, first:end], lambda means: line_slope(lags * spacing,
                                                                   -numpy.log(numpy.maximum(means, 1e-300))))


def wilson(hits, count):
    """Interval of one standard error of a share."""
    share = hits / count
    middle = (share + 0.5 / count) / (1.0 + 1.0 / count)
    half = math.sqrt(share * (1.0 - share) / count + 0.25 / count**2) / (1.0 + 1.0 / count)
    return max(0.0, middle - half), min(1.0, middle + half)


def mean_and_error(values):
    if len(values) == 0:
        return math.nan, math.nan
    return numpy.mean(values), numpy.std(values, ddof=1) / math.sqrt(len(values)) if len(values) > 1 else math.nan


def rod_row(_, runs):
    """The starts of a case in one row."""
    speeds = numpy.array([one["speed"] for one in runs])
    head_first, row = speeds > 0.0, {}
    row["speed"], row["speed_error"] = mean_and_error(speeds)
    row["speed_deviation"] = speeds.std(ddof=1) if len(speeds) > 1 else math.nan
    row["head_first_share"] = head_first.mean()
    row["head_first_low"], row["head_first_high"] = wilson(head_first.sum(), len(speeds))
    row["speed_head_first"], row["speed_head_first_error"] = mean_and_error(speeds[head_first])
    row["speed_tail_first"], row["speed_tail_first_error"] = mean_and_error(speeds[~head_first])
    spacing = runs[0]["spacing"]
    window = max(1, round(0.5 / spacing))
    shares = []
    for one in runs:
        frames = len(one["along"]) // window * window
        if frames:
            shares.append((one["along"][:frames].reshape(-1, window).mean(axis=1) > 0.0).mean())
    row["head_first_time_share"], row["head_first_time_share_error"] = mean_and_error(shares)
    diffusion, error = rotational_diffusion([one["angles"] for one in runs], spacing)
    row["rotational_diffusion"], row["rotational_diffusion_error"] = diffusion, error
    turns = diffusion > 1e-9
    row["relaxation_time"] = 1.0 / diffusion if turns else math.nan
    row["relaxation_time_error"] = error / diffusion**2 if turns else math.nan
    return row


def bed_run(program, case, seed, folder):
    """A free bed, the bed held at a mean velocity, and releases of it from frames half a second apart."""
    fixed = {**case.settings, "run.seed": seed}
    free = run(program, MODELS / case.scene,
               {**fixed, "time.end": case.seconds, "output.sample_every": 0.0052, "output.frame_every": 0.0,
                "analysis.warm_up": 0.25 * case.seconds}, folder / "free.h5")
    start = {"packing.kind": "file", "output.sample_every": 0.005}
    run(program, MODELS / case.scene,
        {**fixed, **start, "packing.file": str(folder / "free.h5"), "time.end": case.seconds, "output.frame_every": 0.5,
         "forces.hold_beads": True, "forces.bead_velocity_x": parts.VELOCITY}, folder / "held.h5")
    with h5py.File(folder / "held.h5") as file:
        frames = len(file["bodies/beads/position/time"])
    releases = []
    for frame in range(max(1, frames // 4), frames):
        run(program, MODELS / case.scene,
            {**fixed, **start, "packing.file": str(folder / "held.h5"), "packing.frame": frame,
             "time.end": case.release,
             "output.frame_every": 0.0}, folder / "release.h5")
        with h5py.File(folder / "release.h5") as file:
            releases.append(file["series/bead_velocity_mean_x"][:])
            times = file["series/time"][:]
    return {"results": free, "times": times, "releases": numpy.array(releases)}


def decay_rate(times, velocity, high, low):
    """-d ln v/dt by least squares where v is between two fractions of its first value; NaN below three samples."""
    share = velocity / velocity[0]
    below = numpy.flatnonzero(share < low)
    used = numpy.arange(len(share)) < (below[0] if len(below) else len(share))
    used &= share <= high
    if used.sum() < 3:
        return math.nan
    return -numpy.polyfit(times[used], numpy.log(share[used]), 1)[0]


def bed_row(_, runs):
    """Starts in one row: where there are several, errors are those among them."""
    row = {}
    for name in ("bead_temperature_horizontal", "impacts_bead_bead_rate"):
        found = [one["results"][name] for one in runs]
        row[name], row[f"{name}_error"] = mean_and_error([one["mean"] for one in found])
        if len(found) == 1:
            row[f"{name}_error"] = found[0]["error"]
    releases = numpy.concatenate([one["releases"] for one in runs])
    row["releases"] = len(releases)
    # Coulomb's friction would make the rate grow as the flow slows down.
    for name, high, low in (("decay_rate", 1.0, 0.35), ("decay_rate_early", 1.0, 0.65),
                            ("decay_rate_late", 0.65, 0.35)):
        row[name], row[f"{name}_error"] = jackknife(releases, lambda mean, high=high, low=low: decay_rate(
            runs[0]["times"], mean, high, low))
    row["velocity_left"] = releases.mean(axis=0)[-1] / releases.mean(axis=0)[0]
    return row


MEASURES = {"rod": (rod_run, rod_row), "bed": (bed_run, bed_row)}


def one_job(job):
    """In a process of its own: the result of one start, or the words of its failure."""
    program, number, case, seed = job
    with tempfile.TemporaryDirectory() as folder:
        try:
            return number, MEASURES[case.measure][0](program, case, seed, Path(folder))
        except RunFailed as failure:
            return number, str(failure)


def text_of(value):
    if isinstance(value, (float, numpy.floating)):
        return "" if not math.isfinite(value) else f"{value:.6g}"
    return "" if value is None else str(value)


def row_of(case, results):
    """A row of the table: the case, and what its starts say."""
    good = [one for one in results if not isinstance(one, str)]
    failures = [one for one in results if isinstance(one, str)]
    row = {**case.key, "failed": len(failures), "note": failures[-1] if failures else ""}
    if good:
        row.update(MEASURES[case.measure][1](case, good))
    return {name: text_of(value) for name, value in row.items()}


class Table:
    """FOLDER/PART.csv: what it has already, and rows added to it."""

    def __init__(self, path, part, origin, columns):
        self.path, self.columns = path, columns
        self.rows = []
        if not path.exists():
            words = [f"# study.py {part}; {origin}", *(f"# {line}" for line in parts.COMMENTS.get(part, ()))]
            path.write_text("\n".join(words) + "\n" + ",".join(columns) + "\n")
            return
        lines = path.read_text().splitlines()
        if origin not in lines[0]:
            sys.exit(f"{path}: {lines[0][2:]}, and this is {origin}; name another folder with --output")
        self.rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))

    def has(self, case):
        return any(all(row[name] == text_of(value) for name, value in case.key.items()) for row in self.rows)

    def add(self, row):
        with open(self.path, "a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, self.columns, restval="").writerow(row)


def columns_of(cases):
    """Those of the key, of failures, and of what is measured."""
    fixed = {"rod": ["speed", "speed_error", "speed_deviation", "head_first_share", "head_first_low",
                     "head_first_high", "speed_head_first",
                     "speed_head_first_error", "speed_tail_first", "speed_tail_first_error", "head_first_time_share",
                     "head_first_time_share_error",
                     "rotational_diffusion", "rotational_diffusion_error", "relaxation_time", "relaxation_time_error"],
             "bed": ["bead_temperature_horizontal", "bead_temperature_horizontal_error", "impacts_bead_bead_rate",
                     "impacts_bead_bead_rate_error", "releases", "decay_rate", "decay_rate_error", "decay_rate_early",
                     "decay_rate_early_error", "decay_rate_late", "decay_rate_late_error", "velocity_left"]}
    return [*cases[0].key, *fixed[cases[0].measure], "failed", "note"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=sorted(parts.PARTS))
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, help="folder of the tables; made if there is none")
    parser.add_argument("--seeds", type=int, help="starts of each case")
    parser.add_argument("--time", type=float, default=1.0, help="factor of all times of runs")
    parser.add_argument("--first", type=int, help="so many cases alone")
    parser.add_argument("--workers", type=int, default=WORKERS, help="runs at a time")
    options = parser.parse_args()
    folder, program = Path(options.output), str(Path(options.drover).resolve())
    folder.mkdir(parents=True, exist_ok=True)
    version = version_of(program)
    cases = parts.PARTS[options.part](options.seeds, options.time)[:options.first]
    table = Table(folder / f"{options.part}.csv", options.part, version, columns_of(cases))
    left = [case for case in cases if not table.has(case)]
    print(f"{table.path}: {len(cases)} cases, {len(cases) - len(left)} done already", file=sys.stderr)
    jobs = [(program, number, case, seed) for number, case in enumerate(left) for seed in range(1, case.seeds + 1)]
    found = [[] for _ in left]
    with multiprocessing.Pool(options.workers) as pool:
        for number, result in pool.imap(one_job, jobs):  # in order: a result does not depend on who was quicker
            found[number].append(result)
            if len(found[number]) == left[number].seeds:
                table.add(row_of(left[number], found[number]))
                found[number] = []


if __name__ == "__main__":
    main()
