"""drover/demo.py: three short simulations and one page of pictures: what `make demo` shows.

    python3 -P -m drover.demo [--models FOLDER] [--output FOLDER]
"""
import argparse
import html
import io
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy

import drover
from drover import new_file
from drover.error import status_of
from drover.figures.paper import STYLE, new_figure
from drover.text import printable

FIELDS, PARTICLES, START = "noisy-flock.toml", "paper-flock.toml", "paper-flock-start.h5"
TABLE, FLOCKS = "matched.calibration/table.h5", "matched.calibration/flocks.csv"
SECONDS, EVERY, RATE = 4.0, 0.1, 16      # s of the particles, s between pictures, pictures per second
PROGRAM = "build/release/drover"
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>drover: flocks carried by a passive medium</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {{ font: 17px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }}
h1, h2 {{ font-weight: 600; line-height: 1.2; }} h2 {{ margin-top: 2.5rem; }}
img, video {{ display: block; max-width: 100%; height: auto; margin: 1rem auto; }}
video, .narrow {{ width: 36rem; }}
pre {{ background: #f3f3f3; padding: .7rem 1rem; overflow-x: auto; font-size: 14px; }}
</style></head><body>
<h1>Flocks carried by a passive medium</h1>
<p>Rods on a vibrated plate drag beads along; the flow of beads turns other rods. Everything on this page was computed
just now by <code>drover</code>.</p>
{sections}
</body></html>
"""


@dataclass(frozen=True)
class Part:
    """One section of the page: a title, the HTML of its pictures, one sentence, and the command to try next."""

    title: str
    pictures: str
    sentence: str
    command: str


def make(models, output, part=1.0):
    """Runs the demo and writes its page; returns the parts.  Tests take a smaller `part` of the durations."""
    models, output = Path(models), Path(output)
    output.mkdir(parents=True, exist_ok=True)
    scene = drover.Scene.load(models / FIELDS)
    step = scene["output.frame_every"]
    scene = scene.set("time.end", step * max(2, round(part * scene["time.end"] / step)))
    moving = drover.Scene.load(models / PARTICLES).set({
        "packing.kind": "file", "packing.file": START, "time.end": EVERY * max(2, round(part * SECONDS / EVERY)),
        "output.sample_every": EVERY, "analysis.warm_up": 0.0}).start()
    with ThreadPoolExecutor(1) as pool:  # both release the interpreter; the archive is written by one of them only
        archive = pool.submit(scene.run, output / "flock.h5", overwrite=True, threads=1)
        film = drover.film(moving, output / "particles.mp4", every=EVERY, rate=RATE)
        with archive.result() as run, matplotlib.rc_context(STYLE):
            parts = [particles(moving, film), fields(run, output), boundary(models, output)]
    page = PAGE.format(sections="\n".join(section(one) for one in parts))
    new_file.write(output / "index.html", page.encode())
    return parts


def section(part):
    return (f"<h2>{html.escape(part.title)}</h2>\n<p>{html.escape(part.sentence)}</p>\n{part.pictures}\n"
            f"<p>Next:</p>\n<pre>{html.escape(part.command)}</pre>")


def picture(figure, path, words, shape=""):
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=200)
    new_file.write(path, content.getvalue())
    return f'<img src="{path.name}" alt="{html.escape(words)}"{shape}>'


def particles(run, film):
    """The last picture of the particles and their film."""
    from drover.figures.particle_panels import draw_wheel
    order, flow = (float(run.observables[name].mean()) for name in ("polar_order", "bead_velocity_order"))
    counts = run.frame.rod_position.shape[0], run.frame.bead_position.shape[0]
    figure = new_figure((7.4, 5.6))
    drover.plot.map(run, figure.add_axes((0.01, 0.01, 0.74, 0.98)))
    draw_wheel(figure, (0.80, 0.70, 0.14, 0.14 * 7.4 / 5.6))
    poster = film.with_suffix(".png")
    picture(figure, poster, "")
    sentence = (f"Particles: {counts[0]} rods among {counts[1]} beads, at the area fractions .11 and .60 and with the "
                f"numbers of Kumar et al. (2014), move in one direction: their polar order is {order:.2f} and that of "
                f"the bead velocities {flow:.2f}. The run continues a flock that formed from disorder, for "
                f"{run.time:g} s; rods are coloured by direction.")
    return Part("Rods and beads", f'<video src="{film.name}" poster="{poster.name}" controls autoplay muted loop '
                "playsinline></video>", sentence, f"{PROGRAM} run models/paper-poor.toml --set time.end=20     "
                "# a third of the beads: no flock")


def fields(run, output):
    """The flock of fields and its number fluctuations beside linear theory."""
    figure = new_figure((10.4, 4.4))
    drover.plot.map(run, figure.add_axes((0.06, 0.16, 0.42, 0.80)))
    drover.plot.numbers(run, figure.add_axes((0.61, 0.47, 0.37, 0.49)), figure.add_axes((0.61, 0.16, 0.37, 0.23)))
    found = run.summary
    number, measured, linear = (found[f"rod_number{end}"].values for end in ("", "_deviation", "_deviation_linear"))
    error = found.rod_number_deviation_error.values
    ratio = measured / numpy.sqrt(number)
    best = int(ratio.argmax())
    sentence = (f"Fields: a flock of {float(run.observables.rods_total[0]):.0f} rods carried by beads, in a cell of "
                f"{run.scene['grid']['lx']:g} mm, with noise; its order is {float(found.polar_order):.2f}. In boxes of "
                f"{number[best]:.0f} rods their number fluctuates {ratio[best]:.1f}"
                f"{give_error(error[best] / numpy.sqrt(number[best]))} times as much as that of independent "
                f"rods (linear theory of the same cell: {linear[best] / numpy.sqrt(number[best]):.1f}): giant "
                f"number fluctuations. Densities are averages over {density_scale(run)}.")
    image = picture(figure, output / "flock.png", "density and order of a flock; number fluctuations and theory")
    return Part("A flock and its giant number fluctuations", image, sentence,
                f"{PROGRAM} run models/noisy-flock.toml --set noise.order=0.006 -o noisier.h5")


def give_error(error):
    return f" ± {error:.1f}" if numpy.isfinite(error) else ""


def density_scale(run):
    """The size of a pixel of the map, in mm and in rods."""
    from drover.figures.panels import shown_means
    means, pixel = shown_means(run.frames.rod_density.isel(time=-1))
    return f"{pixel[0]:.3g} mm, {float(means.mean()) * pixel[0] * pixel[1]:.0f} rods"


def boundary(models, output):
    """The flocking threshold that the coefficients measured on particles predict."""
    from drover.figures import onset_figure
    theory = drover.onset(models / TABLE, output=output / "threshold.h5", overwrite=True)
    line, field = theory.groups["line"], theory.groups["field"]
    runs = numpy.genfromtxt(models / FLOCKS, delimiter=",", names=True, skip_header=1)
    figure = new_figure((6.6, 5.2))
    axes = figure.add_axes((0.11, 0.10, 0.70, 0.72))
    keys, points = onset_figure.draw_onset(axes, field, runs)
    bar = figure.colorbar(points, cax=figure.add_axes((0.84, 0.10, 0.03, 0.72)))
    bar.set_label("polar order of the particles $P$")
    figure.legend(handles=keys, loc="upper left", bbox_to_anchor=(0.1, 0.995), ncol=1, frameon=False)
    rods = line["line_rod_fraction"].values
    at = int(numpy.abs(rods - 0.05).argmin())
    place, error = float(line["mean"][at]), float(line["mean_error"][at])
    sentence = (f"Theory: from coefficients measured on particles, here rods with the speed of those in the "
                f"experiment, flocks are predicted above a bead area fraction of {place:.2f} ± {error:.2f} where rods "
                f"cover {rods[at]:.2f}; the experiment found {0.65 - 2 * rods[at]:.2f}.")
    shape = ' class="narrow"'
    return Part("Where flocks begin", picture(figure, output / "threshold.png", "flocking threshold with its error",
                                              shape), sentence,
                f"{PROGRAM} boundary models/phase-boundary.toml -o plane.h5 && "
                "PYTHONPATH=build/release/python /usr/bin/python3 -P -m drover.figure plane.h5")


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -P -m drover.demo", description="Runs three short simulations and "
                                     "writes a page of pictures.")
    parser.add_argument("--models", type=Path, default=Path("models"), help="folder of the scenes (models)")
    parser.add_argument("-o", "--output", type=Path, default=Path("build/demo"), help="folder to write (build/demo)")
    options = parser.parse_args(arguments)

    def act():
        print("drover: a flock of particles, a flock of fields, and where flocks begin: half a minute", flush=True)
        for part in make(options.models, options.output):
            print(f"\n{part.sentence}\n  next: {part.command}")
        print(printable(f"\nOpen the page: {options.output / 'index.html'}"))
    return status_of(act)


if __name__ == "__main__":
    sys.exit(main())
