// tests/files/archive_netcdf.cpp: archives read by h5py, netCDF4 and xarray.
#include <sys/wait.h>
#include <unistd.h>

#include "files/support.hpp"

namespace drover::files::archive_netcdf_tests {
namespace {

using namespace testing_support;

void make_file(const std::filesystem::path& file) {
    const auto recordings = sample_recordings();
    const std::vector<Attribute> attributes{{"scene", std::string("λ = 3 µm")},
                                            {"title", std::string("flock")},
                                            {"seed", std::int64_t{7}},
                                            {"dt", 0.125}};
    Archive archive = Archive::create(file, recordings, attributes, false);
    for (int row = 0; row < 3; ++row) append_samples(archive, recordings);
    const Axis box{"box", "mm", "side of a box", numbers(3)};
    archive.replace(
        {"/summary",
         {box},
         {{"order_mean", "1", "mean of the order", {}}, {"number_variance", "1", "variance in boxes", {"box"}}},
         {{0.5}, numbers(3)}});
    archive.commit();
}

TEST(ArchiveNetcdf, h5py_finds_a_dimension_scale_on_every_axis_and_units_on_every_dataset) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    make_file(folder / "run.h5");
    EXPECT_EQ(python(R"(
import h5py, sys
file = h5py.File(sys.argv[1])
axes = {"/rod_density": ["time", "y", "x"], "/polar_order_x": ["time", "y", "x"], "/observables/order": ["time"],
        "/observables/spectrum_density": ["time", "shell"], "/summary/order_mean": [],
        "/summary/number_variance": ["box"]}
for name, scales in axes.items():
    group = file[name].parent
    assert [d[0] for d in file[name].dims] == [group[s] for s in scales], name
    for scale in scales:
        assert h5py.h5ds.is_scale(group[scale].id) and len(group[scale].attrs["REFERENCE_LIST"]) > 0, scale
for dim, scale in ((0, "time"), (1, "y"), (2, "x")):
    assert h5py.h5ds.is_attached(file["rod_density"].id, file[scale].id, dim)
def look(name, item):
    if isinstance(item, h5py.Dataset):
        assert item.attrs["units"] and item.attrs["long_name"] and item.attrs["comment"], name
        assert h5py.h5a.open(item.id, b"units").get_type().get_cset() == h5py.h5t.CSET_ASCII
        assert not h5py.h5a.open(item.id, b"units").get_type().is_variable_str()
        if item.chunks: assert (item.compression, item.shuffle, item.fletcher32) == ("gzip", True, True), name
        else: assert item.nbytes <= 16384 and None not in item.maxshape, name
file.visititems(look)
assert file["rod_density"].chunks == (1, 4, 5) and file["rod_density"].maxshape == (None, 4, 5)
assert file["observables/spectrum_density"].chunks == (4, 6)
assert file["time"].attrs["axis"] == b"T" and file.attrs["Conventions"] == b"CF-1.8"
assert file.attrs["scene"].decode("utf-8") == "λ = 3 µm" and file.attrs["seed"] == 7 and file.attrs["dt"] == 0.125
assert h5py.h5a.open(file.id, b"scene").get_type().get_cset() == h5py.h5t.CSET_UTF8
print("well")
)",
                     folder / "run.h5"),
              "well\n");
}

TEST(ArchiveNetcdf, the_netcdf_library_finds_shared_dimensions_and_unlimited_time) {
    if (!has_python("netCDF4")) GTEST_SKIP() << "needs python3-netcdf4";
    const Folder folder;
    make_file(folder / "run.h5");
    EXPECT_EQ(python(R"(
import netCDF4, sys
file = netCDF4.Dataset(sys.argv[1])
sizes = {n: (len(d), d.isunlimited()) for n, d in file.dimensions.items()}
assert sizes == {"time": (3, True), "y": (4, False), "x": (5, False)}
assert list(file.variables) == ["time", "y", "x", "rod_density", "polar_order_x"]
assert file["rod_density"].dimensions == ("time", "y", "x") and file["time"].dimensions == ("time",)
assert file["rod_density"].units == "mm-2" and file["time"].axis == "T" and file["time"].units == "s"
assert file.Conventions == "CF-1.8" and file.scene == "λ = 3 µm" and file.title == "flock"
o = file["observables"]
assert o["spectrum_density"].dimensions == ("time", "shell") and o.dimensions["time"].isunlimited()
assert file["summary"]["order_mean"].dimensions == () and file["summary"]["order_mean"][...] == 0.5
assert file["summary"]["number_variance"].dimensions == ("box",)
print("well")
)",
                     folder / "run.h5"),
              "well\n");
}

