// tests/run/model_scene.cpp: what is known of scenes with a model of their own before a run.
#include <gtest/gtest.h>

#include "drover/io/scene_text.hpp"
#include "drover/run/warnings.hpp"

namespace drover::run::model_scene_tests {
namespace {

std::vector<std::string> warnings_of(const std::string& equation, const std::string& more = "",
                                     const std::string& noise = "0") {
    return field_scene_warnings(io::parse_scene("[[field]]\nsymbol = \"u\"\nnoise = " + noise +
                                                    "\n[equations]\nu = \"" + equation +
                                                    "\"\n[time]\ndt = 0.1\nend = 1.0\n[grid]\nnx = 32\nny = 32\nlx = "
                                                    "6.283185307179586\nly = 6.283185307179586\n" +
                                                    more,
                                                "own.toml"));
}
const std::string random_start = "[initial]\nkind = \"random\"\namplitude = 0.1\n";

TEST(ModelScene, that_would_not_change_is_warned_of) {
    const std::vector<std::string> found = warnings_of("lap u - u^3");
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].find("nothing will change"), std::string::npos);
    EXPECT_TRUE(warnings_of("lap u - u^3", random_start).empty());
    EXPECT_TRUE(warnings_of("1 + lap u").empty());  // a source
}

TEST(ModelScene, whose_explicit_waves_are_too_fast_for_the_step_is_warned_of) {
    // The largest kept q_x is 15: c q_x dt = 1.5 c.
    EXPECT_TRUE(warnings_of("lap u - 0.6 d_x u", random_start).empty());
    const std::vector<std::string> found = warnings_of("lap u - 2 d_x u", random_start);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].find("at up to 30 /s: 3 in a step"), std::string::npos) << found[0];
    EXPECT_NE(found[0].find("choose time.dt = 0.017"), std::string::npos) << found[0];
}

TEST(ModelScene, with_functions_that_are_no_polynomials_is_warned_of) {
    const std::vector<std::string> found = warnings_of("lap u - sin(u)", random_start);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].find("no polynomials"), std::string::npos);
}

TEST(ModelScene, has_a_stationary_start_only_where_isotropic_theory_is_that_of_its_waves) {
    const auto error_of = [](const std::string& equation, const std::string& noise) {
        try {
            warnings_of(equation, "[initial]\nkind = \"stationary\"\n", noise);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(error_of("lap u - u - u^3", "0.1"), "");
    EXPECT_NE(error_of("lap u - u", "0").find("without noise"), std::string::npos);
    EXPECT_NE(error_of("lap u - u + 1", "0.1").find("references, which the equations change"), std::string::npos);
    EXPECT_NE(error_of("lap u - u + 3 d_x d_x u", "0.1").find("terms name directions"), std::string::npos);
    EXPECT_NE(error_of("lap u - u + cos(x) u", "0.1").find("depends on position or time"), std::string::npos);
}

}  // namespace
}  // namespace drover::run::model_scene_tests
