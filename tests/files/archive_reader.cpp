// tests/files/archive_reader.cpp: the reader on damaged, foreign and malicious files.
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "files/support.hpp"

namespace drover::files::archive_reader_tests {
namespace {

using namespace testing_support;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ArchiveReader, each_kind_of_foreign_file_has_its_own_message) {
    const Folder folder;
    make_sample(folder / "run.h5", 3);
    write_contents(folder / "note.txt", "a note");
    write_contents(folder / "empty.h5", "");
    const std::string whole = contents(folder / "run.h5");
    write_contents(folder / "cut.h5", whole.substr(0, whole.size() / 2));
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    std::filesystem::create_directory(folder / "folder");
    const auto sentence = [&](const std::string& name) {
        return sentence_of([&] { const ArchiveReader reader(folder / name); });
    };
    EXPECT_THAT(sentence("none.h5"), HasSubstr("none.h5: does not exist or is not accessible; expected an archive"));
    EXPECT_THAT(sentence("folder"), HasSubstr("folder: is a folder; expected an archive"));
    EXPECT_THAT(sentence("pipe"), HasSubstr("pipe: is not a plain file; expected an archive"));
    EXPECT_THAT(sentence("note.txt"), HasSubstr("note.txt: is not an HDF5 file; expected an archive"));
    EXPECT_THAT(sentence("empty.h5"), HasSubstr("empty.h5: is not an HDF5 file; expected an archive"));
    EXPECT_THAT(sentence("cut.h5"), HasSubstr("cut.h5: opening the file failed (HDF5: truncated file: "));
}

TEST(ArchiveReader, a_missing_dataset_row_or_attribute_is_an_input_error_that_names_it) {
    const Folder folder;
    make_sample(folder / "run.h5", 3);
    const ArchiveReader reader(folder / "run.h5");
    EXPECT_FALSE(reader.has("/bead_density"));
    EXPECT_FALSE(reader.has("/observables"));
    EXPECT_FALSE(reader.has("/time/rod_density"));
    EXPECT_FALSE(reader.has("time"));
    EXPECT_TRUE(reader.has("/observables/order"));
    EXPECT_THAT(sentence_of([&] { reader.read("/bead_density"); }), HasSubstr("run.h5: has no dataset /bead_density"));
    EXPECT_THAT(sentence_of([&] { reader.read("/observables"); }), HasSubstr("has no dataset /observables"));
    EXPECT_THAT(sentence_of([&] { reader.read_row("/time", 3); }),
                HasSubstr("/time has 3 rows; expected one with the number 3"));
    EXPECT_THAT(sentence_of([&] { reader.text_attribute("author"); }), HasSubstr("has no attribute author"));
    EXPECT_THAT(sentence_of([&] { reader.text_attribute("seed"); }),
                HasSubstr("attribute seed is a number; expected a string"));
}

TEST(ArchiveReader, a_foreign_file_cannot_open_other_files_load_plugins_or_exhaust_memory) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    ASSERT_EQ(python(R"(
import h5py, numpy, os, sys
other = os.path.dirname(sys.argv[1]) + "/other.h5"
with h5py.File(other, "w") as file: file["secret"] = numpy.arange(4.0)
with open(other + ".raw", "wb") as raw: raw.write(bytes(800))
with h5py.File(sys.argv[1], "w", libver="latest") as file:
    file["plain"] = numpy.arange(6.0).reshape(2, 3)
    file["external_link"] = h5py.ExternalLink(other, "/secret")
    file["external_group"] = h5py.ExternalLink(other, "/")
    file["soft"] = h5py.SoftLink("/external_link")
    file.create_dataset("external_storage", (100,), "f8", external=[(other + ".raw", 0, h5py.h5f.UNLIMITED)])
    layout = h5py.VirtualLayout((4,), "f8"); layout[:] = h5py.VirtualSource(other, "secret", shape=(4,))
    file.create_virtual_dataset("virtual", layout)
    file.create_dataset("scaleoffset", data=numpy.arange(10), scaleoffset=0)
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_chunk((10,)); plist.set_filter(32001, h5py.h5z.FLAG_OPTIONAL)
    h5py.h5d.create(file.id, b"plugin", h5py.h5t.IEEE_F64LE, h5py.h5s.create_simple((10,)), plist)
    file["whole_numbers"] = numpy.arange(3, dtype="i4")
    file["long_whole_numbers"] = numpy.arange(3, dtype="i8")
    file["single"] = numpy.arange(3, dtype="f4")
    file["words"] = ["a", "b"]
    file["empty"] = h5py.Empty("f8")
    file["number"] = 2.5
    file["big_endian"] = numpy.arange(3, dtype=">f8")
    file.create_dataset("huge", (1 << 40, 1 << 20), "f8", chunks=(1, 1024))
    file.create_dataset("overflowing", (1 << 40, 1 << 40), "f8", chunks=(1, 1024))
    file.create_dataset("no_rows", (0, 7), "f8", maxshape=(None, 7))
    file.attrs["list"] = [1, 2, 3]
    file.attrs["changing"] = "of variable length"
    file.attrs["count"] = numpy.int32(-5)
    file.attrs["fixed"] = numpy.bytes_("fixed")
print("made")
)",
                     folder / "foreign.h5"),
              "made\n");
    const ArchiveReader reader(folder / "foreign.h5");
    const auto why_no_error = [&](const std::string& name) { return sentence_of([&] { reader.read(name); }); };
    EXPECT_EQ(reader.read("/plain").values, (std::vector<double>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(reader.read("/number").values, (std::vector<double>{2.5}));
    EXPECT_EQ(reader.read("/long_whole_numbers").values, (std::vector<double>{0, 1, 2}));
    EXPECT_EQ(reader.read("/big_endian").values, (std::vector<double>{0, 1, 2}));
    EXPECT_EQ(reader.read("/no_rows").shape, (std::vector<std::size_t>{0, 7}));
    EXPECT_THAT(why_no_error("/external_link"), HasSubstr("/external_link is a soft or external link"));
    EXPECT_THAT(why_no_error("/external_group/secret"), HasSubstr("/external_group is a soft or external link"));
    EXPECT_THAT(why_no_error("/soft"), HasSubstr("/soft is a soft or external link"));
    EXPECT_THAT(why_no_error("/external_storage"), HasSubstr("/external_storage stores its data in another file"));
    EXPECT_THAT(why_no_error("/virtual"), HasSubstr("/virtual is a virtual dataset"));
    EXPECT_THAT(why_no_error("/scaleoffset"), HasSubstr("/scaleoffset is stored with the HDF5 filter 6"));
    EXPECT_THAT(why_no_error("/plugin"), HasSubstr("/plugin is stored with the HDF5 filter 32001"));
    EXPECT_THAT(why_no_error("/whole_numbers"), HasSubstr("/whole_numbers holds neither float64 nor int64 numbers"));
    EXPECT_THAT(why_no_error("/single"), HasSubstr("/single holds neither float64 nor int64 numbers"));
    EXPECT_THAT(why_no_error("/words"), HasSubstr("/words holds neither float64 nor int64 numbers"));
    EXPECT_THAT(why_no_error("/empty"), HasSubstr("/empty is an empty dataspace"));
    EXPECT_THAT(why_no_error("/huge"), HasSubstr("/huge claims "));
    EXPECT_THAT(why_no_error("/overflowing"), HasSubstr("/overflowing claims "));
    EXPECT_THAT(sentence_of([&] { reader.read_row("/number", 0); }), HasSubstr("/number is a single number"));
    EXPECT_THAT(sentence_of([&] { reader.shape("/virtual"); }), HasSubstr("/virtual is a virtual dataset"));
    EXPECT_EQ(reader.attributes(), (std::vector<Attribute>{{"changing", std::string("of variable length")},
                                                           {"count", std::int64_t{-5}},
                                                           {"fixed", std::string("fixed")}}));
    EXPECT_THAT(sentence_of([&] { reader.contents(); }), HasSubstr("is a soft or external link"));
}

TEST(ArchiveReader, contents_are_in_the_order_of_creation_with_axes_types_and_attributes) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    ASSERT_EQ(python(R"(
import h5py, numpy, sys
with h5py.File(sys.argv[1], "w", track_order=True, libver="latest") as file:
    for name, size in ("y", 3), ("x", 2):
        file[name] = numpy.arange(float(size))
        file[name].make_scale(name)
    for number in range(20):
        file[f"b{number * 7 % 20}"] = number * numpy.ones((3, 2))
        for axis, name in enumerate("yx"): file[f"b{number * 7 % 20}"].dims[axis].attach_scale(file[name])
    file.create_group("empty")
    file["group/whole"] = numpy.arange(4)
    file["group/whole"].attrs["units"] = "mm"
with h5py.File(sys.argv[1][:-3] + "-names.h5", "w", track_order=False) as file:
    for name in "cab": file[name] = 1.0
print("made")
)",
                     folder / "one.h5"),
              "made\n");
    const Contents all = ArchiveReader(folder / "one.h5").contents();
    EXPECT_EQ(all.groups, (std::vector<std::string>{"/empty", "/group"}));
    ASSERT_EQ(all.arrays.size(), 23u);
    EXPECT_EQ(all.arrays[0].path, "/y");
    EXPECT_EQ(all.arrays[0].axes, (std::vector<std::string>{"y"}));
    for (std::size_t number = 0; number < 20; ++number) {
        const StoredArray& array = all.arrays[2 + number];
        EXPECT_EQ(array.path, "/b" + std::to_string(number * 7 % 20));
        EXPECT_EQ(array.axes, (std::vector<std::string>{"y", "x"}));
        EXPECT_EQ(array.shape, (std::vector<std::size_t>{3, 2}));
        EXPECT_FALSE(array.is_integer);
    }
    const StoredArray& last = all.arrays.back();
    EXPECT_EQ(last.path, "/group/whole");
    EXPECT_TRUE(last.is_integer);
    EXPECT_TRUE(last.axes.empty());
    EXPECT_EQ(last.attributes, (std::vector<Attribute>{{"units", std::string("mm")}}));
    const ArchiveReader other(folder / "one-names.h5");
    EXPECT_EQ(other.contents().arrays[0].path, "/a");
    EXPECT_EQ(ArchiveReader(folder / "one.h5").read("/group/whole", 1, 2).values, (std::vector<double>{1, 2}));
    EXPECT_THAT(sentence_of([&] { ArchiveReader(folder / "one.h5").read("/group/whole", 3, 2); }),
                HasSubstr("/group/whole has 4 rows; expected one with the number 4"));
}

