"""tests/app/test_export.py: frames of fields as VTK and CSV, and archives in VTK's netCDF reader."""
import csv
import re

import h5py
import numpy as np
import pytest
from support import drover, write_scene

import drover as package

# Slaved beads: their velocity is recorded, and is no field of the form.
KEYS = {"fields.bead_density": True, "fields.bead_velocity": "slaved", "drag.coefficient": 1.0, "stiffness.beads": 1.0,
        "driving.strength": 0.5, "noise.order": 0.0, "noise.rods": 0.0, "initial.kind": "random",
        "initial.amplitude": 0.01, "grid.ny": 8, "grid.lx": 8.0, "time.dt": 0.01, "time.end": 0.4,
        "output.frame_every": 0.2, "output.sample_every": 0.1}


@pytest.fixture(scope="module", name="ran")
def run_made_once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    drover(folder, "run", write_scene(folder, KEYS), "--quiet")
    return folder / "flock.h5"


def read_vtk(path):
    """Time, head and arrays of a legacy VTK file of ours."""
    content = path.read_bytes()
    head = {key: words.split() for key, words in re.findall(r"^(DIMENSIONS|ORIGIN|SPACING) (.*)$",
                                                            content.decode("latin-1"), re.M)}
    columns, rows = map(int, head["DIMENSIONS"][:2])
    arrays = {}
    for match in re.finditer(rb"^(\w+) ([13]) (\d+) double\n", content[content.index(b"POINT_DATA"):], re.M):
        start, parts = content.index(match[0]) + len(match[0]), int(match[2])
        values = np.frombuffer(content, ">f8", count=columns * rows * parts, offset=start)
        arrays[match[1].decode()] = values.reshape((rows, columns) + ((3,) if parts == 3 else ()))
        assert int(match[3]) == rows * columns
    start = content.index(b"TIME 1 1 double\n") + len(b"TIME 1 1 double\n")
    return np.frombuffer(content, ">f8", count=1, offset=start)[0], head, arrays


def test_vtk_files_hold_the_frames_of_the_archive_also_under_a_name_with_a_dot(ran, tmp_path):
    shown = drover(tmp_path, "export", ran, "-o", "noise-0.5.vtk").stdout
    assert shown.strip() == "noise-0.5-0000.vtk to noise-0.5-0002.vtk: 3 frames"
    with h5py.File(ran) as file:
        for frame in range(3):
            time, head, arrays = read_vtk(tmp_path / f"noise-0.5-{frame:04}.vtk")
            assert time == file["time"][frame]
            assert head == {"DIMENSIONS": ["16", "8", "1"], "ORIGIN": ["0", "0", "0"], "SPACING": ["0.5", "2", "1"]}
            assert sorted(arrays) == ["bead_density", "bead_velocity", "polar_order", "rod_density"]
            for name in ("bead_density", "rod_density"):
                assert np.array_equal(arrays[name], file[name][frame])
            for name in ("bead_velocity", "polar_order"):
                assert np.array_equal(arrays[name][..., 0], file[f"{name}_x"][frame])
                assert np.array_equal(arrays[name][..., 1], file[f"{name}_y"][frame])
                assert not arrays[name][..., 2].any()


def test_a_csv_table_holds_every_point_of_the_chosen_frames(ran, tmp_path):
    drover(tmp_path, "export", ran, "-o", "flock.csv", "--every", "2")
    with open(tmp_path / "flock.csv", newline="", encoding="utf-8") as stream:
        head, *lines = csv.reader(stream)
    table = np.array(lines, dtype=float).reshape(2, 8, 16, -1)
    assert head[:4] == ["time [s]", "x [mm]", "y [mm]", "bead_density [mm-2]"]
    with h5py.File(ran) as file:
        for column, title in enumerate(head[3:], 3):
            assert np.array_equal(table[..., column], file[title.split(" ")[0]][::2]), title
        assert np.array_equal(table[0, 0, :, 1], file["x"]) and np.array_equal(table[:, 0, 0, 0], file["time"][::2])


