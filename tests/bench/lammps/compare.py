#!/usr/bin/python3
"""tests/bench/lammps/compare.py: what a scene of rods and beads between vibrated plates costs in LAMMPS, and in drover.

LAMMPS (package `lammps` of Debian, with GRANULAR and RIGID) has the bodies as soft spheres: beads as single ones, a
rod as 13 that overlap, with the mass, centre and inertia of the solid; linear springs and dashpots with friction that
remembers its slip; plates that move as drover's; one core.  Its springs are the softest whose overlap at the largest
speeds of impact stays below --overlap of a radius, its step the largest at which single head-on impacts, run by
LAMMPS itself, give back what was asked within --tolerance.

    compare.py --snapshot FILE            a scene of drover: extended XYZ (species, pos, radius, velo, body; Lattice,
      Time) or H5MD
    compare.py --beads 200 --rods 5 --side 20     a packing of its own: a lattice, so warm it up for longer
    compare.py ... --drover PATH --scene SCENE.toml   and drover on the same scene, on one core, with the ratio of the
      costs
    compare.py --table                    only the time step, with the restitution of each kind of impact at each step

Prints JSON, then a head and a line of CSV.  Exit status 1: the motion was not sane (`broken` says why).

Cost is core seconds (wall seconds times the share of a core that the program had, so that others on the machine count
less) per simulated second.  What the numbers do not say:
- An impact off the centre of mass of a rod has a smaller mass than the rod, so that LAMMPS's dashpot (made for the
  rod's mass) brakes
  it more: the rows rod-tail-plate and rod-head-plate of the table.
- Springs are made for the speeds of CONTACTS (soft_spheres.py); a scene whose overlaps stay far below --overlap could
  do with softer
  ones and larger steps: compare at several --overlap.
- Plates have the restitution asked for with bodies of the paper's mass; pairs have it with any.
- The kicks of the rods are left out of LAMMPS: they cost nothing.
- The mean over a kind of impacts has to be right; with --worst each single one, which needs a smaller step.
- drover's wall_seconds are of stepping, observing and writing: let the scene observe nothing.
"""
import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy

import particles
import soft_spheres

STEPS = [mantissa * 10.0**power for power in (-7, -6, -5) for mantissa in (1, 1.25, 1.6, 2, 2.5, 3.2, 4, 5, 6.3, 8)][3:]


def parsed(arguments):
    summary, _, rest = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=summary, epilog=rest,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--snapshot", help="extended XYZ or H5MD file; its last frame is the start")
    add("--beads", type=int, default=200)
    add("--rods", type=int, default=5)
    add("--side", type=float, default=20.0, help="of the periodic cell of a packing of its own [mm]")
    add("--seed", type=int, default=1)
    add("--write-xyz", help="write the start there")
    add("--warm-up", type=int, default=500, help="steps before the timed ones")
    add("--steps", type=int, default=1000, help="timed steps of a segment")
    add("--segments", type=int, default=3, help="each ends with a look at the overlaps")
    add("--dt", type=float, help="time step of LAMMPS [s], instead of the one found")
    add("--overlap", type=float, default=0.01, help="largest overlap of the springs, relative to the smaller radius")
    add("--tolerance", type=float, default=0.03, help="of restitution")
    add("--worst", action="store_true", help="the tolerance is for each impact instead of the mean over a kind")
    add("--skin", type=float, default=0.3, help="of LAMMPS's neighbour lists [mm]")
    add("--table", action="store_true")
    add("--lmp", default="lmp", help="LAMMPS")
    add("--drover", help="the drover program; with --scene")
    add("--scene", help="scene file of drover for the same bodies; with --drover")
    add("--drover-time", type=float, default=0.05, help="simulated time of drover's run [s]")
    add("--set", action="append", default=[], metavar="KEY=VALUE", help="override of the drover scene; may be repeated")
    options = parser.parse_args(arguments)
    if bool(options.drover) != bool(options.scene):
        parser.error("one of --drover and --scene; expected both or neither")
    return options


def largest_overlap(frame):
    """Between bodies and into the plates, each of the smaller radius."""
    first, second, overlap = particles.touching(frame)
    between = (overlap / numpy.minimum(frame.radius[first], frame.radius[second])).max(initial=0.0)
    base = particles.base_height(frame.time)
    below = base + frame.radius - frame.position[:, 2]
    above = frame.position[:, 2] + frame.radius - base - particles.GAP
    return between, (numpy.maximum(below, above) / frame.radius).max(initial=0.0)


def rod_stretch(frame, rods):
    """Largest change of the distance between the ends of a rod, of that distance: it is rigid in a sound run."""
    ends = frame.position[rods.spheres[:, -1]] - frame.position[rods.spheres[:, 0]]
    size = frame.radius[rods.spheres[:, 0]] / particles.ROD_RADII[0]
    length = numpy.linalg.norm(particles.nearest_image(ends, frame.side), axis=1)
    return abs(length / (size * 12 * particles.ROD_SPACING) - 1).max(initial=0.0)


def broken(frames, stretch, overlap_plates):
    """What is wrong with a run, as sentences."""
    if not all(numpy.isfinite(frame.velocity).all() and numpy.isfinite(frame.position).all() for frame in frames):
        yield "a position or velocity is not finite"
    if (fastest := max(numpy.linalg.norm(frame.velocity, axis=1).max() for frame in frames)) > 1000.0:
        yield f"a sphere moves at {fastest:.0f} mm/s; expected at most 1000"
    if overlap_plates > 0.1:
        yield f"a sphere is {overlap_plates:.2f} of its radius inside a plate; expected at most 0.1"
    if stretch > 1e-4:
        yield f"a rod is stretched by {stretch:.1e}; expected at most 1e-4"


