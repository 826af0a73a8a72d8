// tests/io/trajectory.cpp: bodies in archives: H5MD, wrapped spheres, frames read back, resuming, extended XYZ.
#include "io/trajectory.hpp"

#include "dem/bodies/rotation.hpp"
#include "files/support.hpp"
#include "io/export.hpp"
#include "io/scene.hpp"

namespace drover::io::trajectory_tests {
namespace {

using namespace testing_support;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Two beads and a rod of three spheres, one of each beyond the edge of a periodic cell of 10 by 8 mm.
dem::Setup sample_setup() {
    dem::Setup setup;
    setup.cell.lx = 10.0;
    setup.cell.ly = 8.0;
    return setup;
}

dem::Bodies sample_bodies(double time = 0.0) {
    dem::Bodies bodies;
    bodies.shapes = {dem::make_ball(0.8, 2.7), dem::make_rod({1.1, 0.9, 0.7}, 4.0, 8.0)};
    bodies.beads = {{.position = {1.0 + time, 2.0, 0.5}, .velocity = {1.0, 2.0, 3.0}, .spin = {0.1, 0.2, 0.3}},
                    {.position = {16.0, -4.5 - time, 0.5}, .velocity = {-1.0, 0.0, 0.0}}};
    bodies.rods = {{.position = {4.5, 0.0, 0.6},
                    .velocity = {0.0, 5.0, 0.0},
                    .axis = {0.6, 0.8, 0.0},
                    .angular_momentum = {3.0, -4.0, 20.0},
                    .shape = 1}};
    return bodies;
}

std::vector<files::Recording> sample_trajectory() {
    std::vector<files::Recording> recordings;
    for (const BodyRecording& one : trajectory_recordings(sample_setup(), sample_bodies()))
        recordings.push_back(one.recording);
    return recordings;
}

const std::vector<files::Attribute> sample_scene{
    {"scene", std::string("[cell]\nlx = 10.0\nly = 8.0\n[beads]\ncount = 2\ndiameters = [0.8]\n[rods]\ncount = 1\n"
                          "diameters = [1.1, 0.9, 0.7]\nlength = 4.0\ndensities = [8.0]\n")}};

void append_frame(files::Archive& archive, double time) {
    const dem::Bodies bodies = sample_bodies(time);
    const auto recordings = trajectory_recordings(sample_setup(), bodies);
    for (std::size_t r = 0; r < recordings.size(); ++r) {
        const auto row = recordings[r].row(sample_setup(), bodies);
        const std::vector<std::span<const double>> spans(row.begin(), row.end());
        archive.append(r, time, spans, std::llround(1000.0 * time));
    }
}

void make_archive(const std::filesystem::path& file, int frames) {
    files::Archive archive = files::Archive::create(file, sample_trajectory(), sample_scene, false);
    for (int i = 0; i < frames; ++i) append_frame(archive, 0.5 * i);
    archive.commit();
}

TEST(Trajectory, h5py_finds_the_elements_that_h5md_requires) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    make_archive(folder / "run.h5", 3);
    EXPECT_EQ(python(R"(
import h5py, sys, numpy
file = h5py.File(sys.argv[1])
assert list(file["h5md"].attrs["version"]) == [1, 1]
assert file["h5md/creator"].attrs["name"] == b"drover" and file["h5md/creator"].attrs["version"]
assert file["h5md/author"].attrs["name"]
assert list(file["particles"]) == ["spheres"]
spheres = file["particles/spheres"]
assert spheres["box"].attrs["dimension"] == 3
assert list(spheres["box"].attrs["boundary"]) == [b"periodic", b"periodic", b"none"]
assert spheres["box/edges/value"].shape == (3, 3, 3)
assert (spheres["box/edges/value"][2] == numpy.diag([10.0, 8.0, 1.28])).all()
for name, width in (("position", 3), ("velocity", 3), ("image", 3)):
    element = spheres[name]
    assert element["value"].shape == (3, 5, width) and element["value"].chunks == (1, 5, width)
    assert element["value"].compression == "gzip" and element["value"].fletcher32
    assert element["step"] == spheres["position/step"] and element["time"] == spheres["position/time"]
    assert element["step"].dtype == "i8" and list(element["step"]) == [0, 500, 1000]
    assert list(element["time"]) == [0.0, 0.5, 1.0]
assert spheres["image/value"].dtype == spheres["id"].dtype == spheres["species"].dtype == spheres["body"].dtype == "i8"
assert list(spheres["species"]) == [0, 0, 1, 1, 1] and list(spheres["body"]) == [0, 1, 2, 2, 2] 
assert list(spheres["id"]) == [0, 1, 2, 3, 4]
assert spheres["position/value"].attrs["units"] == b"mm" and spheres["velocity/value"].attrs["units"] == b"mm s-1"
assert file["bodies/rods/axis/value"].shape == (3, 1, 3) and file["bodies/rods/sphere_at"].shape == (1, 3)
print("well")
)",
                     folder / "run.h5"),
              "well\n");
}