def test_a_model_of_ones_own_is_exported_with_fields_in_balance_and_names_that_end_as_components(tmp_path):
    (tmp_path / "own.toml").write_text("""
field = [{symbol = "a", name = "drift_x"}, {symbol = "b", name = "drift_y"},
         {symbol = "w", rank = "vector", balance = true}, {symbol = "Q", rank = "nematic"}]
equations = {a = "-a", b = "-b + div w", w = "-w + grad a", Q = "-Q"}
grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
time = {dt = 0.1, end = 1.0}
initial = {kind = "random", amplitude = 0.1}
output = {frame_every = 1.0}
""")
    drover(tmp_path, "run", "own.toml", "--quiet")
    drover(tmp_path, "export", "own.h5", "-o", "own.vtk", "--frame", "1")
    drover(tmp_path, "export", "own.h5", "-o", "own.csv")
    arrays = read_vtk(tmp_path / "own.vtk")[2]
    assert sorted(arrays) == ["Q_xx", "Q_xy", "drift_x", "drift_y", "w"]
    with h5py.File(tmp_path / "own.h5") as file:
        assert np.array_equal(arrays["drift_y"], file["drift_y"][1])
        assert np.array_equal(arrays["w"][..., 1], file["w_y"][1]) and arrays["w"][..., 1].any()
    head = (tmp_path / "own.csv").read_text().split("\n")[0]
    assert head == "time [s],x [mm],y [mm],drift_x [1],drift_y [1],Q_xx [1],Q_xy [1],w_x [1],w_y [1]"


def test_a_csv_table_has_the_names_of_the_units_of_its_scene(tmp_path):
    (tmp_path / "own.toml").write_text("""
field = [{symbol = "u"}]
equations = {u = "lap u"}
units = {length = "um", time = "none"}
grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
time = {dt = 0.1, end = 1.0}
output = {frame_every = 1.0}
""")
    drover(tmp_path, "run", "own.toml", "--quiet")
    drover(tmp_path, "export", "own.h5", "-o", "own.csv")
    assert (tmp_path / "own.csv").read_text().startswith("time [1],x [um],y [um],u [1]\n")


def test_one_frame_is_one_file_with_the_name_that_was_given(ran, tmp_path):
    assert drover(tmp_path, "export", ran, "-o", "last.vtk", "--frame", "2").stdout.strip() == "last.vtk: fields"
    assert [path.name for path in tmp_path.iterdir()] == ["last.vtk"]


@pytest.mark.parametrize("words, message", [
    (["-o", "flock.vtk", "--frame", "3"], "has no frame 3; expected one of 0 to 2"),
    (["-o", "flock.csv", "--bodies"], "--bodies applies to particles"),
    (["-o", "kept.csv"], "exists; choose another name, or give --overwrite"),
    (["-o", "flock.xyz"], "holds no trajectory"),
    (["-o", "flock.nc"], 'the name ends with ".nc"; expected .xyz of particles, or .vtk or .csv of fields'),
    (["-o", "no/flock.csv"], 'the folder "no" does not exist; make it first'),
    (["-o", "no/flock.vtk"], 'the folder "no" does not exist; make it first'),
])
def test_what_cannot_be_exported_is_an_error_and_leaves_no_file(words, message, ran, tmp_path):
    (tmp_path / "kept.csv").write_text("precious")
    assert message in drover(tmp_path, "export", ran, *words, status=2).stderr
    assert [path.name for path in tmp_path.iterdir()] == ["kept.csv"]
    assert (tmp_path / "kept.csv").read_text() == "precious"


def test_bodies_of_fields_are_an_error_in_python_too(ran, tmp_path):
    with pytest.raises(package.Error, match="bodies applies to particles"):
        package.export(ran, tmp_path / "flock.csv", bodies=True)
    assert list(tmp_path.iterdir()) == []


def test_an_archive_is_never_replaced_by_its_export(ran, tmp_path):
    (tmp_path / "flock.csv").write_bytes(ran.read_bytes())
    message = drover(tmp_path, "export", ran, "-o", "flock.csv", "--overwrite", status=2).stderr
    assert "is an archive" in message and (tmp_path / "flock.csv").read_bytes() == ran.read_bytes()


def test_vtk_reads_an_archive_and_an_export_as_flat_images_of_the_right_size(ran, tmp_path):
    netcdf = pytest.importorskip("vtkmodules.vtkIONetCDF", reason="needs python3-vtk9")
    legacy = pytest.importorskip("vtkmodules.vtkIOLegacy", reason="needs python3-vtk9")
    (tmp_path / "flock.nc").symlink_to(ran)
    drover(tmp_path, "export", ran, "-o", "flock.vtk", "--frame", "2")
    from_archive, from_export = netcdf.vtkNetCDFCFReader(), legacy.vtkStructuredPointsReader()
    from_archive.SetFileName(str(tmp_path / "flock.nc"))
    from_archive.UpdateInformation()
    from_archive.SetDimensions("(y, x)")
    from_export.SetFileName(str(tmp_path / "flock.vtk"))
    for reader in (from_archive, from_export):
        reader.Update()
        image = reader.GetOutput()
        assert image.IsA("vtkImageData") and image.GetBounds() == (0.0, 7.5, 0.0, 14.0, 0.0, 0.0)
        assert image.GetPointData().HasArray("rod_density") or image.GetCellData().HasArray("rod_density")
