"""tests/bench/lammps/soft_spheres.py: soft spheres of LAMMPS: contact laws, input, single impacts, time step."""
import re
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

import numpy

import particles
from particles import BEAD, ROD, ROD_MASS, ROD_RADII

BEAD_MASS = particles.BEAD_DENSITY * 4.0 / 3.0 * numpy.pi * particles.BEAD_RADIUS**3
PHASES = 16  # impacts of each kind, a different part of a step before touching


@dataclass(frozen=True)
class Contact:
    """What is asked of a kind of contact; speed is the largest that its stiffness is made for [mm/s]."""

    friction: float
    restitution: float
    mass: float  # reduced [mg]
    radius: float  # of the smaller sphere [mm]
    speed: float


CONTACTS = {
    "bead-bead": Contact(0.05, 0.3, BEAD_MASS / 2, particles.BEAD_RADIUS, 200.0),
    "rod-bead": Contact(0.05, 0.3, BEAD_MASS * ROD_MASS / (BEAD_MASS + ROD_MASS), ROD_RADII[-1], 200.0),
    "rod-rod": Contact(0.05, 0.3, ROD_MASS / 2, ROD_RADII[-1], 100.0),
    "bead-plate": Contact(0.01, 0.3, BEAD_MASS, particles.BEAD_RADIUS, 200.0),
    "rod-plate": Contact(0.03, 0.1, ROD_MASS, ROD_RADII[-1], 100.0),
}
TILTED = ("rod-tail-plate", "rod-head-plate")  # off the centre of mass: reported, not asked for


@dataclass(frozen=True)
class Law:
    """Spring and dashpot of one kind of contact."""

    stiffness: float  # mg/s^2
    damping: float  # part of the critical one
    duration: float  # of a hit [s]


def pair_text(law, contact):
    """Of two bodies: `damping tsuji` is the one with a restitution that does not depend on their masses."""
    return spring_text(law.stiffness, tsuji_restitution(2 * law.damping), "tsuji", contact.friction)


def plate_text(law, contact):
    """Of a plate: fix wall/gran turns the number of `damping tsuji` into a dashpot anew at each run, so that e
    changes from run to run; this dashpot is for the contact's mass, and bodies of other masses have another
    restitution."""
    dashpot = 2 * law.damping * numpy.sqrt(law.stiffness * contact.mass)
    return f"granular {spring_text(law.stiffness, dashpot, 'velocity', contact.friction)}"


def spring_text(stiffness, damping, kind, friction):
    return f"hooke {stiffness:.8g} {damping:.10g} damping {kind} "\
        f"tangential linear_history {2 / 7 * stiffness:.8g} 0.5 {friction}"


def law_of(contact, overlap):
    """The softest law whose overlap at the contact's speed is that part of its radius."""
    logarithm = numpy.log(contact.restitution)
    damping = -logarithm / numpy.hypot(numpy.pi, logarithm)
    slowed = numpy.sqrt(1.0 - damping**2)
    deepest = numpy.exp(-damping / slowed * numpy.arccos(damping))  # overlap at rest, of speed/frequency
    frequency = contact.speed * deepest / (overlap * contact.radius)
    stiffness = contact.mass * frequency**2
    return Law(stiffness, damping, numpy.pi / (frequency * slowed))


def tsuji_restitution(alpha):
    """The number for `damping tsuji` that yields the dashpot alpha sqrt(m k) on body masses: LAMMPS's polynomial is
    fitted to Hertz's law and would give a linear spring another restitution than the one named."""
    polynomial = numpy.array([4.8218, -18.022, 27.467, -22.348, 11.087, -4.2783, 1.2728])
    low, high = -0.5, 1.0  # it falls from low to high
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if numpy.polyval(polynomial, middle) > alpha else (low, middle)
    return 0.5 * (low + high)


