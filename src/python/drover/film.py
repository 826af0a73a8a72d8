"""drover/film.py: a film of a run, by ffmpeg.

    python3 -P -m drover.film ARCHIVE [--output MP4] [--rate N] [--every N]
"""
import argparse
import io
import os
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy

from drover.archive import loaded
from drover.error import ArgumentError, Error, status_of
from drover.run_view import run_of
from drover.new_file import part_of, write
from drover.progress import Progress
from drover.roles import maps_of
from drover.text import printable, scene_name

DOTS, SIDE = 100, 7.2        # per inch; inches of the longer side of the picture
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WHEEL = 0.9                  # inches
# Arguments of ffmpeg; a .gif has one palette, of the colours of all pictures.
CODECS = {".mp4": ["-c:v", "libx264", "-preset", "fast", "-crf", "20", "-pix_fmt", "yuv420p", "-movflags",
                   "+faststart", "-f", "mp4"],
          ".gif": ["-filter_complex", "split[a][b];[a]palettegen[c];[b][c]paletteuse=dither=none", "-f", "gif"]}
RATIOS = (0.3, 8.0)          # of the sides of a picture; longer cells leave a margin


def film(run, output, *, every=None, rate=None, field=None, progress=None):
    """Writes a film (.mp4 or .gif) of a run of fields or particles; returns its path.

    With .png it writes a numbered picture for each frame, flock-0000.png, ..., without ffmpeg; returns the pattern of
    their names, flock-*.png.

    `run` is the path of an archive, an open run, or a run in memory, which then advances to time.end: with a picture
    `every` so many seconds of the run (of an archive: every so many frames). `rate` is the number of pictures per
    second, 25 if it is not given; a GIF has 100/n. Shown are the maps of the figure, or that of one `field`. Raises
    Error where ffmpeg is missing.
    """
    output = Path(output)
    check_output(output)
    rate = checked_rate(output, rate)
    frames, moving, where, size = frames_of(run, every, field)
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    even = [2 * round(side * DOTS / 2) / DOTS for side in size]  # numbers of pixels, as the codec requires
    figure = Figure(figsize=even, dpi=DOTS)
    canvas = FigureCanvasAgg(figure)
    with rc_context({"text.usetex": False}):  # a matplotlibrc in the current folder could run LaTeX on names
        show = moving(figure, where, frames)
    canvas.draw()
    width, height = canvas.get_width_height()
    progress = Progress(0, len(frames), progress)

    def draw(take):
        for number, frame in enumerate(frames):
            show(frame)
            canvas.draw()
            take(number, canvas.buffer_rgba())
            progress.report(number + 1, f"frame {number + 1} of {len(frames)}")

    if output.suffix == ".png":
        draw(lambda number, picture: write_picture(numbered(output, number, len(frames)), picture))
        output = output.with_name(f"{output.stem}-*.png")
    else:
        with part_of(output) as part:
            with Encoder(output, part, width, height, rate) as encoder:
                draw(lambda _, picture: encoder.write(bytes(picture)))
            if not part.exists() or not part.stat().st_size:
                raise Error(f"{output}: ffmpeg wrote nothing; check the program of this name", fault="environment")
    progress.close()
    return output


def numbered(output, number, count):
    """flock-0007.png of flock.png; more digits where there are more pictures."""
    return output.with_name(f"{output.stem}-{number:0{max(4, len(str(count - 1)))}}.png")


def write_picture(path, picture):
    from matplotlib.image import imsave
    stream = io.BytesIO()
    imsave(stream, numpy.asarray(picture), format="png")
    write(path, stream.getvalue())


def check_output(output):
    if output.suffix not in (*CODECS, ".png"):
        raise Error(f'{output}: the extension "{output.suffix}" is not supported; expected .mp4, .gif or .png')
    if output.suffix in CODECS and shutil.which("ffmpeg") is None:
        raise Error("ffmpeg is not installed; a film needs it: apt-get install ffmpeg, or choose .png: a numbered "
                    "picture for each frame")


