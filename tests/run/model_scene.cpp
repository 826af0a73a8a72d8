// tests/run/model_scene.cpp: what is known of scenes with a model of their own before a run.
#include <gtest/gtest.h>

#include "io/scene.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run::model_scene_tests {
namespace {

std::vector<std::string> warnings_of(const std::string& equation, const std::string& more = "",
                                     const std::string& noise = "0") {
    const io::Scene scene =
        io::parse_scene("[[field]]\nsymbol = \"u\"\nnoise = " + noise + "\n[equations]\nu = \"" + equation +
                            "\"\n[time]\ndt = 0.1\nend = 1.0\n[grid]\nnx = 32\nny = 32\nlx = 6.283185307179586\nly = "
                            "6.283185307179586\n" +
                            more,
                        "own.toml");
    return field_scene_warnings(scene, compiled_of(scene));
}
const std::string random_start = "[initial]\nkind = \"random\"\namplitude = 0.1\n";

TEST(ModelScene, that_declares_what_no_equation_has_is_warned_of) {
    const std::string used =
        "[coefficients]\na = 1.0\nb = 1.0\nc = 1.0\nd = 1.0\n[define]\nmu = \"a g u\"\n"
        "[[tabulated]]\nsymbol = \"g\"\nof = [\"b u\"]\nfirst = [-2.0, 0.0, 1.0, 2.0]\n"
        "values = [1.0, 1.0, 1.0, 1.0]\n[[white_noise]]\nsymbol = \"xi\"\n" +
        random_start;
    const auto remark = [&](const std::string& equation) {
        std::string found;
        for (const std::string& warning : warnings_of(equation, used, "\"d\""))
            if (warning.find("no effect") != std::string::npos) found = warning.substr(0, warning.find(" no effect"));
        return found;
    };
    EXPECT_EQ(remark("lap u - mu + c xi"), "");
    EXPECT_EQ(remark("lap u - c u^3 + xi"), "coefficients.a, coefficients.b, define.mu, [[tabulated]] g have");
    EXPECT_EQ(remark("lap u - mu - c u"), "[[white_noise]] xi has");
}

TEST(ModelScene, that_would_not_change_is_warned_of) {
    const std::vector<std::string> found = warnings_of("lap u - u^3");
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].find("nothing will change"), std::string::npos);
    EXPECT_TRUE(warnings_of("lap u - u^3", random_start).empty());
    EXPECT_TRUE(warnings_of("1 + lap u").empty());  // a source
    EXPECT_TRUE(warnings_of("sin(t) + lap u").empty());
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

TEST(ModelScene, whose_growth_no_term_stops_is_warned_of) {
    for (const char* const product : {"", " - |grad u|^2"}) {  // which vanishes where u is uniform
        const std::vector<std::string> found = warnings_of(std::string("20 u + lap u") + product, random_start);
        ASSERT_EQ(found.size(), 1u);
        EXPECT_NE(found[0].find("a mode grows at 20 /s at |q| = 0 /mm, by a factor e^20"), std::string::npos);
        EXPECT_NE(found[0].find("choose time.end = 0.69 or less"), std::string::npos) << found[0];  // 10^6: e^13.8
    }
    EXPECT_TRUE(warnings_of("20 u + lap u - 1e-4 u^3", random_start).empty());
    EXPECT_TRUE(warnings_of("13 u + lap u", random_start).empty());
    const std::vector<std::string> keyed =
        warnings_of("20 u + lap u - b |u|^2 u", random_start + "[coefficients]\nb = 0.0\n");
    ASSERT_EQ(keyed.size(), 1u);
    EXPECT_NE(keyed[0].find("give coefficients.b > 0"), std::string::npos) << keyed[0];
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
    EXPECT_NE(error_of("lap u - u + 3 d_x d_x u", "0.1").find("+ 3 d_x d_x u depend on direction, position or time"),
              std::string::npos);
    EXPECT_NE(error_of("lap u - u + cos(x) u", "0.1").find("+ cos(x) u depend on direction, position or time"),
              std::string::npos);
}

}  // namespace
}  // namespace drover::run::model_scene_tests