TEST(ArchiveReader, every_allowed_storage_layout_reads_as_h5py_wrote_it) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    // Chunks that do not divide the sizes along any axis; incompressible noise; a dataset that was never written.
    ASSERT_EQ(python(R"(
import h5py, numpy, sys
a = numpy.arange(7.0*5*11).reshape(7, 5, 11)
filters = {"none": {}, "deflate": dict(compression="gzip"), "shuffle": dict(shuffle=True),
           "fletcher": dict(fletcher32=True),
           "all": dict(compression="gzip", shuffle=True, fletcher32=True)}
for libver in ("earliest", "latest"):
    with h5py.File(sys.argv[1] + "/" + libver + ".h5", "w", libver=libver) as file:
        for name, options in filters.items():
            file.create_dataset(name, data=a, chunks=(3, 2, 4), maxshape=(None, None, 11), **options)
        file["contiguous"] = a
        file.create_dataset("big_endian", data=a, dtype=">f8", chunks=(3, 5, 11), **filters["all"])
        noise = numpy.frombuffer(numpy.random.default_rng(1).bytes(7*5*11*8), dtype="u8") >> numpy.uint64(2)
        file.create_dataset("noise", data=noise.view("f8").reshape(7, 5, 11), chunks=(1, 2, 3), **filters["all"])
        file["noise_plain"] = noise.view("f8").reshape(7, 5, 11)
        file.create_dataset("line", data=numpy.arange(10.0), chunks=(4,), **filters["all"])
        file.create_dataset("unwritten", (3, 4), "f8", chunks=(2, 2), fillvalue=2.5, **filters["all"])
)",
                     folder / "."),
              "");
    for (const std::string file : {"earliest.h5", "latest.h5"}) {
        const ArchiveReader reader(folder / file);
        for (const std::string name :
             {"/none", "/deflate", "/shuffle", "/fletcher", "/all", "/contiguous", "/big_endian"}) {
            EXPECT_EQ(reader.read(name).values, numbers(7 * 5 * 11, 0.0)) << file << name;
            for (std::size_t row = 0; row < 7; ++row)
                EXPECT_EQ(reader.read_row(name, row).values, numbers(5 * 11, static_cast<double>(row * 5 * 11)))
                    << name;
        }
        EXPECT_EQ(reader.read("/noise").values, reader.read("/noise_plain").values);
        EXPECT_EQ(reader.read("/line").values, numbers(10, 0.0));
        for (std::size_t row = 0; row < 10; ++row)
            EXPECT_EQ(reader.read_row("/line", row).values, numbers(1, static_cast<double>(row)));
        EXPECT_EQ(reader.read("/unwritten").values, std::vector<double>(12, 2.5));
    }
}