def checked_rate(output, rate):
    """Pictures per second of a file."""
    if rate is None:
        return 25
    if output.suffix not in CODECS:
        raise ArgumentError(f"rate = {rate}, and {output} is a picture for each frame; expected no rate")
    if not isinstance(rate, (int, float)) or not 1 <= rate <= 1000:
        raise ArgumentError(f"rate = {rate!r}; expected 1 to 1000 pictures per second")
    if output.suffix == ".gif" and (rate > 50 or 100 % rate):
        raise ArgumentError(f"rate = {rate}: in a GIF a picture lasts for whole hundredths of a second; expected 1, 2, "
                            "4, 5, 10, 20, 25 or 50 pictures per second, or an .mp4")
    return rate


class Encoder:
    """ffmpeg, which reads pictures and writes a film to `part`; messages call it `output`."""

    def __init__(self, output, part, width, height, rate):
        self.output = output
        words = ["ffmpeg", "-loglevel", "error", "-xerror", "-y", "-f", "rawvideo", "-pixel_format", "rgba",
                 "-video_size", f"{width}x{height}", "-framerate", str(rate), "-i", "-", *CODECS[output.suffix],
                 f"file:{part}"]  # its name may have a colon
        # A signal while ffmpeg is started would leave it behind: it waits, and raises its exception afterwards.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
        self.process = None
        try:
            self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE,
                                            start_new_session=True,
                                            preexec_fn=lambda: signal.pthread_sigmask(signal.SIG_SETMASK, before))
        finally:
            try:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
            except BaseException:
                if self.process is not None:
                    self.process.kill()
                    self.process.wait()
                raise

    def write(self, picture):
        try:
            self.process.stdin.write(picture)
        except BrokenPipeError:
            self.finish()
            raise Error(f"{self.output}: ffmpeg ended before the last picture; check the program of this name",
                        fault="environment") from None

    def finish(self):
        """ffmpeg may end with status 0 after a write that failed: what it prints counts too."""
        reason = self.process.communicate()[1].decode(errors="replace").strip().replace("\n", "; ")
        if self.process.returncode != 0 or reason:
            raise Error(f"{self.output}: ffmpeg failed: {reason or self.process.returncode}; check the folder and the "
                        "disk", fault="environment")

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        try:
            if kind is None:
                self.finish()
        finally:
            self.process.kill()
            self.process.wait()


def frames_of(run, every, field):
    """The states to draw, a function that draws them, the run with the cell, and the inches of a picture."""
    if hasattr(run, "every") and hasattr(run, "frame"):
        first = run_of(run)
        how, frames = drawing_of(first, field), []
        for frame in run.every(every):
            frames.append({name: numpy.array(array) for name, array in frame.arrays.items()} | {"time": frame.time})
        return frames, how[0], first, how[1]
    opened = run_of(run)
    how = drawing_of(opened, field)
    stride = 1 if every is None else int(every)
    if stride < 1 or stride != (every or 1):
        raise Error(f"every = {every}; expected a whole number of frames of the archive, 1 or more")
    numbers = range(0, opened.frames.sizes["time"], stride)
    fixed = {name: array.values for name, array in opened.frames.items() if "time" not in array.dims}
    return Stored(opened, numbers, fixed), how[0], opened, how[1]


def drawing_of(run, field):
    """A function that draws frames of a run, and the inches of a picture."""
    if "grid" in run.scene:
        from drover.figures import model_film
        maps = maps_of(run, field)
        return partial(model_film.shown, maps=maps, name=title_of(run)), model_film.size_of(run, maps)
    if field is not None:
        raise Error(f'field = "{field}" of a run of particles; expected none')
    return particles_shown, size_of(run)


class Stored:
    """Frames of an archive, read when they are drawn."""

    def __init__(self, run, numbers, fixed):
        self.run, self.numbers, self.fixed = run, numbers, fixed

    def __len__(self):
        return len(self.numbers)

    def __getitem__(self, place):
        if isinstance(place, slice):
            return [self[i] for i in range(*place.indices(len(self)))]
        frame = self.run.frames.isel(time=self.numbers[place])
        arrays = {name: loaded(array, self.run.path).values for name, array in frame.items() if name not in self.fixed}
        return arrays | self.fixed | {"time": float(frame["time"])}


def size_of(run):
    """Inches of the picture."""
    from drover.particles import sides_of
    ratio = numpy.clip(numpy.divide(*sides_of(run)), *RATIOS)
    return SIDE * min(1.0, ratio) + 0.9, SIDE * min(1.0, 1.0 / ratio) + 0.9


