"""tests/bench/lammps/particles.py: spheres of rods and beads, from a snapshot or on a lattice; overlaps."""
import re
from dataclasses import dataclass

import h5py
import numpy

BEAD, ROD = 1, 2  # also the atom types of LAMMPS
ROD_RADII = numpy.repeat([0.55, 0.44, 0.36], [7, 3, 3])  # tail to head [mm]
ROD_SPACING = (4.5 - ROD_RADII[0] - ROD_RADII[-1]) / 12
ROD_MASS, ROD_CENTRE = 26.99, 1.942  # mg, mm from the tail's tip
ROD_INERTIA_ALONG, ROD_INERTIA_ACROSS = 3.376, 35.445  # mg mm^2
ROD_PLACES = ROD_RADII[0] + ROD_SPACING * numpy.arange(13) - ROD_CENTRE  # of its spheres, from the centre of mass
BEAD_RADIUS, BEAD_DENSITY = 0.4, 2.7  # mm, mg/mm^3
AMPLITUDE, FREQUENCY, GAP, GRAVITY = 0.04, 200.0, 1.2, 9810.0  # mm, Hz, mm, mm/s^2


@dataclass
class Spheres:
    """All spheres of a scene, as arrays; side is (x, y) of the periodic cell [mm]; time [s] sets the plates' phase."""

    position: numpy.ndarray
    velocity: numpy.ndarray
    radius: numpy.ndarray
    body: numpy.ndarray
    kind: numpy.ndarray
    side: tuple
    time: float = 0.0
    spin: numpy.ndarray | None = None  # angular velocity of each sphere's body [rad/s], where the snapshot has it


@dataclass
class Rods:
    """The rods of a scene as solids: arrays over rods; spheres is (rods, 13), tail to head."""

    spheres: numpy.ndarray
    mass: numpy.ndarray
    centre: numpy.ndarray
    velocity: numpy.ndarray
    inertia: numpy.ndarray
    momentum: numpy.ndarray  # angular


def base_height(time):
    """Of the base's surface [mm]; the lid is GAP above it."""
    return AMPLITUDE * (1.0 + numpy.cos(2.0 * numpy.pi * FREQUENCY * time))


def read(path):
    """The last frame of an extended XYZ or H5MD file."""
    return read_h5md(path) if h5py.is_hdf5(path) else read_xyz(path)


def kinds_of(species):
    """BEAD or ROD of each sphere; a species is `B` or `Rh`, as drover exports them, or contains `bead` or `rod`."""
    text = numpy.char.lower(numpy.asarray(species).astype(str))
    rods, beads = (text == "rh") | (numpy.char.find(text, "rod") >= 0), (text == "b") | (numpy.char.find(text,
                                                                                                         "bead") >= 0)
    if not (rods | beads).all():
        raise SystemExit(f"species {sorted(set(text[~(rods | beads)]))[:5]}; expected B, Rh, or names with bead or rod")
    return numpy.where(rods, ROD, BEAD)


def column(columns, names, path):
    for name in names:
        if name in columns:
            return columns[name]
    raise SystemExit(f"{path}: has the columns {', '.join(columns)}; expected one of {', '.join(names)}")


def read_xyz(path):
    """The last frame of an extended XYZ file with pos, radius, velo, body and species; spin from omega if present."""
    with open(path, encoding="utf-8") as lines:
        while head := lines.readline():
            count, comment = int(head), lines.readline()
            rows = [lines.readline().split() for _ in range(count)]
    keys = {key.lower(): quoted or bare for key, quoted, bare in re.findall(r'(\w+)=(?:"([^"]*)"|(\S+))', comment)}
    fields = keys["properties"].split(":")
    table, start, columns = numpy.array(rows), 0, {}
    for name, letter, width in zip(fields[0::3], fields[1::3], map(int, fields[2::3])):
        values = table[:, start:start + width]
        start += width
        columns[name] = (values if letter in "SL" else values.astype(float if letter == "R" else int)).squeeze()
    lattice = numpy.array(keys["lattice"].split(), float).reshape(3, 3)
    spin = next((columns[name] for name in ("omega", "angular_velocity", "spin") if name in columns), None)
    return Spheres(position=column(columns, ("pos",), path), velocity=column(columns, ("velo", "vel", "velocity"),
                                                                             path),
                   radius=column(columns, ("radius",), path), body=column(columns, ("body", "molecule"), path),
                   kind=kinds_of(column(columns, ("species", "kind"), path)), side=(lattice[0, 0], lattice[1, 1]),
                   time=float(keys.get("time", 0.0)), spin=spin)


