"""tests/app/test_python.py: archives in Python: xarray, h5py, drover.open_run."""
import fcntl
import os
import shutil
import struct
import threading
import zlib
from pathlib import Path

import h5py
import netCDF4
import numpy
import pytest
import xarray

import drover
from drover import results, typeset
from drover.figures import panels
from small_archive import SCENE, run, shape_settings, stopped_run


@pytest.fixture(scope="module", name="archive")
def the_archive_of_a_run(tmp_path_factory):
    return run(tmp_path_factory.mktemp("run"))


@pytest.fixture(name="copy")
def a_copy_that_a_test_may_spoil(archive, tmp_path):
    return Path(shutil.copy(archive, tmp_path / "copy.h5"))


@pytest.fixture(scope="module", name="unfinished")
def a_run_stopped_by_a_signal(tmp_path_factory):
    return stopped_run(tmp_path_factory.mktemp("unfinished"))


# --- third-party readers

def test_xarray_opens_the_file_with_named_axes_units_and_times(archive):
    with xarray.open_dataset(archive, engine="netcdf4") as frames:
        assert set(frames.data_vars) == {"rod_density", "polar_order_x", "polar_order_y"}
        for field in frames.data_vars.values():
            assert field.dims == ("time", "y", "x") and field.shape == (3, 32, 32)
            assert field.units == "mm-2" and field.long_name
        assert frames.time.values.tolist() == [0.0, 30.0, 60.0]
        assert frames.x.values.tolist() == frames.y.values.tolist() == list(range(32))
        assert (frames.time.units, frames.x.units, frames.y.units) == ("s", "mm", "mm")
        assert frames.attrs["Conventions"].startswith("CF-") and frames.attrs["seed"] == 5


@pytest.mark.parametrize("group", ["observables", "summary"])
def test_every_array_of_a_group_has_a_unit_a_meaning_and_named_axes(archive, group):
    with xarray.open_dataset(archive, group=group, engine="netcdf4") as dataset:
        for array in dataset.variables.values():
            assert array.attrs["units"] and array.attrs["long_name"]
            assert set(array.dims) <= {"time", "wavenumber", "direction", "box_side", "long_box_side", "separation"}
        if group == "observables":
            assert numpy.array_equal(dataset.time, numpy.arange(121) * 0.5)  # halves: exact
            assert dataset.structure_factor_rods.dims == ("time", "wavenumber")


def test_h5py_finds_the_same_axes_as_dimension_scales(archive):
    with h5py.File(archive) as file:
        for name in ("rod_density", "polar_order_x", "polar_order_y"):
            assert [dimension[0].name for dimension in file[name].dims] == ["/time", "/y", "/x"]
            assert file[name].attrs["units"] == b"mm-2"
        assert h5py.h5ds.is_scale(file["time"].id) and file["time"].attrs["axis"] == b"T"
        assert "axis" not in file["x"].attrs and "axis" not in file["y"].attrs  # VTK would take them for degrees
        assert [dimension[0].name for dimension in file["observables/rod_number_variance"].dims] == [
            "/observables/time", "/observables/box_side"]


def test_netcdf_finds_named_dimensions_and_only_time_is_unlimited(archive):
    with netCDF4.Dataset(archive) as file:
        assert {name: (len(axis), axis.isunlimited()) for name, axis in file.dimensions.items()} == {
            "time": (3, True), "y": (32, False), "x": (32, False)}


def test_a_wave_along_x_varies_only_along_the_axis_named_x(tmp_path):
    settings = ["grid.nx=16", "initial.kind=mode", "initial.field=rod_density", "initial.amplitude=0.1",
                "initial.mode_x=2"]
    with drover.open_run(run(tmp_path, settings)) as wave:
        density = wave.frames.rod_density.isel(time=0).load()
    expected = 0.5 + 0.1 * numpy.cos(2 * numpy.pi * 2 * density.x / 32.0)
    assert abs(density - expected).max() < 1e-14  # rounding of numbers of 0.6, after a transform there and back
    assert density.dims == ("y", "x") and density.shape == (32, 16)


# --- open_run

