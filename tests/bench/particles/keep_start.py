"""keep_start.py ARCHIVE FRAME START: writes one frame of a particle run as a small file for packing.file.

models/bead-flock-start.h5 is frame 40 (t = 80 s) of `drover run models/bead-flock.toml`, models/paper-flock-start.h5
frame 30 (t = 60 s) of `drover run models/paper-flock.toml`:

    keep_start.py bead-flock.h5 40 models/bead-flock-start.h5

Numbers of the frame are rounded to 7 digits; spheres, which a start does not read, keep their positions only.
"""
import sys

import h5py
import numpy

FILTERS = {"compression": "gzip", "compression_opts": 9, "shuffle": True, "fletcher32": True}
LEFT_OUT = ("velocity", "image")  # of the spheres


def copy_attributes(source, target):
    for name, value in source.attrs.items():
        if name not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME", "host", "start_time"):
            target.attrs.create(name, value, dtype=source.attrs.get_id(name).dtype)


def keep(source, target, frame, frames):
    """Copies a group with one of its frames; a hard link becomes a copy."""
    copy_attributes(source, target)
    for name, item in source.items():
        if isinstance(item, h5py.Group):
            if name not in LEFT_OUT or not source.name.endswith("spheres"):
                keep(item, target.create_group(name), frame, frames)
            continue
        values = item[()]
        if item.shape[:1] == (frames,):
            values = values[frame:frame + 1]
        if name == "value":
            values = values.astype(numpy.float32).astype(item.dtype)
        copied = target.create_dataset(name, data=values, **(FILTERS if values.size > 100 else {}))
        copy_attributes(item, copied)


if __name__ == "__main__":
    with h5py.File(sys.argv[1]) as whole, h5py.File(sys.argv[3], "w") as start:
        copy_attributes(whole, start)
        for group in ("bodies", "h5md", "particles"):
            keep(whole[group], start.create_group(group), int(sys.argv[2]),
                 len(whole["particles/spheres/position/time"]))
