// tests/physics/stiff.cpp: the linear terms limit no step: sound and drag of any rate, against a finer step.
#include <gtest/gtest.h>

#include <cmath>

#include "physics/rod_bead_model.hpp"
#include "solver_support.hpp"

namespace drover::physics::stiff_tests {
namespace {

constexpr numerics::Grid grid{32, 32, 32.0, 32.0};  // modes |k| < 8 are kept: q_max = 7 sqrt(2) 2 pi/32 = 1.944 /mm

/// A flock whose slow rates are of order one, with the drag and the stiffness of the beads given.
Model flock(double drag, double stiffness) {
    return {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
            .uniform = {.rod_density = 1.0, .bead_density = 1.0},
            .current = {.speed = 1.0},
            .drag = {.coefficient = drag},
            .viscosity = {.shear = 0.1 * drag},
            .driving = {.strength = 0.5 * drag},
            .stiffness = {.beads = stiffness, .rods = 0.05 * stiffness},
            .relaxation = {.rate = 0.5, .saturation = 1.0},
            .elasticity = {.stiffness = 0.5},
            .weathercock = {.strength = 2.0},
            .advection = {.strength = 0.3},
            .pressure = {.beads = 0.2, .rods = 0.5}};
}

/// An ordered flock with waves in every field, once the fast modes of the start have died out.
numerics::Spectra developed(const Model& model, const numerics::System& system, double dt) {
    Threads threads(1);
    const model::Start waves{.kind = model::StartKind::formula,
                             .formulas = {{"bead_density", {"1 + 0.15 * cos(2*pi*x/32) * sin(2*pi*y/32 + 0.3)"}},
                                          {"rod_density", {"1 + 0.2 * sin(2*pi*(x + y)/32)"}},
                                          {"bead_velocity_x", {"0.3"}},
                                          {"polar_order_x", {"0.6 + 0.1 * cos(2*pi*y/32)"}},
                                          {"polar_order_y", {"0.1 * sin(2*pi*(x - 2*y)/32)"}}}};
    const numerics::Spectra start = initial_spectra(waves, model, system, 1, threads);
    return evolved(system, "etdrk4", dt / 32.0, 640, start);
}

/// Errors after 20 dt with steps of dt and of the two divisions given, beside a reference of the fourth-order method.
void expect_order(const Model& model, double dt, int division, int reference_division) {
    Threads threads(1);
    const numerics::WholeRate whole = whole_rate(Equations(model), grid, physics::mean_densities(model), threads);
    const numerics::Spectra start = developed(model, whole.system, dt),
                            reference = evolved(whole.system, "etdrk4", dt / reference_division,
                                                20 * reference_division, start);
    for (const auto& [method, order] : {std::pair{"exponential-euler", 1.0}, {"etdrk2", 2.0}, {"etdrk4", 4.0}}) {
        std::vector<double> errors;
        for (const int parts : {1, division, 2 * division})
            errors.push_back(distance(evolved(whole.system, method, dt / parts, 20 * parts, start), reference));
        EXPECT_GT(std::log2(errors[1] / errors[2]), order - 0.1) << method << ": " << errors[1] << ", " << errors[2];
        // Right, not only stable: dt of slow rates of order one is 0.05 to 0.1, to the power of the method.
        EXPECT_LT(errors[0], order == 1.0 ? 1e-2 : 1e-3) << method;
    }
}

TEST(StiffFlock, keeps_the_order_of_every_method_at_a_sound_of_100_radians_and_a_drag_of_1e6_a_step) {
    const double dt = 0.05, sound = 100.0 / (dt * 1.944);
    expect_order(flock(1e6 / dt, sound * sound), dt, 2, 16);
}

TEST(StiffFlock, keeps_the_order_of_every_method_when_sound_of_100_radians_a_step_is_hardly_damped) {
    const double dt = 0.05, sound = 100.0 / (dt * 1.944);
    // Sound that turns by many radians a step is not yet in the range where the order rules: it does from some 12
    // radians on.
    expect_order(flock(20.0, sound * sound), dt, 8, 64);
}

}  // namespace
}  // namespace drover::physics::stiff_tests