def test_an_open_run_has_frames_observables_summary_scene_and_provenance(archive):
    with drover.open_run(str(archive)) as opened:
        assert opened.scene["relaxation"]["rate"] == 1.0 and opened.scene["grid"]["nx"] == 32
        assert opened.attributes["seed"] == 5 and opened.attributes["scene_file"] == "rods.toml"
        order = numpy.hypot(*(opened.frames[f"polar_order_{axis}"].mean(("y", "x")) for axis in "xy"))
        order = order / opened.frames.rod_density.mean(("y", "x"))
        recorded = opened.observables.polar_order.sel(time=opened.frames.time)
        assert numpy.allclose(order, recorded, rtol=1e-9)  # the same means, summed in another order
        assert opened.summary.rods_total == pytest.approx(0.5 * 32 * 32, rel=1e-12)  # conserved, to rounding


def test_a_run_can_be_reopened_after_the_file_has_grown(copy):
    path = Path(shutil.copy(copy, copy.with_name("grown.h5")))
    with drover.open_run(path) as first:
        with h5py.File(copy, "r+") as file:
            for name in ("time", "rod_density", "polar_order_x", "polar_order_y"):
                file[name].resize(4, axis=0)
                file[name][3] = 90.0
        os.replace(copy, path)
        with drover.open_run(path) as second:
            assert (first.frames.sizes["time"], second.frames.sizes["time"]) == (3, 4)


def test_a_stopped_run_opens_without_a_summary(unfinished):
    with drover.open_run(unfinished[0]) as opened:
        assert opened.summary is None
        assert numpy.isfinite(opened.observables.polar_order).all()


def test_data_read_during_a_run_agree_with_the_final_archive(unfinished):
    path, (frames, observables) = unfinished
    with drover.open_run(path) as opened:
        assert opened.frames.sizes["time"] >= frames.sizes["time"] + 3
        assert opened.frames.isel(time=slice(0, frames.sizes["time"])).equals(frames)
        assert opened.observables.isel(time=slice(0, observables.sizes["time"])).equals(observables)


def test_a_reader_waits_for_the_end_of_a_commit(copy):
    with h5py.File(copy) as file:
        expected, chunk = file["observables/polar_order"][:], file["observables/polar_order"].id.get_chunk_info(0)
    writer = os.open(copy, os.O_RDWR)
    content = os.pread(writer, chunk.size, chunk.byte_offset)

    def lock(kind):  # the byte of a commit, for which readers wait
        fcntl.fcntl(writer, fcntl.F_OFD_SETLK, struct.pack("@hhqqi0q", kind, os.SEEK_SET, 1 << 62, 1, 0))

    found = []
    with drover.open_run(copy) as opened:  # before the commit, and again within it
        lock(fcntl.F_WRLCK)
        zeros = zlib.compress(bytes(8 * len(expected)))
        os.pwrite(writer, zeros.ljust(chunk.size, b"\0"), chunk.byte_offset)  # what no filter of HDF5 rejects
        reader = threading.Thread(target=lambda: found.append(opened.observables.polar_order.values))
        reader.start()
        reader.join(timeout=0.3)  # far longer than a reading takes, far shorter than its patience
        assert not found
        os.pwrite(writer, content, chunk.byte_offset)
        lock(fcntl.F_UNLCK)
        reader.join()
    os.close(writer)
    assert numpy.array_equal(found[0], expected)


def test_arrays_are_read_when_they_are_used_and_not_from_a_closed_file(archive):
    opened = drover.open_run(archive)
    part = opened.frames.rod_density[1, ::-2, 3:5].values
    with h5py.File(archive) as file:
        assert numpy.array_equal(part, file["rod_density"][1][::-2, 3:5])
    opened.close()
    with pytest.raises(drover.DroverError, match="is closed and /polar_order_x had not been read"):
        opened.frames.polar_order_x.load()


def spoil_attribute(path):
    with h5py.File(path, "r+") as file:
        file.attrs["scene"] = numpy.bytes_("[grid\n")


def drop_field(path):
    with h5py.File(path, "r+") as file:
        del file["polar_order_y"]


def link_elsewhere(path):
    with h5py.File(path, "r+") as file:
        del file["summary/polar_order"]
        file["summary/polar_order"] = h5py.ExternalLink("/etc/elsewhere.h5", "/secret")