TEST(ArchiveNetcdf, xarray_opens_each_group_with_time_as_plain_numbers_and_no_warning) {
    if (!has_python("xarray, netCDF4")) GTEST_SKIP() << "needs python3-xarray and python3-netcdf4";
    const Folder folder;
    make_file(folder / "run.h5");
    EXPECT_EQ(python(R"(
import sys, warnings
import netCDF4, numpy, xarray
with warnings.catch_warnings():
    warnings.simplefilter("error")
    root = xarray.open_dataset(sys.argv[1])
    observables = xarray.open_dataset(sys.argv[1], group="observables")
    summary = xarray.open_dataset(sys.argv[1], group="summary")
assert root["rod_density"].dims == ("time", "y", "x") and root["time"].dtype == numpy.float64
assert list(root["time"].values) == [0, 0.5, 1] and list(root["x"].values) == [0.5, 1.5, 2.5, 3.5, 4.5]
assert numpy.isclose(root["rod_density"].values[2, 3, 4], numpy.sin(1 + 202 + 19*3))
assert observables["spectrum_density"].dims == ("time", "shell") and observables["time"].dtype == numpy.float64
assert root["rod_density"].attrs == {"units": "mm-2", "long_name": "rod density",
                                     "comment": "rods per area, sigma"}
assert float(summary["order_mean"]) == 0.5 and summary["number_variance"].dims == ("box",)
print("well")
)",
                     folder / "run.h5"),
              "well\n");
}

TEST(ArchiveNetcdf, other_programs_read_the_last_commit_while_the_writer_is_open) {
    if (!has_python("h5py, xarray, netCDF4")) GTEST_SKIP() << "needs python3-h5py, python3-xarray and python3-netcdf4";
    const Folder folder;
    const auto recordings = sample_recordings();
    Archive archive = Archive::create(folder / "run.h5", recordings, sample_attributes, false);
    for (int row = 0; row < 3; ++row) {
        append_samples(archive, recordings);
        archive.commit();
        append_samples(archive, recordings);  // not committed: invisible
        EXPECT_EQ(python(R"(
import h5py, sys, xarray
with h5py.File(sys.argv[1], "r") as file:
    print(file["time"].shape[0], file["rod_density"][...].shape)
with xarray.open_dataset(sys.argv[1], group="observables") as data:
    print(data["order"].shape)
)",
                         folder / "run.h5"),
                  text("{} ({}, 4, 5)\n({},)\n", 2 * row + 1, 2 * row + 1, 2 * row + 1));
        EXPECT_EQ(ArchiveReader(folder / "run.h5").shape("/time").at(0), 2u * static_cast<std::size_t>(row) + 1u);
    }
}

TEST(ArchiveNetcdf, an_open_reader_does_not_block_the_writer) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    const auto recordings = sample_recordings();
    Archive archive = Archive::create(folder / "run.h5", recordings, sample_attributes, false);
    append_samples(archive, recordings);
    archive.commit();
    write_contents(
        folder / "hold.py",
        "import h5py, sys\nwith h5py.File(sys.argv[1], 'r'):\n    print('open', flush=True)\n    sys.stdin.read()\n");
    // The reader reports through a pipe that the file is open; it exits at the end of its input.
    int output[2];
    ASSERT_EQ(::pipe(output), 0);
    FILE* reader = ::popen(text("/usr/bin/python3 '{}' '{}' >&{}", (folder / "hold.py").string(),
                                (folder / "run.h5").string(), output[1])
                               .c_str(),
                           "w");
    ::close(output[1]);
    char word[5] = {};
    ASSERT_EQ(::read(output[0], word, 4), 4);
    EXPECT_STREQ(word, "open");
    append_samples(archive, recordings);
    EXPECT_EQ(sentence_of([&] { archive.commit(); }), "");
    ::pclose(reader);
    ::close(output[0]);
    EXPECT_EQ(checked_rows(folder / "run.h5", recordings), 2u);
}

}  // namespace
}  // namespace drover::files::archive_netcdf_tests