def read_h5md(path):
    """The last frame of the first particle group of spheres (one that has radius and body) of an H5MD file."""
    with h5py.File(path) as file:
        group = next((part for part in file["particles"].values() if "radius" in part and "body" in part), None)
        if group is None:
            raise SystemExit(f"{path}: no group of /particles has radius and body; expected one of single spheres")
        times = numpy.atleast_1d(group["position/time"][()])

        def last(name):
            item = group[name]
            return item["value"][-1] if isinstance(item, h5py.Group) else item[()]

        species = last("species")
        dataset = group["species/value"] if isinstance(group["species"], h5py.Group) else group["species"]
        if names := h5py.check_enum_dtype(dataset.dtype):
            species = numpy.array([{code: name for name, code in names.items()}[code] for code in species])
        elif species.dtype.kind == "S" or species.dtype == object:
            species = numpy.array([name.decode() for name in species])
        edges = numpy.asarray(last("box/edges"))
        sides = numpy.diag(edges) if edges.ndim == 2 else edges
        return Spheres(position=last("position"), velocity=last("velocity"), radius=last("radius"), body=last("body"),
                       kind=kinds_of(species), side=(sides[0], sides[1]), time=float(times[-1]),
                       spin=last("angular_velocity") if "angular_velocity" in group else None)


def write_xyz(path, spheres):
    """As `read` reads it."""
    x, y = spheres.side
    names = {BEAD: "bead", ROD: "rod"}
    with open(path, "w", encoding="utf-8") as out:
        out.write(f'{len(spheres.radius)}\nLattice="{x} 0 0 0 {y} 0 0 0 {GAP}" Time={spheres.time} pbc="T T F" '
                  "Properties=species:S:1:pos:R:3:radius:R:1:velo:R:3:body:I:1\n")
        for kind, x, radius, v, body in zip(spheres.kind, spheres.position, spheres.radius, spheres.velocity,
                                            spheres.body):
            out.write(f"{names[kind]} {x[0]:.9g} {x[1]:.9g} {x[2]:.9g} {radius:.9g} "
                      f"{v[0]:.9g} {v[1]:.9g} {v[2]:.9g} {body}\n")


