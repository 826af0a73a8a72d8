// tests/io/scene.cpp: scenes: reading, overrides, writing, consistency checks.
#include "io/scene.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

namespace drover::io::scene_tests {
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

TEST(Scene, changed_keeps_the_functions_of_the_calling_program) {
    const auto zero = std::make_shared<const physics::PointFunction>(
        [](std::size_t size, std::span<const physics::PointArgument>, std::span<double* const> out) {
            for (double* const component : out) std::fill_n(component, size, 0.0);
        });
    const Scene scene =
        parse_scene("[[terms]]\nof = \"order\"\nfunction = \"zero\"\narguments = [\"order_x\"]\ndegree = 1\n",
                    "scene.toml", {}, {{1, zero}});
    EXPECT_EQ(changed(scene, {"grid.nx=32"}).model.text_terms.at(0).call, zero);
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

// The run chooses the method along with the step, and does so of the text too.
TEST(Scene, resolved_text_leaves_the_method_open_where_the_step_is) {
    const auto names_method = [](const std::string& time) {
        const std::string text = resolved_text(parse_scene("[time]\nend = 1\n" + time, "scene.toml"));
        return text.find("\nstepper = ") != std::string::npos;
    };
    EXPECT_FALSE(names_method(""));
    EXPECT_TRUE(names_method("stepper = \"etdrk2\"\n"));
    EXPECT_TRUE(names_method("dt = 0.1\n"));
}

TEST(Scene, resolved_text_contains_every_key_of_its_kind) {
    constexpr const char* own =
        "[[field]]\nsymbol = \"phi\"\n[[white_noise]]\nsymbol = \"xi\"\n[equations]\nphi = \"-k phi + f\"\n[define]\n"
        "f = \"lap phi\"\n[[tabulated]]\nsymbol = \"a\"\nof = [\"phi\"]\nfirst = [0, 1]\nvalues = [1, 2]\n"
        "[coefficients]\nk = 1\n[time]\ndt = 0.1\n";
    for (const auto& [kind, given] : {std::pair{SceneKind::fields, "[time]\ndt = 0.1\n"},
                                      {SceneKind::particles, "[cell]\n"},
                                      {SceneKind::model, own}}) {
        const std::string text = resolved_text(parse_scene(given, "scene.toml"));
        EXPECT_EQ(resolved_text(parse_scene(text, "again.toml")), text);
        std::set<std::string> belonging;
        for (const SectionDescription& section : scene_schema(kind)) {
            belonging.insert(section.name);
            EXPECT_NE(text.find("[" + section.name + "]"), std::string::npos) << name_of(kind) << section.name;
            for (const Description& row : section.rows) {
                EXPECT_FALSE(row.doc.empty()) << section.name << "." << row.name;
                if (row.name != "spin") {  // in place of rank
                    EXPECT_NE(text.find("\n" + row.name + " = "), std::string::npos) << section.name << "." << row.name;
                }
            }
        }
        for (const SectionDescription& section : scene_schema())
            EXPECT_EQ(text.find("[" + section.name + "]") != std::string::npos, belonging.contains(section.name))
                << name_of(kind) << " " << section.name;
    }
}

TEST(Scene, declared_fields_make_a_scene_of_a_model_of_its_own) {
    const Scene scene = parse_scene(
        "[[field]]\nsymbol = \"rho\"\nreference = \"2 c\"\nnoise = \"c^2\"\n[equations]\nrho = \"D lap rho\"\n"
        "[coefficients]\nc = 3\nD = 1\n[initial]\nkind = \"formula\"\nrho = \"6 + cos(2 pi x / 64)\"\n",
        "scene.toml");
    EXPECT_EQ(scene.kind, SceneKind::model);
    const model::Model model = model_of(scene.declared);
    EXPECT_EQ(model.fields[0].reference, 6.0);
    EXPECT_EQ(model.fields[0].noise, 9.0);
    EXPECT_EQ(scene.initial.formulas.at("rho").text, "6 + cos(2 pi x / 64)");
    EXPECT_EQ(scene.time.dt, 0.0);  // linear: exact at any step
    EXPECT_NE(error_of("[[field]]\nsymbol = \"u\"\n[relaxation]\nrate = 1\n").find("expected sections of one kind"),
              std::string::npos);
    EXPECT_EQ(error_of("[[field]]\nsymbol = \"u\"\nrank = \"tensor\"\n"),
              "scene.toml:3:1: field[1].rank = \"tensor\"; expected one of [\"scalar\", \"vector\", \"nematic\", "
              "\"complex\"]");
    EXPECT_EQ(error_of("[[field]]\nsymbol = \"u\"\n[equations]\nvelocity = \"u\"\n"),
              "scene.toml:4:13: equations.velocity is the equation of no field; expected one of u");
}

TEST(Scene, adds_its_fields_to_the_model_of_the_file_that_it_names) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / text("drover-model-{}", getpid());
    std::filesystem::create_directory(folder);
    std::ofstream(folder / "flow.toml") << "[[field]]\nsymbol = \"v\"\nrank = \"vector\"\n[equations]\nv = \"-k v + nu "
                                           "lap v\"\n[coefficients]\nk = 1\nnu = 2\n";
    std::ofstream(folder / "time.toml") << "[time]\ndt = 8\n";
    std::ofstream(folder / "whole.toml") << "field = [{symbol = \"u\"}]\n[equations]\nu = \"lap u\"\n[grid]\nnx = 8\n";
    const std::string scene =
        "[model]\nfile = \"flow.toml\"\n[[field]]\nsymbol = \"c\"\n[equations]\nc = \"-v.grad c + "
        "lap c\"\n[coefficients]\nk = 3\n[time]\ndt = 0.1\n";
    const std::string name = (folder / "scene.toml").string();
    const Scene found = parse_scene(scene, name, std::vector<std::string>{"coefficients.nu=5"});
    ASSERT_EQ(found.declared.fields.size(), 2u);
    EXPECT_EQ(found.declared.fields[0].symbol, "v");
    EXPECT_EQ(found.declared.fields[1].symbol, "c");
    EXPECT_EQ(found.declared.coefficients.at("k"), 3.0);   // of the scene
    EXPECT_EQ(found.declared.coefficients.at("nu"), 5.0);  // set
    const std::string resolved = resolved_text(found);
    EXPECT_EQ(resolved_text(parse_scene(resolved, "elsewhere.toml")), resolved);
    const auto error = [&](std::string file) {
        try {
            parse_scene("[model]\nfile = \"" + file + "\"\n", name);
        } catch (const Error& problem) {
            return std::string(problem.what());
        }
        return std::string();
    };
    EXPECT_NE(error("time.toml").find("time.toml:1:2: [time] in a model that a scene names; expected"),
              std::string::npos)
        << error("time.toml");
    EXPECT_THAT(error("none.toml"), testing::AllOf(testing::HasSubstr("model.file"),
                                                   testing::HasSubstr("nor is it among the installed models")));
    // Of a whole scene the model alone; and a model that is installed with drover, unless the folder has one.
    EXPECT_EQ(parse_scene("model = {file = \"whole.toml\"}\n", name).grid.nx, numerics::Grid().nx);
    const std::string installed = "model = {file = \"cahn-hilliard.toml\"}\n";
    EXPECT_EQ(parse_scene(installed, name).declared.fields.at(0).symbol, "phi");
    std::filesystem::copy(folder / "whole.toml", folder / "cahn-hilliard.toml");
    EXPECT_EQ(parse_scene(installed, name).declared.fields.at(0).symbol, "u");
    std::filesystem::remove_all(folder);
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
}  // namespace drover::io::scene_tests