def write_data(path, spheres, height, rods):
    """Spheres as a LAMMPS data file; molecule 0 is beads, those of rods count from 1."""
    molecule = numpy.zeros(len(spheres.radius), int)
    position = spheres.position.copy()
    for number, indices in enumerate(rods.spheres, 1):
        molecule[indices] = number
        position[indices] = position[indices[:1]] + particles.nearest_image(position[indices] - position[indices[:1]],
                                                                            spheres.side)
    density = numpy.where(spheres.kind == ROD, 8.7, particles.BEAD_DENSITY)
    rows = range(len(spheres.radius))
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"rods and beads\n\n{len(rows)} atoms\n2 atom types\n"
                  f"0 {spheres.side[0]:.15g} xlo xhi\n0 {spheres.side[1]:.15g} ylo yhi\n"
                  f"{height[0]} {height[1]} zlo zhi\n\nAtoms # sphere\n\n")
        for i in rows:
            x, y, z = position[i]
            out.write(f"{i + 1} {spheres.kind[i]} {2 * spheres.radius[i]:.12g} {density[i]} "
                      f"{x:.14g} {y:.14g} {z:.14g}\n")
        spin = numpy.zeros_like(spheres.velocity) if spheres.spin is None else spheres.spin
        out.write("\nVelocities\n\n")
        for i in rows:
            out.write(f"{i + 1} " + " ".join(f"{value:.12g}" for value in (*spheres.velocity[i], *spin[i])) + "\n")
        out.write("\nMolecules\n\n")
        out.writelines(f"{i + 1} {molecule[i]}\n" for i in rows)


def write_rods(path, rods):
    """Mass, centre, inertia and motion of each rod for fix rigid/small, which does not sum overlapping spheres then."""
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"{len(rods.mass)}\n")
        for number, (mass, centre, inertia, velocity, momentum) in enumerate(
                zip(rods.mass, rods.centre, rods.inertia, rods.velocity, rods.momentum), 1):
            tensor = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            out.write(f"{number} " + " ".join(f"{value:.14g}" for value in (mass, *centre, *tensor, *velocity,
                                                                            *momentum)) + " 0 0 0\n")


def deck(spheres, height, laws, dt, skin, moving, folder):
    """Writes the data files; returns the input up to the first run.  The plates of a moving scene are at the phase of
    its time: LAMMPS starts them at the lowest, so an empty cell runs until they are there."""
    rods = particles.rods_of(spheres)
    write_data(folder / "spheres.data", spheres, height, rods)
    write_rods(folder / "rods.dat", rods)
    wiggle = f"zplane 0 {particles.GAP} wiggle z {particles.AMPLITUDE} {1 / particles.FREQUENCY}"
    plates = wiggle if moving else "zplane 0 NULL"
    there = round((spheres.time * particles.FREQUENCY + 0.5) % 1.0 / particles.FREQUENCY / dt) if moving else 0
    text = {name: (plate_text if name.endswith("plate") else pair_text)(law, CONTACTS[name]) for name,
            law in laws.items()}
    has = {kind: (spheres.kind == kind).any() for kind in (BEAD, ROD)}
    lines = ["units lj  # with mm, mg and s", "atom_style sphere", "newton off", "boundary p p f", 
             "atom_modify map array sort 1000 1.2",  # a bin of its own, or the empty run switches sorting off
             f"region cell block 0 {spheres.side[0]:.15g} 0 {spheres.side[1]:.15g} {height[0]} {height[1]}",
             "fix molecules all property/atom mol ghost yes", "create_box 2 cell", "comm_modify vel yes cutoff 4.6",
             f"group beads type {BEAD}", f"group rods type {ROD}", f"timestep {dt:.10g}",
             *[f"fix plates_{kind} {kind}s wall/gran {text[f'{kind}-plate']} {plates}" for kind in ("bead", "rod")],
             f"run {there}", "pair_style granular", f"pair_coeff 1 1 {text['bead-bead']}",
             f"pair_coeff 1 2 {text['rod-bead']}", f"pair_coeff 2 2 {text['rod-rod']}",
             f"read_data {folder}/spheres.data add append fix molecules NULL Molecules",
             f"group beads type {BEAD}", f"group rods type {ROD}", f"neighbor {skin} bin", 
              "neigh_modify delay 0 every 5 check yes"]
    gravity = particles.GRAVITY if moving else 1e-300
    if has[BEAD]:
        lines += ["fix beads_move beads nve/sphere", f"fix beads_fall beads gravity {gravity} vector 0 0 -1"]
    if has[ROD]:
        lines += [f"fix rods_fall rods gravity {gravity} vector 0 0 -1 disable",
                  "neigh_modify exclude molecule/intra rods",
                  f"fix rods_move rods rigid/small molecule infile {folder}/rods.dat reinit no gravity rods_fall"]
    return lines + ["thermo_style custom step", "thermo_modify lost error"]