TEST(Trajectory, spheres_lie_in_the_box_and_images_unwrap_them) {
    const Folder folder;
    make_archive(folder / "run.h5", 1);
    const files::ArchiveReader reader(folder / "run.h5");
    const std::vector<double> position = reader.read_row("/particles/spheres/position/value", 0).values,
                              image = reader.read_row("/particles/spheres/image/value", 0).values;
    const dem::Bodies bodies = sample_bodies();
    const dem::Shape& rod = bodies.shapes[1];
    std::vector<dem::Vector> places{bodies.beads[0].position, bodies.beads[1].position};
    for (const double at : rod.at) places.push_back(bodies.rods[0].position + at * bodies.rods[0].axis);
    for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_GE(position[3 * i], -5.0);
        EXPECT_LT(position[3 * i], 5.0);
        EXPECT_GE(position[3 * i + 1], -4.0);
        EXPECT_LT(position[3 * i + 1], 4.0);
        EXPECT_NEAR(position[3 * i] + 10.0 * image[3 * i], places[i].x, 1e-14);  // rounding
        EXPECT_NEAR(position[3 * i + 1] + 8.0 * image[3 * i + 1], places[i].y, 1e-14);
        EXPECT_EQ(position[3 * i + 2], places[i].z);
    }
    EXPECT_EQ(image[3], 2.0);
    EXPECT_EQ(image[4], -1.0);
}

TEST(Trajectory, the_velocity_of_a_sphere_is_that_of_its_point_on_the_rotating_rod) {
    const auto row = trajectory_recordings(sample_setup(), sample_bodies())[0].row(sample_setup(), sample_bodies());
    const double dt = 1e-6;
    dem::Bodies later = sample_bodies();
    dem::Rod& rod = later.rods[0];
    const dem::Shape& shape = later.shapes[1];
    rod.position = rod.position + dt * rod.velocity;
    rod.axis = dem::turned_freely(rod.axis, rod.angular_momentum, shape.inertia_across, dt);
    for (std::size_t s = 0; s < 3; ++s) {
        const dem::Bodies now = sample_bodies();
        const dem::Vector before = now.rods[0].position + shape.at[s] * now.rods[0].axis,
                          after = rod.position + shape.at[s] * rod.axis;
        const dem::Vector speed = 1.0 / dt * (after - before);
        EXPECT_NEAR(row[1][3 * (2 + s)], speed.x, 1e-5);  // error of the difference quotient, order dt
        EXPECT_NEAR(row[1][3 * (2 + s) + 1], speed.y, 1e-5);
        EXPECT_NEAR(row[1][3 * (2 + s) + 2], speed.z, 1e-5);
    }
}

TEST(Trajectory, bodies_read_back_unchanged) {
    const Folder folder;
    make_archive(folder / "run.h5", 3);
    const files::ArchiveReader reader(folder / "run.h5");
    EXPECT_TRUE(has_trajectory(reader));
    EXPECT_EQ(frame_count(reader), 3u);
    dem::Bodies bodies = sample_bodies(7.0);
    bodies.rods[0].angular_momentum = {};
    read_bodies(reader, 2, bodies, "run.h5", {});
    const dem::Bodies expected = sample_bodies(1.0);
    EXPECT_EQ(bodies.beads[0].position.x, 2.0);
    EXPECT_EQ(bodies.beads[1].position.y, -5.5);
    EXPECT_EQ(bodies.beads[0].spin.z, 0.3);
    EXPECT_EQ(bodies.rods[0].velocity.y, 5.0);
    EXPECT_NEAR(length(bodies.rods[0].angular_momentum - expected.rods[0].angular_momentum), 0.0,
                1e-13);  // rounding of the conversion to omega
}

TEST(Trajectory, bodies_of_another_number_or_shape_are_rejected) {
    const Folder folder;
    make_archive(folder / "run.h5", 1);
    const files::ArchiveReader reader(folder / "run.h5");
    const auto why_no_error = [&](dem::Bodies bodies) {
        return sentence_of([&] { read_bodies(reader, 0, bodies, "packing.file = \"run.h5\"", {"a.toml", 3}); });
    };
    dem::Bodies more = sample_bodies();
    more.beads.push_back(more.beads[0]);
    EXPECT_THAT(why_no_error(more),
                AllOf(HasSubstr("a.toml:3: packing.file = \"run.h5\" "), HasSubstr("other bodies")));
    dem::Bodies thick = sample_bodies();
    thick.shapes[1] = dem::make_rod({1.1, 0.9, 0.8}, 4.0, 8.0);
    EXPECT_THAT(why_no_error(thick),
                HasSubstr("/bodies/rods/sphere_at differs from this scene; expected the same shapes"));
    dem::Bodies none = sample_bodies();
    none.rods.clear();
    EXPECT_THAT(why_no_error(none), HasSubstr("contains bodies in /bodies/rods, and this scene has none"));
    EXPECT_EQ(why_no_error(sample_bodies()), "");
}

