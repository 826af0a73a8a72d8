// tests/io/units.cpp: units with the names of a scene.
#include "io/units.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace drover::io::units_tests {
namespace {

TEST(Units, those_of_a_scene_without_names_of_its_own_stay) {
    for (const std::string unit : {"mm-2", "(mm-2)^2 mm2 s", "1/mm", "", "1", "rad2 mm2 s-1", "[p]^2 mm2"})
        EXPECT_EQ(renamed(unit, {}), unit);
}

TEST(Units, a_name_takes_the_place_of_a_whole_word_with_its_exponent) {
    const Units units{.length = "cm", .time = "h", .mass = "g"};
    for (const auto& [unit, expected] : {std::pair<std::string, std::string>{"mm-2", "cm-2"},
                                         {"mg mm2 s-2", "g cm2 h-2"},
                                         {"1/mm", "1/cm"},
                                         {"mg/mm^3", "g/cm^3"},
                                         {"(mm-2)^2 mm2 s", "(cm-2)^2 cm2 h"},
                                         {"rad2 mm2 s-1", "rad2 cm2 h-1"},
                                         {"samples", "samples"},
                                         {"degree", "degree"},
                                         {"1", "1"}})
        EXPECT_EQ(renamed(unit, units), expected);
}

TEST(Units, without_a_name_a_unit_leaves_no_trace) {
    const Units none{.length = "none", .time = "none", .mass = "none"};
    for (const auto& [unit, expected] : {std::pair<std::string, std::string>{"mm-2", "1"},
                                         {"mg mm2 s-2", "1"},
                                         {"1/mm", "1"},
                                         {"(mm-2)^2 mm2 s", "1"},
                                         {"rad2 mm2 s-1", "rad2"},
                                         {"mm rad s", "rad"},
                                         {"1/(mm s)", "1"},
                                         {"mg/(mm s2)", "1"},
                                         {"mm.s", "1"},
                                         {"(mm/s)^2", "1"},
                                         {"[p]^2/mm", "[p]2"},
                                         {"degree", "degree"},
                                         {"", ""}})
        EXPECT_EQ(renamed(unit, none), expected);
    const Units length{.length = "none"};
    EXPECT_EQ(renamed("(mm-2)^2 mm2 s", length), "s");
    EXPECT_EQ(renamed("mm4 s-2", length), "s-2");
    EXPECT_EQ(renamed("mm/s", length), "s-1");
    EXPECT_EQ(renamed("(mm/s)^2", length), "s-2");
    EXPECT_EQ(renamed("(mg/mm)^2", length), "mg2");
    EXPECT_EQ(renamed("1/mm/s", length), "s-1");
}

}  // namespace
}  // namespace drover::io::units_tests