def title_of(run):
    return scene_name(run).removesuffix(" (its scene)").removesuffix(".toml").removesuffix(".h5")


def time_of(frame, run):
    from drover.figures.panels import time_text
    return time_text(f"{frame['time']:.4g}", run)


def particles_shown(figure, run, frames):
    """Draws bodies from above: beads as discs, rods as outlines coloured by their direction."""
    from drover.figures import particle_panels as panels
    from drover.figures.particle_motion import FEW_RODS, view_of
    from drover.particles import sides_of
    room = WHEEL / figure.get_figwidth() if run.frames.sizes.get("rod", 0) else 0.0  # of the colour wheel
    axes, sides, view = figure.add_axes((0.02, 0.02, 0.96 - room, 0.9)), sides_of(run), None
    if panels.is_periodic(run) and 0 < run.frames.sizes.get("rod", 0) <= FEW_RODS and (
            "bead" not in run.frames.sizes):
        view = view_of(numpy.stack([frame["rod_position"][:, :2] for frame in frames]), sides)
    panels.draw_scale(axes, panels.draw_cell(axes, run, sides, view))
    if run.frames.sizes.get("rod", 0):
        width, height = figure.get_size_inches()
        panels.draw_wheel(figure, (1.0 - 1.02 * WHEEL / width, 1.0 - 1.15 * WHEEL / height, 0.8 * WHEEL / width,
                                   0.8 * WHEEL / height), labels=False)
    drawn = []

    def show(frame):
        while drawn:
            drawn.pop().remove()
        drawn.extend(bodies_shown(axes, run, frame, sides, panels.is_periodic(run) and view is None))
        axes.set_title(f"{title_of(run)}   {time_of(frame, run)}", loc="left")
    return show


def bodies_shown(axes, run, frame, sides, periodic):
    from matplotlib.collections import EllipseCollection, PolyCollection

    from drover.figures import particle_panels as panels
    drawn = []
    if "bead_position" in frame:
        radius = frame["bead_radius"]
        which, where = panels.shifted(frame["bead_position"][:, :2], radius, sides, periodic)
        width = 2.0 * radius[which]
        drawn.append(EllipseCollection(width, width, numpy.zeros(len(which)), units="xy", offsets=where,
                                       transOffset=axes.transData, facecolor=panels.BEAD, edgecolor=panels.BEAD_EDGE,
                                       linewidth=0.3, zorder=2))
    if "rod_position" in frame:
        polygons, colours = panels.rod_outlines(frame["rod_position"], frame["rod_axis"], frame["rod_sphere_at"],
                                                frame["rod_sphere_radius"], sides, periodic)
        drawn.append(PolyCollection(polygons, facecolors=colours, edgecolors="#303030", linewidths=0.4, zorder=3))
    for collection in drawn:
        axes.add_collection(collection, autolim=False)
        if periodic:
            panels.clip(collection, axes, run, sides)
    return drawn


class Stopped(BaseException):
    """A signal, whose argument is its number."""


def stop(number, _):
    raise Stopped(number)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -P -m drover.film", description="Makes a film of a run of fields or "
                                     "particles.")
    parser.add_argument("archive", type=Path, help="file written by drover run, such as flock.h5")
    parser.add_argument("-o", "--output", type=Path, help="film (.mp4 or .gif), or .png for a numbered "
                        "picture of each frame; default: the name of the archive with .mp4")
    parser.add_argument("--every", type=int, default=1, help="show every so many frames")
    parser.add_argument("--rate", type=int, help="pictures per second; default: 25")
    parser.add_argument("--field", help="of a run of fields: the field to show; default: those of its figure")
    options = parser.parse_args(arguments)
    output = options.output or options.archive.with_suffix(".mp4")
    for number in STOPPING:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    try:
        return status_of(lambda: print(printable(film(options.archive, output, every=options.every,
                                                      rate=options.rate, field=options.field))))
    except Stopped as stopped:  # the unfinished film has been removed
        signal.signal(stopped.args[0], signal.SIG_DFL)
        os.kill(os.getpid(), stopped.args[0])


if __name__ == "__main__":
    sys.exit(main())