def lammps_cost(spheres, laws, dt, options, folder):
    """Runs the scene in LAMMPS; what came out, by name."""
    seconds, built, late, frames = soft_spheres.run_scene(spheres, laws, dt, options, folder)
    steps = options.steps * options.segments
    overlaps = numpy.array([largest_overlap(frame) for frame in frames])
    start = largest_overlap(spheres)
    stretch = max(rod_stretch(frame, particles.rods_of(frame)) for frame in frames)
    beads = frames[-1].kind == particles.BEAD
    speed = numpy.sqrt((frames[-1].velocity[beads]**2).mean(0)) if beads.any() else numpy.full(3, numpy.nan)
    return {"spheres": len(spheres.radius), "beads": int(beads.sum()), "rods": int((~beads).sum()) // 13, "dt": dt,
            "steps": steps,
            "core_seconds": list(seconds), "core_seconds_per_second": seconds.sum() / (steps * dt),
            "sphere_steps_per_second": len(spheres.radius) * steps / seconds.sum(),
            "lists_built": int(built), "lists_built_late": int(late),
            "overlap_between_bodies": overlaps[:, 0].max(), "overlap_plates": overlaps[:, 1].max(),
            "overlap_at_start": max(start), "bead_speed": list(speed), "rod_stretch": stretch,
            "broken": list(broken(frames, stretch, overlaps[:, 1].max()))}


def drover_cost(options, folder):
    """Runs the scene in drover on one core; what came out, by name."""
    overrides = [part for value in (f"time.end={options.drover_time}", *options.set) for part in ("--set", value)]
    command = [options.drover, "run", options.scene, *overrides, "--threads", "1", "--json", "--output",
               str(folder / "drover.h5")]
    used, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    wall, then = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} stopped:\n{done.stderr[-2000:]}")
    result = json.loads(done.stdout[done.stdout.index("{"):])
    share = min(1.0, (then.ru_utime + then.ru_stime - used.ru_utime - used.ru_stime) / wall)
    seconds = result["wall_seconds"] * share
    return {"core_seconds": seconds, "core_share": share, "simulated": options.drover_time,
            "steps": result.get("steps"),
            "core_seconds_per_second": seconds / options.drover_time}


def finite_json(value):
    """Arrays as lists, numbers that are not finite as null."""
    if isinstance(value, dict):
        return {name: finite_json(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite_json(part) for part in value]
    if isinstance(value, (float, numpy.floating)):
        return float(f"{value:.6g}") if numpy.isfinite(value) else None
    return value


def print_results(result):
    print(json.dumps(finite_json(result), indent=1))
    row = {name: result["lammps"][name] for name in ("beads", "rods", "dt", "steps", "core_seconds_per_second",
                                                     "sphere_steps_per_second",
                                                     "overlap_between_bodies", "overlap_plates")}
    if "drover" in result:
        row |= {"drover_core_seconds_per_second": result["drover"]["core_seconds_per_second"], "ratio": result["ratio"]}
    values = (f"{value:.4g}" if isinstance(value, float) else str(value) for value in row.values())
    print(",".join(row), ",".join(values), sep="\n")


def print_table(table, dt):
    names = [name for name in table[0] if name not in ("dt", "error")]
    print("step [s]  error  " + "  ".join(f"{name:>23}" for name in names))
    for row in table:
        cells = "  ".join("{:7.4f} {:7.4f} {:7.4f}".format(*row[name]) for name in names)
        print(f"{row['dt']:8.3g} {row['error']:6.3f}  {cells}" + ("  <- taken" if row["dt"] == dt else ""))
    print("restitution of each kind of impact: mean, least, greatest")


def start_of(options):
    spheres = particles.read(options.snapshot) if options.snapshot else \
        particles.on_lattice(options.beads, options.rods, options.side, options.seed)
    if options.write_xyz:
        particles.write_xyz(options.write_xyz, spheres)
    return spheres


def main(arguments):
    options = parsed(arguments)
    laws = {name: soft_spheres.law_of(contact, options.overlap) for name, contact in soft_spheres.CONTACTS.items()}
    result = {"stiffness": {name: law.stiffness for name, law in laws.items()},
              "hit_seconds": {name: law.duration for name, law in laws.items()}}
    with tempfile.TemporaryDirectory() as name:
        folder, dt = Path(name), options.dt
        if options.table or not dt:
            dt, table = soft_spheres.time_step(laws, [options.dt] if options.dt else STEPS,
                                               numpy.inf if options.dt else options.tolerance, options.worst, folder,
                                               options.lmp)
            if options.table:
                return print_table(table, dt)
            result["restitution"] = next(row for row in table if row["dt"] == dt)
        spheres = start_of(options)
        result["lammps"] = lammps_cost(spheres, laws, dt, options, folder)
        if options.drover:
            result["drover"] = drover_cost(options, folder)
            result["ratio"] = result["lammps"]["core_seconds_per_second"] / result["drover"]["core_seconds_per_second"]
    print_results(result)
    for sentence in result["lammps"]["broken"]:
        print(sentence, file=sys.stderr)
    return 1 if result["lammps"]["broken"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
