// tests/io/scene.cpp: scenes: read, overridden, written back, and held against themselves.
#include "drover/io/scene.hpp"

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

TEST(Scene, that_is_empty_is_the_default_one) {
    const Scene scene = parse_scene("", "scene.toml");
    EXPECT_EQ(scene.grid.nx, 256);
    EXPECT_EQ(scene.time.stepper, "etdrk2");
}

TEST(Scene, written_out_reads_back_as_the_same_scene) {
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

TEST(Scene, takes_overrides_as_toml_or_as_bare_words) {
    const Scene scene =
        parse_scene("[grid]\nnx = 64\n", "scene.toml",
                    std::vector<std::string>{"grid.nx=32", "time.stepper = etdrk4", "sweep.vary=[\"a.b=1\"]"});
    EXPECT_EQ(scene.grid.nx, 32);
    EXPECT_EQ(scene.time.stepper, "etdrk4");
    EXPECT_EQ(scene.sweep.vary.size(), 1u);
}

TEST(Scene, errors_name_the_line_or_the_override) {
    EXPECT_EQ(error_of("[grid]\n\nnx = 7\n"), "scene.toml:3:1: grid.nx = 7; expected an even number >= 4");
    EXPECT_EQ(error_of("", {"grid.ny=9"}), "--set grid.ny=9: grid.ny = 9; expected an even number >= 4");
    EXPECT_EQ(error_of("[gird]\n"), "scene.toml:1:2: unknown table [gird]; did you mean [grid]?");
    EXPECT_EQ(error_of("nx = 4\n"),
              "scene.toml:1:1: nx stands outside a table; expected it below a line such as [grid]");
    EXPECT_EQ(error_of("[time]\ndt = 0.1\nend = 1.05\n"),
              "scene.toml:3:1: time.end = 1.05 is not a whole number of steps of time.dt = 0.1; choose 1 or 1.1");
}

TEST(Scene, has_every_key_of_the_schema_in_its_text) {
    const std::string text = resolved_text(parse_scene("", "scene.toml"));
    for (const SectionDescription& section : scene_schema()) {
        EXPECT_NE(text.find("[" + section.name + "]"), std::string::npos);
        for (const Description& row : section.rows) {
            EXPECT_NE(text.find("\n" + row.name + " = "), std::string::npos) << section.name << "." << row.name;
            EXPECT_FALSE(row.sentence.empty()) << section.name << "." << row.name;
        }
    }
}

}  // namespace
}  // namespace drover::io
