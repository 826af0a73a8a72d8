// tests/analysis/plane_models.cpp: numbers of scenes as axes of planes, and the models on them.
#include "analysis/plane_models.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "io/scene.hpp"

namespace drover::analysis::plane_models_tests {
namespace {

io::Scene rods_and_beads() {
    return io::parse_scene(
        "[fields]\nbead_density = true\nbead_velocity = \"dynamic\"\n[uniform]\nbead_density = 0.8\nbead_area = 0.5\n"
        "[drag]\ncoefficient = 2.0\n[driving]\nstrength = 1.0\n[relaxation]\nrate = 0.3\nsaturation = 1.0\n"
        "[weathercock]\nstrength = 0.4\n[grid]\nnx = 8\nny = 8\nlx = 8.0\nly = 8.0\n[time]\ndt = 0.1\nend = 1.0\n",
        "rods.toml");
}

TEST(PlaneNumber, of_an_area_fraction_sets_the_density) {
    const io::Scene scene = rods_and_beads();
    const PlaneNumber fraction = plane_number(scene, "boundary.x", "bead_area_fraction", {}),
                      density = plane_number(scene, "boundary.x", "uniform.bead_density", {}),
                      drag = plane_number(scene, "boundary.x", "drag.coefficient", {});
    io::Scene changed = scene;
    EXPECT_NEAR(fraction.in(changed), 0.4, 1e-15);
    fraction.set(changed, 0.25);
    EXPECT_EQ(density.in(changed), 0.5);
    EXPECT_TRUE(are_same(fraction, density));
    EXPECT_FALSE(are_same(fraction, drag));
    EXPECT_THROW(plane_number(scene, "boundary.x", "rod_area_fraction", {}), Error);  // no area is known
    EXPECT_THROW(plane_number(scene, "boundary.x", "no.such", {}), Error);
}

TEST(PlaneModels, share_what_is_compiled_and_have_their_own_numbers) {
    // abar = a - lambda alpha/Gamma, over alpha and a.
    const io::Scene scene = rods_and_beads();
    const PlaneModels models(scene, {plane_number(scene, "", "driving.strength", {}), "", 0.5, 2.0},
                             {plane_number(scene, "", "relaxation.rate", {}), "", 0.1, 1.0});
    for (const double alpha : {0.5, 1.3, 2.0})
        for (const double a : {0.1, 0.7})
            EXPECT_NEAR(models.margin({alpha, a}, theory::Limit::onset).value, a - 0.4 * alpha / 2.0, 1e-15);
}

TEST(PlaneModels, of_a_model_of_ones_own_take_the_mean_of_a_conserved_field) {
    const io::Scene scene = io::parse_scene(
        "[[field]]\nsymbol = \"phi\"\nname = \"composition\"\nconserved = true\n[equations]\nphi = \"lap(phi^3 - c phi "
        "- lap phi)\"\n[coefficients]\nc = 1.0\n[time]\ndt = 0.1\nend = 1.0\n[grid]\nnx = 8\nny = 8\nlx = 8.0\nly = "
        "8.0\n",
        "own.toml");
    const PlaneModels models(scene, {plane_number(scene, "", "uniform.composition", {}), "", -1.0, 1.0},
                             {plane_number(scene, "", "coefficients.c", {}), "", 0.1, 1.0});
    for (const double phi : {-0.7, 0.1})
        EXPECT_NEAR(models.margin({phi, 0.6}, theory::Limit::phase_separation).value, 3.0 * phi * phi - 0.6, 1e-14);
}

}  // namespace
}  // namespace drover::analysis::plane_models_tests