def on_lattice(beads, rods, side, seed):
    """Beads on random sites of a triangular lattice around rods along x, with random heads, on their own lattice."""
    random = numpy.random.default_rng(seed)
    floor = base_height(0.0)
    columns = max(1, int(side / 4.7))
    lines = -(-rods // columns)
    if lines and side / lines < 1.2:
        raise SystemExit(f"{rods} rods do not lie in {side} mm; expected at most {columns * int(side / 1.2)}")
    places = random.choice(columns * lines, rods, replace=False) if rods else numpy.zeros(0, int)
    centre = numpy.stack([(places % columns + 0.5) * side / columns, (places // columns + 0.5) * side / max(lines, 1)],
                         1)
    heading = random.choice([-1.0, 1.0], rods)
    along = ROD_PLACES + ROD_CENTRE - 2.25  # from the middle between the tips
    x = centre[:, :1] + heading[:, None] * along
    position = numpy.stack([x, numpy.broadcast_to(centre[:, 1:], x.shape), numpy.full(x.shape, floor + 0.58)], -1)
    pitch = 0.81
    across = int(side / pitch)
    sites = numpy.array([((i + 0.5 * (j % 2)) * side / across, j * pitch * 0.8661)
                         for j in range(int(side / (pitch * 0.8661)) // 2 * 2) for i in range(across)])
    away = abs(sites[:, None] - centre[None]) if rods * len(sites) < 2e7 else None
    free = numpy.ones(len(sites), bool)
    for rod in range(rods):
        apart = away[:, rod] if away is not None else abs(sites - centre[rod])
        apart = numpy.minimum(apart, side - apart)
        free &= (apart[:, 0] > 2.68) | (apart[:, 1] > 0.96)
    if free.sum() < beads:
        raise SystemExit(f"{beads} beads and {rods} rods in {side} mm; expected at most {free.sum()} beads")
    flat = random.permutation(sites[free])[:beads]
    height = floor + BEAD_RADIUS + 0.01 + (GAP - 2 * BEAD_RADIUS - 0.02) * random.random(beads)
    start = random.normal(0.0, 20.0, (beads, 3))
    return Spheres(position=numpy.concatenate([position.reshape(-1, 3), numpy.column_stack([flat, height])]),
                   velocity=numpy.concatenate([numpy.zeros((13 * rods, 3)), start]),
                   radius=numpy.concatenate([numpy.tile(ROD_RADII, rods), numpy.full(beads, BEAD_RADIUS)]),
                   body=numpy.concatenate([numpy.repeat(numpy.arange(rods), 13), rods + numpy.arange(beads)]),
                   kind=numpy.repeat([ROD, BEAD], [13 * rods, beads]), side=(side, side))


def nearest_image(shift, side):
    """Of differences of positions, in x and y."""
    shift = numpy.array(shift)
    for axis in (0, 1):
        shift[..., axis] -= side[axis] * numpy.round(shift[..., axis] / side[axis])
    return shift


def rods_of(spheres):
    """The rods as solids, by the straight lines through the places and the velocities of their spheres; no spin along
    the axis unless the snapshot has it.  A rod of another size is the paper's scaled."""
    indices = numpy.flatnonzero(spheres.kind == ROD)
    indices = indices[numpy.argsort(spheres.body[indices], kind="stable")].reshape(-1, 13)
    backward = spheres.radius[indices[:, 0]] < spheres.radius[indices[:, -1]]
    indices[backward] = indices[backward, ::-1]
    size = spheres.radius[indices[:, 0]] / ROD_RADII[0]
    first = spheres.position[indices[:, :1]]
    place = first + nearest_image(spheres.position[indices] - first, spheres.side)
    axis = place[:, -1] - place[:, 0]
    axis /= numpy.linalg.norm(axis, axis=1, keepdims=True)
    velocity = spheres.velocity[indices]
    slope = (velocity[:, -1] - velocity[:, 0]) / (ROD_PLACES[-1] - ROD_PLACES[0]) / size[:, None]
    turning = numpy.cross(axis, slope)
    along = numpy.zeros(len(indices)) if spheres.spin is None else (spheres.spin[indices[:, 0]] * axis).sum(1)
    across_inertia, along_inertia = ROD_INERTIA_ACROSS * size**5, ROD_INERTIA_ALONG * size**5
    inertia = across_inertia[:, None, None] * numpy.eye(3) \
        + (along_inertia - across_inertia)[:, None, None] * axis[:, :, None] * axis[:, None, :]
    return Rods(spheres=indices, mass=ROD_MASS * size**3, inertia=inertia,
                centre=place[:, 0] - ROD_PLACES[0] * size[:, None] * axis,
                velocity=velocity[:, 0] - ROD_PLACES[0] * size[:, None] * slope,
                momentum=across_inertia[:, None] * turning + (along_inertia * along)[:, None] * axis)


def touching(spheres):
    """Pairs of overlapping spheres of different bodies, and their overlaps [mm], by cells of the largest diameter."""
    reach = 2 * spheres.radius.max()
    count = numpy.array([max(3, int(side / reach)) for side in spheres.side])
    cell = numpy.floor(spheres.position[:, :2] / spheres.side * count).astype(int) % count
    key = cell[:, 0] * count[1] + cell[:, 1]
    order = numpy.argsort(key, kind="stable")
    begin = numpy.searchsorted(key[order], numpy.arange(count.prod() + 1))
    pairs = []
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1), (1, -1)):
        other = (cell[:, 0] + dx) % count[0] * count[1] + (cell[:, 1] + dy) % count[1]
        number = begin[other + 1] - begin[other]
        first = numpy.repeat(numpy.arange(len(key)), number)
        within = numpy.arange(number.sum()) - numpy.repeat(numpy.cumsum(number) - number, number)
        second = order[numpy.repeat(begin[other], number) + within]
        keep = spheres.body[first] != spheres.body[second]
        if (dx, dy) == (0, 0):
            keep &= first < second
        first, second = first[keep], second[keep]
        apart = numpy.linalg.norm(nearest_image(spheres.position[first] - spheres.position[second], spheres.side),
                                  axis=1)
        overlap = spheres.radius[first] + spheres.radius[second] - apart
        hit = overlap > 0
        pairs.append((first[hit], second[hit], overlap[hit]))
    return [numpy.concatenate(part) for part in zip(*pairs)]