def run(lines, folder, program):
    """Runs LAMMPS; returns what it printed."""
    path = Path(folder, "in.scene")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    done = subprocess.run([program, "-in", path, "-log", "none"], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{program} stopped:\n" + "\n".join((done.stdout + done.stderr).splitlines()[-12:]))
    return done.stdout


def read_dump(path):
    """The step of a dump sorted by id and its columns."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    values = numpy.array([line.split() for line in lines[9:]], float)
    return int(lines[1]), {name: values[:, i] for i, name in enumerate(lines[8].split()[2:])}


def frame_of(spheres, path, dt):
    """The spheres as a dump has them, at a time that puts the plates where LAMMPS has them: lowest at its step 0."""
    step, columns = read_dump(path)
    return replace(spheres, position=numpy.stack([columns[name] for name in ("x", "y", "z")], 1),
                   velocity=numpy.stack([columns[name] for name in ("vx", "vy", "vz")], 1), spin=None,
                   time=step * dt + 0.5 / particles.FREQUENCY)


def run_scene(spheres, laws, dt, options, folder):
    """Runs a scene: a warm-up, then segments that are timed, with a frame after each.  Returns core seconds,
    neighbour lists built (and how many too late) of the segments, and the frames."""
    lines = deck(spheres, (-1.0, 3.0), laws, dt, options.skin, True, folder)
    columns = "id x y z vx vy vz modify sort id format float %.12g"
    lines += [f"run {options.warm_up}"]
    for segment in range(options.segments):
        lines += [f"run {options.steps}", f"write_dump all custom {folder}/{segment}.dump {columns}"]
    text = run(lines, folder, options.lmp)
    loops = re.findall(r"Loop time of (\S+) on .*?(\S+)% CPU use.*?Neighbor list builds = (\d+)\s+"
                       r"Dangerous builds = (\d+)", text, re.S)
    seconds, use, built, late = numpy.array(loops[-options.segments:], float).T
    frames = [frame_of(spheres, folder / f"{segment}.dump", dt) for segment in range(options.segments)]
    return seconds * numpy.minimum(use / 100.0, 1.0), built.sum(), late.sum(), frames


class Impacts:
    """Single head-on impacts, PHASES of each kind, far apart: rods upright, tails first; TILTED: lowest sphere."""

    def __init__(self, dt):
        self.dt = dt
        self.position, self.velocity, self.radius, self.body, self.kind = [], [], [], [], []
        self.pairs = {name: [] for name in (*CONTACTS, *TILTED)}  # spheres that touch (-1: the plate), axis, speed
        for phase in range(PHASES):
            for row, name in enumerate(self.pairs):
                self.add(name, numpy.array([4.0 + 8.0 * phase, 4.0 + 8.0 * row, 0.0]), (phase + 0.5) / PHASES)

    def add(self, name, corner, phase):
        speed = CONTACTS[name if name in CONTACTS else "rod-plate"].speed
        ahead = speed * self.dt * (0.5 + phase)
        if name.endswith("plate"):
            first = {"bead-plate": lambda: self.bead(corner, ahead, -speed),
                     "rod-plate": lambda: self.rod(corner, ahead, (0, 0, 1), 0, -speed),
                     "rod-tail-plate": lambda: self.rod(corner, ahead, (0.866, 0, 0.5), 0, -speed),
                     "rod-head-plate": lambda: self.rod(corner, ahead, (0.866, 0, -0.5), 12, -speed)}[name]()
            second = -1
        else:
            second = self.bead(corner, 8.0, 0.0) if name == "bead-bead" else self.rod(corner, 8.0, (0, 0, 1), 0, 0.0)
            bottom = self.position[second][2] - self.radius[second] - ahead
            first = self.bead(corner, bottom - 0.8, speed) if name != "rod-rod" else self.rod(corner, bottom - 1.1,
                                                                                              (0, 0, -1), 0, speed)
        self.pairs[name].append((first, second, speed))

    def bead(self, corner, bottom, speed):
        self.position.append(corner + [0, 0, bottom + particles.BEAD_RADIUS])
        self.append(particles.BEAD_RADIUS, BEAD, speed, (self.body[-1] + 1) if self.body else 0)
        return len(self.radius) - 1

    def rod(self, corner, bottom, axis, lowest, speed):
        """A rod whose sphere `lowest` ends at the height bottom."""
        axis = numpy.array(axis) / numpy.linalg.norm(axis)
        start, number = len(self.radius), (self.body[-1] + 1) if self.body else 0
        for place, radius in zip(particles.ROD_PLACES - particles.ROD_PLACES[lowest], ROD_RADII):
            self.position.append(corner + [0, 0, bottom + ROD_RADII[lowest]] + place * axis)
            self.append(radius, ROD, speed, number)
        return start + lowest

    def append(self, radius, kind, speed, body):
        self.radius.append(radius)
        self.kind.append(kind)
        self.velocity.append((0.0, 0.0, speed))
        self.body.append(body)

    def restitutions(self, laws, folder, program):
        """{kind: restitution of each impact} as LAMMPS has it."""
        side = (8.0 * PHASES, 8.0 * len(self.pairs))
        spheres = particles.Spheres(*map(numpy.array, (self.position, self.velocity, self.radius, self.body,
                                                       self.kind)), side)
        steps = int(1.5 * max(law.duration for law in laws.values()) / self.dt) + 4
        lines = deck(spheres, (-1.0, 16.0), laws, self.dt, 0.1, False, folder)
        run([*lines, f"run {steps // 4}", f"run {steps - steps // 4}",  # two runs, as a benchmark has
             f"write_dump all custom {folder}/after.dump id vz modify sort id format float %.12g"], folder, program)
        speeds = numpy.append(read_dump(folder / "after.dump")[1]["vz"], 0.0)
        return {name: numpy.array([(speeds[second] - speeds[first]) / (speed if second >= 0 else -speed) for first,
                                   second, speed in pairs])
                for name, pairs in self.pairs.items()}


def time_step(laws, steps, tolerance, worst, folder, program):
    """The largest of some steps at which, as at every smaller one, each kind of contact has the restitution asked
    for, and a table: mean or worst over the impacts of a kind."""
    table, largest, holding = [], None, True
    for dt in sorted(steps):
        found = Impacts(dt).restitutions(laws, folder, program)
        errors = {name: found[name] / contact.restitution - 1 for name, contact in CONTACTS.items()}
        error = max(abs(error).max() if worst else abs(error.mean()) for error in errors.values())
        table.append({"dt": dt, "error": error, **{name: (e.mean(), e.min(), e.max()) for name, e in found.items()}})
        holding = holding and error <= tolerance
        largest = dt if holding else largest
        if error > 10 * tolerance:
            break
    if largest is None:
        first = table[0]
        raise SystemExit(f"restitution is {first['error']:.1%} off at the step {first['dt']:g} s; "
                         f"expected at most {tolerance:.1%}")
    return largest, table