def inflate(path):
    with h5py.File(path, "r+") as file:
        file["observables"].create_dataset("bomb", shape=(10**9,), chunks=(1000,), dtype="f8")


def other_filter(path):
    with h5py.File(path, "r+") as file:
        file["observables"].create_dataset("odd", data=numpy.zeros(100), chunks=(100,), compression="lzf")


def other_files(path):
    with h5py.File(path, "r+") as file:
        file["observables"].create_dataset("raw", shape=(4,), dtype="f8", external=[("/etc/hostname", 0, 32)])


@pytest.mark.parametrize("spoil, message", [
    (lambda path: path.unlink(), "does not exist; expected an archive"),
    (lambda path: (path.unlink(), path.mkdir()), "is a folder; expected an archive"),
    (lambda path: path.write_bytes(b""), "is empty"),
    (lambda path: path.write_text("rods and beads\n" * 100), "is not an HDF5 file"),
    (lambda path: path.write_bytes(path.read_bytes()[:-5000]), "truncated"),
    (spoil_attribute, "its scene is not TOML"),
    (drop_field, "has no field polar_order_y"),
    (link_elsewhere, "links are not followed"),
    (inflate, "claims 8 GB but stores 0 B"),
    (other_filter, "HDF5 filter 32000"),
    (other_files, "stores its data in another file"),
], ids=lambda value: value.replace(" ", "_") if isinstance(value, str) else "")
def test_a_damaged_archive_is_rejected_with_a_message(copy, spoil, message):
    spoil(copy)
    with pytest.raises(drover.DroverError) as error:
        drover.open_run(copy)
    assert str(error.value).startswith(str(copy)) and message in str(error.value)
    assert "\n" not in str(error.value)


def test_foreign_hdf5_files_and_scenes_are_recognised(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = [1.0]
    with pytest.raises(drover.DroverError, match="is HDF5 but not a drover archive"):
        drover.open_run(tmp_path / "other.h5")
    (tmp_path / "rods.toml").write_text(SCENE)
    with pytest.raises(drover.DroverError, match="is a scene; expected an archive: drover run"):
        drover.open_run(tmp_path / "rods.toml")


# --- numbers in figures

@pytest.mark.parametrize("shape", ["square", "oblong"])
def test_an_unfinished_run_has_the_same_boxes_and_means_as_a_summary(tmp_path, shape):
    path = run(tmp_path, [*shape_settings(shape), "analysis.warm_up=0.0"])
    with drover.open_run(path) as opened:
        whole = results.number_fluctuations(opened)
        steps = results.number_exponents(opened, whole)
        factors = results.structure_factor(opened, "order_along")
    with h5py.File(path, "r+") as file:
        del file["summary"]
    with drover.open_run(path) as opened:
        bare = results.number_fluctuations(opened)
        # The summary takes away the bias of roots and logarithms, and leaves out up to an eighth of the samples, which
        # fill no block: means differ by a fraction of their errors, which are some per cent.
        assert numpy.allclose(bare.x, whole.x, rtol=1e-12) and numpy.allclose(bare.mean, whole.mean, rtol=0.05)
        assert numpy.allclose(results.number_exponents(opened, bare).mean, steps.mean, atol=0.1)
        assert numpy.allclose(results.structure_factor(opened, "order_along").mean, factors.mean, rtol=0.1)
        assert not bare.has_linear and whole.has_linear


def test_block_averages_preserve_the_mean_and_the_position():
    x, y = numpy.arange(256) * 0.5, numpy.arange(12) * 1.0
    array = xarray.DataArray(numpy.add.outer(y, 10.0 * x), dims=("y", "x"), coords={"x": x, "y": y})
    means, block = panels.block_means(array, 64)
    assert block == (2.0, 2.0) and means.shape == (6, 64)
    assert float(means.mean()) == pytest.approx(float(array.mean()))
    assert numpy.allclose(means, numpy.add.outer(means.y.values, 10.0 * means.x.values))  # a plane stays one


@pytest.mark.parametrize("unit, text", [
    ("mm-2", "mm$^{-2}$"), ("mm", "mm"), ("mm2 s-1", "mm$^{2}$ s$^{-1}$"), ("1", "1")])
def test_units_are_written_in_mathematical_notation(unit, text):
    assert typeset.unit_text(unit) == text
