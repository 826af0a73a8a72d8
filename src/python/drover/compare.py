"""drover/compare.py: compares a calibrated field run with a particle run.

    python3 -P -m drover.compare FIELDS PARTICLES [--output PNG]
"""
import argparse
import math
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy

from drover import figure
from drover.figures import compare_panels
from drover.archive import Run, loaded, open_run
from drover.series_statistics import mean_and_error
from drover.error import DroverError, status_of
from drover.fields import shipped_fields
from drover.particles import ParticleRun, sides_of
from drover.spectra import structure_factors
from drover.text import drawable, printable

MAX_FRACTION_DIFFERENCE = 0.01  # between area fractions of the runs: one rod in a small cell
# Rows: key, label, name in calibrated.expected.  The mean field has one bead velocity, along the order.
ROWS = (("alignment", "alignment g", "alignment"),
        ("relaxation", "effective relaxation abar [1/s]", "effective_relaxation"),
        ("order", "polar order P", "order"), ("size", "bead velocity |<v>| [mm/s]", "bead_velocity"),
        ("along", "bead velocity along the order [mm/s]", "bead_velocity"))
EXPECTED = re.compile(r"(\w+) = (\S+)(?: \+- (\S+))?(?: \S+)?")
PARTICLE_SERIES = {"order": "polar_order", "size": "bead_velocity_size", "along": "bead_velocity_along_order"}


@dataclass(frozen=True)
class Side:
    """One run as it is compared.  Errors are NaN where the run is too short for an estimate."""

    run: Run | ParticleRun
    times: numpy.ndarray
    series: dict     # "order", "size" and "along" over the times
    numbers: dict    # their means with errors, after the warm-up
    warm_up: float   # excluded [s]
    sides: numpy.ndarray

    @property
    def name(self):
        return self.run.attributes.get("scene_file", self.run.path.name)


@dataclass(frozen=True)
class Comparison:
    expected: dict   # mean-field prediction: name -> value, error
    fields: Side
    particles: Side
    factors: dict    # "rods" and "order" -> structure factors of fields and particles, two Results


def compare(fields, particles):
    """Compares two open runs at the same area fractions.  Raises DroverError for runs that cannot be compared."""
    expected = expected_of(fields)
    check_particles(fields, particles)
    most = 0.5 * float(loaded(fields.observables["wavenumber"], fields.path)[-1])
    factors = zip(structure_factors(fields, most), structure_factors(particles, most))
    return Comparison(expected, field_side(fields), particle_side(particles), dict(zip(("rods", "order"), factors)))


def expected_of(run):
    """The mean-field prediction that drover stored when it filled in the coefficients."""
    if not isinstance(run, Run):
        raise DroverError(f"{run.path} is a particle run; expected first a field run with a section "
                          "[calibrated], then a particle run: exchange them")
    if not run.scene.get("calibrated", {}).get("table"):
        raise DroverError(f"{run.path}: its scene has no calibrated.table; expected a calibrated field run: add a "
                          f"section [calibrated] "
                          "to its scene and run it again")
    for field in compared_fields():
        if field.components[0] not in run.frames:
            raise DroverError(f"{run.path} has no {field.name.replace('_', ' ')}; set fields.{field.name} in its scene "
                              "and run it again")
    texts = [EXPECTED.fullmatch(text) for text in run.scene["calibrated"].get("expected", [])]
    try:
        numbers = {text[1]: (float(text[2]), float(text[3] or 0.0)) for text in texts if text}
    except ValueError:
        numbers = {}
    missing = [name for *_, name in ROWS if name not in numbers]
    if missing:
        raise DroverError(f"{run.path}: calibrated.expected of its scene has no {missing[0]}; expected the mean-field "
                          f"prediction that drover run "
                          "stores: take relaxation, drag, driving and weathercock from the table and run the scene "
                          "again")
    return numbers


def compared_fields():
    """The density, the order and the flow of the model file."""
    return list(shipped_fields())[:3]


def check_particles(fields, run):
    if not isinstance(run, ParticleRun):
        raise DroverError(f"{run.path} is a field run; expected a particle run as the second archive")
    shape = run.scene["cell"].get("shape", "periodic")
    if shape != "periodic":
        raise DroverError(f'{run.path}: cell.shape = "{shape}"; expected "periodic", as for fields: run particles in a '
                          "periodic cell")
    for kind in ("bead", "rod"):
        wanted, found = fields.scene["calibrated"][f"{kind}_area_fraction"], area_fraction(run, kind)
        if abs(found - wanted) > MAX_FRACTION_DIFFERENCE:
            raise DroverError(f"{run.path}: the area fraction of its {kind}s is {found:.4g}; expected "
                              f"calibrated.{kind}_area_fraction "
                              f"= {wanted:.4g} of {fields.path} within {MAX_FRACTION_DIFFERENCE:g}: choose two runs "
                              f"with equal area fractions")


def area_fraction(run, kind):
    """From the scene, or from its numbers of bodies."""
    given = run.scene.get(f"{kind}s", {}).get("area_fraction", 0.0)
    if given > 0.0 or kind not in run.frames.sizes:
        return given
    names = ("bead_radius",) if kind == "bead" else ("rod_sphere_at", "rod_sphere_radius")
    shapes = [loaded(run.frames[name], run.path).values for name in names]
    areas = numpy.pi * shapes[0] ** 2 if kind == "bead" else [projected_area(*rod) for rod in zip(*shapes)]
    return float(numpy.sum(areas) / numpy.prod(sides_of(run)))


