// tests/run/session.cpp: the arrays of a run in memory.
#include "drover/run/session.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "drover/base/error.hpp"

namespace drover::run::session_tests {
namespace {

TEST(Session, arrays_of_bodies_have_different_names_and_all_can_be_changed) {
    Session session(R"toml(
        cell = {lx = 12.0, ly = 12.0}
        beads = {area_fraction = 0.1}
        rods = {count = 2, area_fraction = 0.0}
        time = {dt = 2e-5, end = 0.02}
        output = {sample_every = 0.005})toml",
                    "bodies.toml");
    session.advance(10);
    std::vector<std::string> names;
    for (FrameArray& array : session.frame()) {
        names.push_back(array.name);
        if (array.name.find("velocity") != std::string::npos) std::ranges::fill(array.values, 0.0);
    }
    EXPECT_EQ(names,
              (std::vector<std::string>{"beads/position", "beads/velocity", "beads/angular_velocity", "rods/position",
                                        "rods/velocity", "rods/axis", "rods/angular_velocity"}));
    session.accept();
    for (const FrameArray& array : session.frame()) {
        if (array.name.find("velocity") != std::string::npos) {
            EXPECT_TRUE(std::ranges::all_of(array.values, [](double value) { return value == 0.0; })) << array.name;
        }
    }
}

TEST(Session, arrays_of_fields_have_the_names_of_the_fields) {
    const Session session(R"toml(
        field = [{symbol = "phi", name = "composition"}]
        equations = {phi = "-phi"}
        grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
        time = {dt = 0.1, end = 1.0}
        initial = {kind = "random", amplitude = 0.1})toml",
                          "fields.toml");
    ASSERT_EQ(session.frame().size(), 1U);
    EXPECT_EQ(session.frame().front().name, "composition");
}

}  // namespace
}  // namespace drover::run::session_tests