TEST(ArchiveReader, a_chunk_smaller_than_its_claimed_size_is_an_error) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    ASSERT_EQ(python(R"(
import h5py, sys, zlib
with h5py.File(sys.argv[1], "w") as file:
    for name, mask, stored in (("short", 0, zlib.compress(bytes(80))), ("long", 0, zlib.compress(bytes(8000))),
                               ("unfiltered", 1, bytes(80)), ("junk", 0, b"junk"), ("nothing", 0, b"x")):
        data = file.create_dataset(name, (100,), "f8", chunks=(100,), compression="gzip")
        data.id.write_direct_chunk((0,), stored, mask)
    summed = file.create_dataset("wrong_sum", (100,), "f8", chunks=(100,), fletcher32=True)
    summed.id.write_direct_chunk((0,), bytes(800) + b"\1\0\0\0", 0)
    whole = file.create_dataset("whole", (100,), "f8", chunks=(100,), compression="gzip")
    whole.id.write_direct_chunk((0,), zlib.compress(bytes(800)), 0)
)",
                     folder / "run.h5"),
              "");
    const ArchiveReader reader(folder / "run.h5");
    for (const std::string name : {"/short", "/long", "/unfiltered", "/junk", "/nothing", "/wrong_sum"})
        EXPECT_THAT(sentence_of([&] { reader.read(name); }), HasSubstr("a chunk of " + name + " is damaged"));
    EXPECT_EQ(reader.read("/whole").values, std::vector<double>(100, 0.0));
}