def projected_area(at, radius, points=2001):
    """Projected area of a union of spheres on one axis, seen from the side."""
    z = numpy.linspace((at - radius).min(), (at + radius).max(), points)
    half = numpy.sqrt(numpy.maximum(0.0, radius[:, None] ** 2 - (z - at[:, None]) ** 2)).max(axis=0)
    return 2.0 * numpy.trapz(half, z)


def field_side(run):
    """Field archives contain the mean bead velocity as components only."""
    _, order, flow = (field.name for field in compared_fields())
    names = (f"{name}_mean_{axis}" for name in (order, flow) for axis in "xy")
    p_x, p_y, v_x, v_y = (series_of(run, name) for name in names)
    size = numpy.hypot(p_x, p_y)
    along = numpy.divide(p_x * v_x + p_y * v_y, size, out=numpy.zeros_like(size), where=size > 0.0)
    series = {"order": series_of(run, order), "size": numpy.hypot(v_x, v_y), "along": along}
    sides = numpy.array([run.scene["grid"][name] for name in ("lx", "ly")])
    return side(run, series, {"order": order}, sides)


def particle_side(run):
    return side(run, {key: series_of(run, name) for key, name in PARTICLE_SERIES.items()}, PARTICLE_SERIES,
                sides_of(run))


def series_of(run, name):
    if name not in run.observables:
        raise DroverError(f"{run.path} has no series {name}; the file is from another version of drover, or "
                          "damaged")
    return loaded(run.observables[name], run.path).values


def side(run, series, summarised, sides):
    """Uses the means of the archive where they exist."""
    times = run.observables["time"].values
    finished = run.summary is not None
    # An unfinished run has no warm-up time yet: exclude half of it, to be safe.
    warm_up = float(loaded(run.summary["warm_up"], run.path)) if finished else 0.5 * float(times[-1] - times[0])
    first = int(numpy.searchsorted(times, (times[0] + warm_up) * (1.0 - 1e-9)))
    last = len(times) - int(ends_early(times))
    numbers = {key: mean_and_error(values[first:last]) for key, values in series.items()}
    for key, name in summarised.items() if finished else ():
        numbers[key] = tuple(float(loaded(run.summary[part], run.path)) for part in (name, f"{name}_error"))
    return Side(run, times, series, numbers, warm_up, sides)


def ends_early(times):
    """Whether the last sampling interval is shorter than the others because the run ended."""
    return len(times) > 2 and times[-1] - times[-2] < (1.0 - 1e-6) * (times[1] - times[0])


def number_text(value, error):
    if math.isnan(error):
        return f"{value:.4g} (run too short for an error estimate)"
    return f"{value:.4g}" if error == 0.0 else f"{value:.4g} +- {error:.2g}"


def table_text(comparison):
    """The mean-field prediction and the results of both runs as a table."""
    sides = (comparison.fields, comparison.particles)
    lines = [("", "mean field", "fields", "particles")]
    for key, words, name in ROWS:
        lines.append((words, number_text(*comparison.expected[name]),
                      *(number_text(*side.numbers[key]) if key in side.numbers else "-" for side in sides)))
    widths = [max(map(len, column)) for column in zip(*lines)]
    rows = ["  ".join(word.ljust(width) for word, width in zip(line, widths)).rstrip() for line in lines]
    return "\n".join([heading(comparison), "", *rows, "", *map(remark, sides)])


def heading(comparison):
    plan = comparison.fields.run.scene["calibrated"]
    return (f"{comparison.fields.name} (fields) and {comparison.particles.name} (particles): area fractions "
            f"{plan['bead_area_fraction']:g} of beads, {plan['rod_area_fraction']:g} of rods")


def remark(side):
    words = (f"{side.name}: cell {side.sides[0]:g} x {side.sides[1]:g} mm, {side.times[-1]:g} s, "
             f"means after {side.warm_up:.3g} s")
    if side.run.summary is None:
        words += " (the run is not finished)"
    return words


def compare_files(fields_path, particles_path):
    """Compares two archives; returns the comparison and its figure."""
    with open_run(fields_path) as fields, open_run(particles_path) as particles:
        comparison = compare(fields, particles)
        return comparison, compare_panels.draw(comparison, drawable(heading(comparison)))


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -P -m drover.compare", description="Compares a calibrated field run "
                                     "with a "
                                     "particle run at the same area fractions: a table and a figure.")
    parser.add_argument("fields", type=Path, help="archive of a field scene with a section [calibrated]")
    parser.add_argument("particles", type=Path, help="archive of a particle scene")
    parser.add_argument("-o", "--output", type=Path, help="figure file (.png, .pdf or .svg); default: the name of the "
                                                          "field "
                        "archive with .compared.png")
    options = parser.parse_args(arguments)
    output = options.output or options.fields.with_suffix(".compared.png")

    def act():
        comparison, picture = compare_files(options.fields, options.particles)
        figure.write(picture, output)
        print(printable(f"{table_text(comparison)}\n\n{output}"))
    return status_of(act)


if __name__ == "__main__":
    sys.exit(main())
