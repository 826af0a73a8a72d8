// tests/io/scene.cpp: scenes: reading, overrides, writing, consistency checks.
#include "drover/io/scene_text.hpp"

#include <gtest/gtest.h>

namespace drover::io {
namespace {

std::string error_of(const std::string& toml, std::vector<std::string> overrides = {}) {
    try {
        parse_scene(toml, "scene.toml", overrides);
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
    return "";
}

TEST(Scene, empty_text_gives_the_defaults) {
    const Scene scene = parse_scene("", "scene.toml");
    EXPECT_EQ(scene.grid.nx, 256);
    EXPECT_EQ(scene.time.stepper, "etdrk2");
}

TEST(Scene, resolved_text_reads_back_as_the_same_scene) {
    const Scene scene = parse_scene(
        "[grid]\nnx = 64\nlx = 0.1\n[relaxation]\nrate = -0.333\n[time]\ndt = 0.1\nend = 3\n"
        "[output]\nfile = \"a \\\"b\\\".h5\"\n[sweep]\nvary = [\"relaxation.rate = 1, 2\"]\n",
        "scene.toml");
    const std::string text = resolved_text(scene);
    EXPECT_EQ(resolved_text(parse_scene(text, "again.toml")), text);
    const Scene again = parse_scene(text, "again.toml");
    EXPECT_EQ(again.grid.nx, 64);
    EXPECT_EQ(again.grid.lx, 0.1);
    EXPECT_EQ(again.output.file, "a \"b\".h5");
    EXPECT_EQ(again.sweep.vary, (std::vector<std::string>{"relaxation.rate = 1, 2"}));
}

TEST(Scene, overrides_are_toml_values_or_bare_words) {
    const Scene scene =
        parse_scene("[grid]\nnx = 64\n", "scene.toml",
                    std::vector<std::string>{"grid.nx=32", "time.stepper = etdrk4", "sweep.vary=[\"a.b=1\"]"});
    EXPECT_EQ(scene.grid.nx, 32);
    EXPECT_EQ(scene.time.stepper, "etdrk4");
    EXPECT_EQ(scene.sweep.vary.size(), 1u);
}

TEST(Scene, a_file_whose_reads_fail_is_an_error_of_the_environment_and_not_an_empty_scene) {
    try {
        read_scene("/proc/self/mem", {});  // a plain file; reads at 0 fail with EIO
        FAIL() << "expected an Error";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::environment) << error.what();
    }
}

TEST(Scene, errors_name_the_line_or_the_override) {
    EXPECT_EQ(error_of("[grid]\n\nnx = 7\n"), "scene.toml:3:1: grid.nx = 7; expected an even number >= 4");
    EXPECT_EQ(error_of("", {"grid.ny=9"}),
              "--set grid.ny=9: grid.ny = 9; expected an even number >= 4, or 1 for fields that do not depend on y");
    EXPECT_EQ(error_of("[gird]\n"), "scene.toml:1:2: unknown table [gird]; did you mean [grid]?");
    EXPECT_EQ(error_of("nx = 4\n"), "scene.toml:1:1: nx is outside a table; expected it below a line such as [grid]");
    EXPECT_EQ(error_of("[time]\ndt = 0.1\nend = 1.05\n"),
              "scene.toml:3:1: time.end = 1.05 is not a whole number of steps of time.dt = 0.1; choose 1 or 1.1");
}

TEST(Scene, resolved_text_contains_every_key_of_its_kind) {
    for (const auto& [kind, given] : {std::pair{"fields", ""}, {"particles", "[cell]\n"}}) {
        const std::string text = resolved_text(parse_scene(given, "scene.toml"));
        for (const SectionDescription& section : scene_schema()) {
            const bool belongs = section.kind.empty() || section.kind == kind;
            EXPECT_EQ(text.find("[" + section.name + "]") != std::string::npos, belongs) << kind << " " << section.name;
            for (const Description& row : section.rows) {
                EXPECT_FALSE(row.doc.empty()) << section.name << "." << row.name;
                if (belongs && !(kind == std::string("particles") && section.kind.empty())) {
                    EXPECT_NE(text.find("\n" + row.name + " = "), std::string::npos) << section.name << "." << row.name;
                }
            }
        }
    }
}

TEST(Scene, a_section_of_particles_makes_a_scene_of_particles) {
    EXPECT_EQ(parse_scene("", "scene.toml").kind, SceneKind::fields);
    for (const char* section : {"cell", "plates", "gravity", "beads", "rods", "restitution", "friction", "kick",
                                "forces", "contacts", "packing"})
        EXPECT_EQ(parse_scene("[" + std::string(section) + "]\n", "scene.toml").kind, SceneKind::particles) << section;
    EXPECT_EQ(parse_scene("[beads]\n", "scene.toml").time.dt, 2e-5);
    EXPECT_EQ(parse_scene("[beads]\n[time]\ndt = 1e-5\n", "scene.toml").time.dt, 1e-5);
}

TEST(Scene, resolved_text_of_particles_reads_back_as_the_same_scene) {
    const Scene scene =
        parse_scene("[beads]\ncount = 7\n[plates]\namplitude = 0.05\n[time]\nend = 0.5\n", "scene.toml");
    const std::string text = resolved_text(scene);
    EXPECT_EQ(resolved_text(parse_scene(text, "again.toml")), text);
    EXPECT_EQ(text.find("[grid]"), std::string::npos);
    EXPECT_EQ(text.find("stepper"), std::string::npos);
    EXPECT_EQ(parse_scene(text, "again.toml").particles.beads.count, 7);
    EXPECT_EQ(parse_scene(text, "again.toml").particles.plates.amplitude, 0.05);
}

TEST(Scene, sections_of_both_kinds_are_rejected_with_both_locations) {
    EXPECT_EQ(error_of("[grid]\nnx = 8\n\n[beads]\ncount = 3\n"),
              "scene.toml:1:2: [grid] belongs to a scene of fields, [beads] (scene.toml:4:2) to one of particles; "
              "expected sections of one kind: remove one of them");
    EXPECT_EQ(error_of("[beads]\n[time]\nstepper = \"etdrk4\"\n"),
              "scene.toml:3:1: time.stepper is for scenes of fields, and this is a scene of particles; remove it");
    EXPECT_EQ(
        error_of("[beads]\n", {"output.powers=true"}),
        "--set output.powers=true: output.powers is for scenes of fields, and this is a scene of particles; remove it");
    for (const char* section :
         {"fields", "uniform", "relaxation", "noise", "dealiasing", "initial", "stability", "boundary"})
        EXPECT_NE(error_of("[beads]\n[" + std::string(section) + "]\n").find("to one of particles"), std::string::npos)
            << section;
}

}  // namespace
}  // namespace drover::io