TEST(Trajectory, a_resumed_archive_keeps_its_head_and_is_cut_to_its_rows) {
    const Folder folder;
    make_archive(folder / "run.h5", 4);
    {
        files::Archive archive = files::Archive::resume(folder / "run.h5", sample_trajectory(), sample_scene,
                                                        std::vector<std::size_t>{2, 2, 2});
        append_frame(archive, 9.0);
        archive.commit();
    }
    const files::ArchiveReader reader(folder / "run.h5");
    EXPECT_EQ(reader.read("/particles/spheres/velocity/time").values, (std::vector<double>{0.0, 0.5, 9.0}));
    EXPECT_EQ(reader.read("/bodies/rods/position/step").values, (std::vector<double>{0.0, 500.0, 9000.0}));
    EXPECT_EQ(reader.shape("/bodies/rods/axis/value"), (std::vector<std::size_t>{3, 1, 3}));
    auto other = sample_trajectory();
    other[0].trajectory->fixed[3].values[0] = 0.3;
    EXPECT_THAT(sentence_of([&] {
                    files::Archive::resume(folder / "run.h5", other, sample_scene, std::vector<std::size_t>{2, 2, 2});
                }),
                HasSubstr("/particles/spheres/radius has other numbers than this scene"));
}

TEST(Xyz, a_file_has_one_line_per_sphere_and_reads_back) {
    const Folder folder;
    make_archive(folder / "run.h5", 3);
    const files::ArchiveReader reader(folder / "run.h5");
    EXPECT_EQ(write_xyz(reader, "run.h5", {.every = 2}, false, folder / "run.xyz", false), 2u);
    const std::string text = contents(folder / "run.xyz");
    EXPECT_THAT(text, HasSubstr("5\nLattice=\"10 0 0 0 8 0 0 0 1.28\" Origin=\"-5 -4 0\" pbc=\"T T F\" "
                                "Properties=species:S:1:pos:R:3:radius:R:1:velo:R:3:id:I:1:body:I:1 Time=0 Step=0\n"
                                "B 1 2 0.5 0.4 1 2 3 0 0\nB -4 3.5 0.5 0.4 -1 0 0 1 1\nRh "));
    EXPECT_TRUE(is_xyz(folder / "run.xyz"));
    EXPECT_FALSE(is_xyz(folder / "run.h5"));
    const XyzInfo info = read_xyz_info(folder / "run.xyz");
    EXPECT_EQ(info.frames, 2u);
    EXPECT_EQ(info.max_lines, 5u);
    EXPECT_EQ(info.periodic, "T T F");
    EXPECT_EQ(info.times, (std::vector<double>{0.0, 1.0}));
    EXPECT_EQ(write_xyz(reader, "run.h5", {.frame = 1}, true, folder / "bodies.xyz", false), 1u);
    EXPECT_THAT(contents(folder / "bodies.xyz"), HasSubstr("\nRh 4.5 0 0.6 4 0.6 0.8 0 0 5 0 "));
}

TEST(Xyz, an_existing_file_is_unchanged_and_no_partial_file_is_left) {
    const Folder folder;
    make_archive(folder / "run.h5", 2);
    const files::ArchiveReader reader(folder / "run.h5");
    write_contents(folder / "run.xyz", "precious");
    const auto why_no_error = [&](FrameChoice choice, const char* file, bool overwrite) {
        return sentence_of([&] { write_xyz(reader, "run.h5", choice, false, folder / file, overwrite); });
    };
    EXPECT_THAT(why_no_error({}, "run.xyz", false), HasSubstr("exists; choose another name, or give --overwrite"));
    EXPECT_THAT(why_no_error({}, "run.xyz", true), HasSubstr("exists and is not an XYZ file"));
    EXPECT_EQ(contents(folder / "run.xyz"), "precious");
    EXPECT_THAT(why_no_error({.frame = 2}, "new.xyz", false),
                HasSubstr("run.h5: has no frame 2; expected one of 0 to 1"));
    EXPECT_THAT(why_no_error({}, "no/new.xyz", false), HasSubstr("cannot be written"));
    EXPECT_EQ(folder.count(), 2u);
}

TEST(Xyz, a_read_that_fails_is_not_the_end_of_the_file) {
    const std::string failing = "/proc/self/mem";  // a plain file; reads at 0 fail with EIO
    EXPECT_THAT(sentence_of([&] { read_xyz_info(failing); }), HasSubstr("read: Input/output error"));
    EXPECT_THAT(sentence_of([&] { is_xyz(failing); }), HasSubstr("read: Input/output error"));
}

TEST(Xyz, a_truncated_file_is_reported_with_its_line) {
    const Folder folder;
    write_contents(folder / "a.xyz", "2\nTime=0\nB 0 0 0\n");
    EXPECT_THAT(sentence_of([&] { read_xyz_info(folder / "a.xyz"); }),
                HasSubstr("a.xyz:3: frame 0 has 1 lines of 2; the file is truncated"));
    write_contents(folder / "b.xyz", "1\n\nB 0 0 0\nwords\n");
    EXPECT_THAT(sentence_of([&] { read_xyz_info(folder / "b.xyz"); }),
                HasSubstr("b.xyz:4: \"words\"; expected the number of particles"));
}

}  // namespace
}  // namespace drover::io::trajectory_tests
