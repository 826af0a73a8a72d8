"""tests/bench/particles/stray.py: rods of a flock that point elsewhere and touch no other rod, and how they turn back.

Usage: stray.py --drover PROGRAM --output FOLDER [--rods matched | printed] [--seconds T] [--only free held]

Runs models/bead-flock.toml on from a kept flock of these rods: with free beads, and with the mean velocity of the beads
held at zero.
FOLDER/turning-free.csv and turning-held.csv get a row for each bin of the angle from the mean direction: how fast rods
turn towards it [rad/s], with its standard error, over 0.5 s in which no other rod was close enough to touch them.
FOLDER/images.csv gets the bodies around one rod of the free run that turns back by more than 90 degrees without a
touch.  A run that was stopped goes on.  A few minutes of one core each. """
import argparse
import sys
from pathlib import Path

import h5py
import numpy as np
from flocks import MODELS, RODS, Stopped, remove, run_or_resume, said, write

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import version_of  # noqa: E402

CELL = 45.0  # [mm]
# The spheres of a rod are at -1.6 to 2.1 mm from its centre of mass, with diameters of up to 1.13 mm.
AXIS, APART, NEAR = np.linspace(-1.6, 2.1, 13), 1.25, 5.5  # [mm]
FRAME, LAG = 0.1, 5  # [s] between frames, frames of one measurement
BINS = np.linspace(0.0, np.pi, 7)
FLOCKS = {"matched": "bead-flock-start.h5", "printed": "paper-flock-start.h5"}
IMAGES = 4
AROUND = 6.0  # [mm] shown to each side


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


class Flock:
    """Directions and places of all rods of a run, by frame and rod."""

    def __init__(self, file):
        axis = file["bodies/rods/axis/value"][()][..., :2]
        self.places = file["bodies/rods/position/value"][()][..., :2]
        self.angle = np.arctan2(axis[..., 1], axis[..., 0])
        self.mean = np.angle(np.exp(1j * self.angle).mean(axis=1))
        self.off = wrapped(self.angle - self.mean[:, None])

    def alone(self, frame):
        """Whether the axis of each rod is too far from those of all others to touch one."""
        apart = self.places[frame][:, None] - self.places[frame][None]
        apart = (apart - CELL * np.round(apart / CELL)) @ [1, 1j]
        first, second = np.nonzero(np.triu(np.abs(apart) < NEAR, 1))
        axes = np.exp(1j * self.angle[frame])[:, None] * AXIS
        closest = np.abs(apart[first, second, None, None] + axes[first, :, None] - axes[second, None, :]).min((1, 2))
        alone = np.ones(len(apart), dtype=bool)
        for rods in (first, second):
            alone[rods[closest < APART]] = False
        return alone


def turning(flock, alone):
    """Rows of the table of turning rates; errors from independent intervals."""
    rates = [[] for _ in BINS[1:]]
    for first in range(0, len(flock.off) - LAG, LAG):
        free = alone[first:first + LAG + 1].all(axis=0)
        start = flock.off[first][free]
        turned = wrapped(flock.angle[first + LAG] - flock.angle[first])[free]
        for rate, place in zip(-np.sign(start) * turned / (LAG * FRAME), np.digitize(np.abs(start), BINS[1:-1])):
            rates[place].append(rate)
    yield ["angle_deg", "rate_rad_s", "error", "intervals"]
    for middle, found in zip(np.degrees(0.5 * (BINS[1:] + BINS[:-1])), rates):
        mean, error = (np.mean(found), np.std(found) / np.sqrt(len(found))) if found else ("", "")
        yield [middle, mean, error, len(found)]


def return_of_a_stray(flock, alone):
    """The rod and the frames of its turn by more than 90 degrees within 10 s, of those without a touch the largest."""
    best = (0.5 * np.pi, None)
    for rod in range(flock.off.shape[1]):
        for first in range(1, len(flock.off)):
            for length in range(10, 101, 10):
                if first + length + 1 >= len(flock.off) or not alone[first:first + length + 1, rod].all():
                    break
                gain = abs(flock.off[first, rod]) - abs(flock.off[first + length, rod])
                if gain > best[0]:
                    best = (gain, (rod, first, first + length))
    return best[1]


def images(file, flock, which):
    """Bodies near the stray at a few moments of its turn, in a frame whose x axis is the mean direction."""
    rod, first, last = which
    yield ["seconds", "body", "ahead_mm", "left_mm", "angle_deg", "velocity_ahead", "velocity_left"]
    for frame in np.linspace(first, last, IMAGES).round().astype(int):
        turn = np.exp(-1j * flock.mean[frame])
        for kind in ("beads", "rods"):
            place = file[f"bodies/{kind}/position/value"][frame][:, :2] - flock.places[frame, rod]
            place = (place - CELL * np.round(place / CELL)) @ [1, 1j] * turn
            before, after = (file[f"bodies/{kind}/position/value"][one][:, :2] for one in (frame - 1, frame + 1))
            moved = after - before
            velocity = (moved - CELL * np.round(moved / CELL)) @ [1, 1j] * turn / (2 * FRAME)
            angle = flock.off[frame] if kind == "rods" else np.zeros(len(place))
            for i in np.flatnonzero((np.abs(place.real) < AROUND) & (np.abs(place.imag) < AROUND)):
                name = "stray" if kind == "rods" and i == rod else kind[:-1]
                yield [(frame - first) * FRAME, name, place[i].real, place[i].imag, float(np.degrees(angle[i])),
                       velocity[i].real, velocity[i].imag]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path, help="folder of the tables")
    parser.add_argument("--rods", default="matched", choices=RODS)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--only", nargs="*", default=["free", "held"], choices=["free", "held"])
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    version = version_of(arguments.drover)
    for name in arguments.only:
        held = name == "held"
        table = arguments.output / f"turning-{name}.csv"
        if table.exists():
            continue
        settings = {**RODS[arguments.rods], "packing.kind": "file", "time.end": arguments.seconds,
                    "output.frame_every": FRAME, "output.sample_every": 0.1025, "forces.hold_beads": held}
        archive = table.with_suffix(".h5")
        try:
            run_or_resume(arguments.drover, "bead-flock",
                          {**settings, "packing.file": str(MODELS / FLOCKS[arguments.rods])}, archive)
        except Stopped:
            return 3
        header = f"# bead-flock.toml {said(settings)}; {version}\n"
        with h5py.File(archive) as file:
            flock = Flock(file)
            alone = np.array([flock.alone(frame) for frame in range(len(flock.off))])
            speed = file["series/bead_velocity_along_order"][()].mean()
            header += f"# beads along the order: {speed:.3f} mm/s\n"
            if not held and (which := return_of_a_stray(flock, alone)):
                write(arguments.output / "images.csv", header, list(images(file, flock, which)))
            write(table, header, list(turning(flock, alone)))
        remove(archive)
        print(table, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
