"""tests/app/read_with_mdanalysis.py: reads a trajectory with MDAnalysis (the H5MD file) and ASE (the XYZ file).

Usage: DROVER=build/release/drover read_with_mdanalysis.py
Needs python3-mdanalysis and python3-ase, which CI does not install.

Runs a small scene of particles and compares what MDAnalysis and ASE read with what h5py reads.
read_with_mdanalysis.txt is a record of the output.
"""
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import h5py
import numpy

SCENE = """
[cell]
lx = 24.0
ly = 18.0
[beads]
count = 60
[rods]
count = 10
[time]
end = 0.1
[output]
frame_every = 0.005
sample_every = 0.001
"""


def main():
    warnings.simplefilter("ignore")
    import ase
    import ase.io
    import MDAnalysis

    program = str(Path(os.environ["DROVER"]).absolute())
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "tiny.toml").write_text(SCENE)
        for words in (["run", "tiny.toml", "-q"], ["export", "tiny.h5", "-o", "tiny.xyz", "--every", "4"]):
            subprocess.run([program, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        print(f"MDAnalysis {MDAnalysis.__version__}, ASE {ase.__version__}, h5py {h5py.__version__}")
        read_h5md(Path(folder, "tiny.h5"), MDAnalysis)
        read_xyz(Path(folder, "tiny.xyz"), Path(folder, "tiny.h5"), ase)


def read_h5md(path, MDAnalysis):
    with h5py.File(path) as file:
        print("H5MD version", *file["h5md"].attrs["version"], "by", file["h5md/creator"].attrs["name"].decode())
        print("groups of /particles:", *file["particles"])
        spheres = file["particles/spheres"]
        radius, boundary = spheres["radius"][:], [word.decode() for word in spheres["box"].attrs["boundary"]]
        position, image, velocity = (spheres[f"{name}/value"][:] for name in ("position", "image", "velocity"))
        shared = all(spheres[f"{name}/time"] == spheres["position/time"] for name in ("velocity", "image", "box/edges"))
    universe = MDAnalysis.Universe.empty(len(radius), trajectory=True)
    universe.add_TopologyAttr("radii", radius)
    universe.load_new(str(path), format="H5MD", convert_units=False)
    print(f"MDAnalysis: {len(universe.atoms)} spheres, {len(universe.trajectory)} frames, box "
          f"{universe.dimensions[:3]}, boundary {boundary}, one time dataset: {shared}")
    for number, step in enumerate(universe.trajectory):
        assert numpy.allclose(step.positions, position[number], atol=1e-5), "positions differ"
        assert numpy.allclose(step.velocities, velocity[number], rtol=1e-6, atol=1e-4), "velocities differ"
        last = f"t = {step.time:g} s, step {step.data['step']}"
    print(f"  last frame: {last}; positions and velocities of all frames are those of h5py")
    edges = universe.dimensions[:3]
    assert (numpy.abs(position[..., :2]) <= 0.5 * edges[:2] + 1e-12).all(), "a sphere lies outside the box"
    path_of = position + image * edges
    jump = numpy.abs(numpy.diff(path_of, axis=0)).max()
    assert jump < 0.25 * min(edges[:2]), f"unwrapped paths jump by {jump}"
    print(f"  positions lie in the box; with the images the longest way of a sphere between frames is {jump:.3g} mm")


def read_xyz(path, archive, ase):
    frames = ase.io.read(path, index=":", format="extxyz")
    first = frames[0]
    print(f"ASE: {len(frames)} frames of {len(first)} spheres, cell {first.cell.lengths()}, pbc {first.pbc}, arrays "
          f"{' '.join(sorted(first.arrays))}, Time {frames[-1].info['Time']:g}")
    with h5py.File(archive) as file:
        for frame in frames:
            row = numpy.flatnonzero(file["particles/spheres/position/time"][:] == frame.info["Time"])[0]
            assert numpy.allclose(frame.positions, file["particles/spheres/position/value"][row], rtol=1e-8, atol=1e-8)
        assert (first.arrays["body"] == file["particles/spheres/body"][:]).all()
    print("  positions of all frames and the bodies are those of h5py")


if __name__ == "__main__":
    sys.exit(main())