/// Reads all datasets of a sample; damage must be an input Error.
void read_everything(const std::filesystem::path& file) {
    const auto attempt = [](const auto& work) {
        try {
            work();
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::input);
        }
    };
    attempt([&] {
        const ArchiveReader reader(file);
        attempt([&] { reader.attributes(); });
        attempt([&] { reader.contents(); });
        for (const std::string name : {"/time", "/x", "/rod_density", "/polar_order_x", "/observables/time",
                                       "/observables/order", "/observables/spectrum_density", "/observables/shell"}) {
            attempt([&] { reader.read(name); });
            attempt([&] { reader.read_row(name, 1); });
        }
    });
}

/// Reads damaged files in child processes; returns the number of the file that crashed one, or -1.
template <class Damage>
int crashed_at(const std::string& whole, int trials, Damage damage) {
    const Folder folder;
    for (int first = 0; first < trials; first += 50) {
        const pid_t child = ::fork();
        if (child == 0) {
            ::alarm(60);  // a hanging reader is a failure, too
            for (int trial = first; trial < std::min(first + 50, trials); ++trial) {
                write_contents(folder / "trial", std::to_string(trial));
                write_contents(folder / "run.h5", damage(whole, trial));
                read_everything(folder / "run.h5");
            }
            ::_exit(::testing::Test::HasFailure() ? 1 : 0);
        }
        int status = -1;
        ::waitpid(child, &status, 0);
        if (status != 0) return std::stoi(contents(folder / "trial"));
    }
    return -1;
}

TEST(ArchiveReader, random_byte_flips_give_a_result_or_an_error_and_no_crash) {
    const Folder folder;
    make_sample(folder / "run.h5", 6);
    EXPECT_EQ(crashed_at(contents(folder / "run.h5"), 300,
                         [](std::string bytes, int trial) {
                             std::mt19937_64 random(static_cast<std::uint64_t>(trial));
                             for (std::uint64_t flips = 1 + random() % 8; flips > 0; --flips)
                                 bytes[random() % bytes.size()] = static_cast<char>(random());
                             return bytes;
                         }),
              -1);
}

TEST(ArchiveReader, truncated_files_give_a_result_or_an_error_and_no_crash) {
    const Folder folder;
    make_sample(folder / "run.h5", 6);
    EXPECT_EQ(crashed_at(contents(folder / "run.h5"), 100,
                         [](std::string bytes, int trial) {
                             bytes.resize(bytes.size() * static_cast<std::size_t>(trial) / 100);
                             return bytes;
                         }),
              -1);
}

TEST(ArchiveReader, damage_to_the_chunk_index_without_checksum_is_no_crash) {
    const Folder folder;
    make_sample(folder / "run.h5", 6);
    EXPECT_EQ(crashed_at(contents(folder / "run.h5"), 300,
                         [](std::string bytes, int trial) {
                             std::mt19937_64 random(static_cast<std::uint64_t>(trial));
                             std::vector<std::size_t> nodes;  // of the version 1 B-tree, which begin with these letters
                             for (std::size_t at = bytes.find("TREE"); at != std::string::npos;
                                  at = bytes.find("TREE", at + 1))
                                 nodes.push_back(at);
                             const std::size_t node = nodes.at(random() % nodes.size());
                             const std::size_t place = node + 4 + random() % 100;
                             bytes[place] = static_cast<char>(trial % 3 == 0 ? 0xff : random());
                             return bytes;
                         }),
              -1);
}

}  // namespace
}  // namespace drover::files::archive_reader_tests
