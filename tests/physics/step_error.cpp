// tests/physics/step_error.cpp: the estimated error of the time steps beside the true one.
#include "numerics/steppers/step_error.hpp"
#include "drover/numerics/transform.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "initial_spectra.hpp"
#include "physics/integrated.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::step_error_tests {
namespace {

constexpr numerics::Grid grid{.nx = 32, .ny = 32, .lx = 16.0, .ly = 16.0};
constexpr double end = 8.0;

/// Order that grows from waves and saturates in a bed of beads with inertia.
Model flock() {
    return {.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
            .uniform = {.rod_density = 1.0, .bead_density = 1.0},
            .current = {.speed = 1.0},
            .drag = {.coefficient = 4.0},
            .viscosity = {.shear = 1.0},
            .driving = {.strength = 3.0},
            .stiffness = {.beads = 2.0},
            .relaxation = {.rate = 0.3, .saturation = 1.0},
            .elasticity = {.stiffness = 0.5},
            .weathercock = {.strength = 1.5},
            .advection = {.strength = 0.5},
            .pressure = {.rods = 0.3},
            .diffusion = {.beads = 0.2, .rods = 0.2}};
}

const model::Start waves{.kind = model::StartKind::formula,
                         .formulas = {{"polar_order_x", {"0.3 + 0.2 * sin(2*pi*y/16)"}},
                                      {"polar_order_y", {"0.2 * cos(2*pi*(x + y)/16)"}}}};

/// Deviation of each field from its mean over the cell and time, of the states of a run so far.
class Fluctuations {
public:
    Fluctuations(const Form& form, bool noisy) : noisy_(noisy) {
        for (const auto& [first, count] : {std::pair{form.bead_density, 1}, std::pair{form.rod_density, 1},
                                           std::pair{form.bead_velocity, 2}, std::pair{form.polar_order, 2}})
            if (first >= 0) fields_.push_back({.first = first, .count = count});
    }
    void add(const numerics::Spectra& state) {
        for (Field& field : fields_) {
            const double x = state[field.first][0].real(),
                         y = field.count == 2 ? state[field.first + 1][0].real() : 0.0;
            field.square += square_of(state, field);
            field.x += noisy_ && field.count == 2 ? std::hypot(x, y) : x;  // the direction of a noisy flock wanders
            field.y += noisy_ ? 0.0 : y;
            ++field.moments;
        }
    }
    /// The largest difference of a field from another state over its fluctuation.
    double relative_to(const numerics::Spectra& difference) const {
        double largest = 0.0;
        for (const Field& field : fields_) {
            const double mean = std::hypot(field.x, field.y) / field.moments;
            const double variance = field.square / field.moments - mean * mean;
            largest = std::max(largest, std::sqrt(square_of(difference, field) / variance));
        }
        return largest;
    }

private:
    struct Field {
        int first = 0, count = 0;
        double moments = 0.0, square = 0.0, x = 0.0, y = 0.0;
    };
    static double square_of(const numerics::Spectra& state, const Field& field) {
        double sum = 0.0;
        for (int c = field.first; c < field.first + field.count; ++c)
            for (std::size_t m = 0; m < state.size; ++m)
                sum += (m % numerics::columns(grid) == 0 ? 1.0 : 2.0) * std::norm(state[c][m]);
        return sum;
    }
    bool noisy_;
    std::vector<Field> fields_;
};

struct Ended {
    numerics::Spectra state;
    numerics::StepError::Relative estimate;
    Fluctuations fluctuations;
};

Ended run(const Model& model, const std::string& method, double dt, bool watches = true,
          const model::Start& start = waves) {
    Threads threads(1);
    model::FieldEvolution evolution(integrated(model), grid,
                                    {.method = method, .dt = dt, .tolerance = 0.0, .watches_error = watches}, 7,
                                    threads);
    Ended ended{.state = initial_spectra(start, model, evolution.linear(), 7, threads),
                .estimate = {},
                .fluctuations = {physics::form(model), has_noise(model)}};
    evolution.start(ended.state);
    const auto steps = static_cast<std::int64_t>(std::lround(end / dt));
    for (std::int64_t step = 0; step < steps; ++step) {
        ended.fluctuations.add(ended.state);
        evolution.advance(step, ended.state);
    }
    ended.estimate = evolution.step_error();
    return ended;
}

/// The largest difference of a field from its exact state, relative to its fluctuation; without that of the direction
/// of the mean order.
double relative_distance(const Form& form, numerics::Spectra a, const Ended& exact, bool without_direction) {
    const numerics::Spectra& b = exact.state;
    for (std::size_t k = 0; k < a.values.size(); ++k) a.values[k] -= b.values[k];
    const double px = b[form.polar_order][0].real(), py = b[form.polar_order + 1][0].real(), p = std::hypot(px, py);
    for (const int c : {form.bead_velocity, form.polar_order}) {
        if (!without_direction) continue;
        const double across = (a[c + 1][0].real() * px - a[c][0].real() * py) / p;
        a[c][0] += across * py / p;
        a[c + 1][0] -= across * px / p;
    }
    return exact.fluctuations.relative_to(a);
}

TEST(StepError, is_the_true_error_within_a_factor_of_three_without_noise) {
    const Model model = flock();
    const Form form = physics::form(model);
    const Ended exact = run(model, "etdrk4-krogstad", end / 2048, false);
    for (const char* method :
         {"exponential-euler", "etdrk2", "etdrk4", "etdrk4-krogstad", "etd-abm3", "etd-abm4", "etd-abm5"})
        for (const int steps : {32, 64, 160}) {
            const Ended found = run(model, method, end / steps);
            const double error = relative_distance(form, found.state, exact, false);
            EXPECT_GT(found.estimate.error, error / 3.0) << method << ", " << steps << " steps";
            EXPECT_LT(found.estimate.error, error * 3.0) << method << ", " << steps << " steps";
        }
    // The errors of its first four steps, by another method, are measured once.
    const Ended found = run(model, "etd-abm6", end / 64);
    const double error = relative_distance(form, found.state, exact, false);
    EXPECT_GT(found.estimate.error, error / 3.0);
    EXPECT_LT(found.estimate.error, error * 4.0);
}

TEST(StepError, sees_waves_that_turn_several_times_within_a_step_and_lose_their_damping) {
    // Rods alone: sound at sqrt(u B) q, 150 rad/s for the longest wave.  Half a step resolves it no more than a whole
    // one, and both lose the damping by b |p|^2 p: the density is wrong by its whole modulation.
    Model model = flock();
    model.fields = {.bead_density = false, .rod_density = true, .bead_velocity = "absent"};
    model.current.speed = 8e5;
    const model::Start start{.kind = model::StartKind::formula,  // without divergence: b |p|^2 p makes some
                             .formulas = {{"polar_order_x", {"0.3 + 0.2 * sin(2*pi*y/16)"}},
                                          {"polar_order_y", {"0.2 * cos(2*pi*x/16)"}}}};
    model.pressure.rods = 0.2;
    model.relaxation = {.rate = -0.3, .saturation = 2.8};
    model.diffusion.beads = 0.0, model.driving = {}, model.stiffness = {}, model.drag = {}, model.viscosity = {},
    model.weathercock = {};
    const Form form = physics::form(model);
    const Ended exact = run(model, "etdrk4-krogstad", end / 8192, false, start);
    const Ended found = run(model, "etdrk2", end / 128, true, start);
    const double error = relative_distance(form, found.state, exact, false);
    EXPECT_GT(error, 0.05);
    EXPECT_GT(found.estimate.error, std::min(error, 1.0) / 3.0);  // an estimate is at most 1
    EXPECT_LT(found.estimate.error, error * 10.0);                // it adds up amplitudes, without phases and damping
}

TEST(StepError, with_noise_is_the_error_on_the_same_path_within_a_factor_of_three) {
    Model model = flock();
    model.noise = {.order = 3e-3, .rods = 1e-4};
    const Form form = physics::form(model);
    const Ended exact = run(model, "etdrk4-krogstad", end / 2048, false);
    for (const char* method : {"etdrk2", "etdrk4-krogstad"})
        for (const int steps : {32, 128}) {
            const Ended found = run(model, method, end / steps);
            const double error = relative_distance(form, found.state, exact, true);
            EXPECT_GT(found.estimate.error, error / 3.0) << method << ", " << steps << " steps";
            EXPECT_LT(found.estimate.error, error * 3.0) << method << ", " << steps << " steps";
        }
}

TEST(StepError, is_zero_for_a_linear_model_and_where_it_is_not_wanted) {
    EXPECT_EQ(run(flock(), "etdrk2", 0.25, false).estimate.error, 0.0);
    const Model linear{.uniform = flock().uniform, .relaxation = {.rate = 0.3}, .elasticity = {.stiffness = 0.5}};
    EXPECT_EQ(run(linear, "etdrk2", 0.25).estimate.error, 0.0);
}

TEST(StepError, counts_the_first_and_the_last_step) {
    // Uniform order that grows from 0.1 to saturation within one dt: with and without control of the step.
    const Model model{.uniform = {.rod_density = 1.0},
                      .relaxation = {.rate = -1.0, .saturation = 2.0},
                      .elasticity = {.stiffness = 1.0}};
    const double a = 1.0, b = 2.0, start = 0.1, length = 5.0;
    const double grown = std::exp(2.0 * a * length);
    const double exact = std::sqrt(grown / (1.0 / (start * start) + b / a * (grown - 1.0)));
    const double fluctuation = 0.5 * (exact - start);  // of the two moments of the run
    Threads threads(1);
    for (const auto& [method, tolerance] : {std::pair{"exponential-euler", 0.0},
                                            {"etdrk2", 0.0},
                                            {"etdrk4-krogstad", 0.0},
                                            {"etd-abm4", 0.0},
                                            {"arkode-ark437l2sa", 0.0},
                                            {"etdrk4-krogstad", 0.1},
                                            {"cvode-bdf", 0.01},
                                            {"arkode-ark437l2sa", 1e-2}}) {
        model::FieldEvolution evolution(integrated(model), grid,
                                        {.method = method, .dt = length, .tolerance = tolerance}, 1, threads);
        numerics::Spectra state =
            initial_spectra({.kind = model::StartKind::formula, .formulas = {{"polar_order_x", {"0.1"}}}}, model,
                            evolution.linear(), 1, threads);
        evolution.start(state);
        try {
            evolution.advance(0, state);
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("the time step is too long"), std::string::npos) << error.what();
            EXPECT_EQ(tolerance, 0.0) << method;
            continue;
        }
        const double wrong = std::abs(state[physics::form(model).polar_order][0].real() - exact) / fluctuation;
        EXPECT_GT(evolution.step_error().error, std::min(wrong, 1.0) / 3.0) << method << ", tolerance " << tolerance;
        EXPECT_LT(evolution.step_error().error, 3.0 * wrong) << method << ", tolerance " << tolerance;
    }
}

TEST(StepError, of_a_weak_wave_is_relative_to_the_wave) {
    // Of a wave of 1e-3 an error of 1 % is 1e-5 of the field: it is seen all the same.
    Model model = flock();
    model.fields = {.bead_density = false, .rod_density = true, .bead_velocity = "absent"};
    model.relaxation = {.rate = -1.0, .saturation = 2.0};
    model.current.speed = 3.0;
    model.diffusion.beads = 0.0, model.driving = {}, model.stiffness = {}, model.drag = {}, model.viscosity = {},
    model.weathercock = {};
    const model::Start wave{.kind = model::StartKind::formula,
                            .formulas = {{"rod_density", {"1 + 0.001 * cos(2*pi*x/16)"}},
                                         {"polar_order_x", {"sqrt(0.5)"}}}};
    const Form form = physics::form(model);
    const Ended exact = run(model, "etdrk4-krogstad", end / 2048, false, wave);
    const Ended found = run(model, "etdrk2", 0.25, true, wave);
    const double error = relative_distance(form, found.state, exact, false);
    EXPECT_GT(error, 5e-3);
    EXPECT_GT(found.estimate.error, error / 3.0);
    EXPECT_LT(found.estimate.error, error * 3.0);
}

TEST(StepError, does_not_change_the_fields) {
    EXPECT_EQ(run(flock(), "etdrk2", 0.25, true).state.values, run(flock(), "etdrk2", 0.25, false).state.values);
}

TEST(StepError, of_half_of_a_field_in_one_step_stops_the_run) {
    Model model = flock();
    model.advection.strength = 8.0;
    model.relaxation.rate = -2.0;
    try {
        run(model, "etdrk2", 1.0);
        FAIL() << "expected an error";
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(error.fault(), Fault::run);
        EXPECT_TRUE(message.find("the time step is too long") != std::string::npos ||
                    message.find("density") != std::string::npos)
            << message;
    }
}

/// Beads at rest but for a dip in their density, dragged by rods of constant order.
double velocity_far_from_dip(double least, double dt) {
    Model model{.fields = {.bead_density = true, .rod_density = false, .bead_velocity = "dynamic"},
                .uniform = {.bead_density = 1.0},
                .drag = {.coefficient = 5.0},
                .driving = {.strength = 3.0},
                .stiffness = {.beads = 0.5},
                .relaxation = {.rate = 0.0}};
    constexpr numerics::Grid square{.nx = 64, .ny = 64, .lx = 32.0, .ly = 32.0};
    const model::Start dip{.kind = model::StartKind::formula,
                           .formulas = {{"bead_density", {text("1 - {} * exp(-((x-16)^2+(y-16)^2)/8)", 1.0 - least)}},
                                        {"polar_order_x", {"0.5"}}}};
    Threads threads(1);
    model::FieldEvolution evolution(integrated(model), square,
                                    {.method = "etdrk2", .dt = dt, .tolerance = 0.0, .watches_error = false}, 7,
                                    threads);
    numerics::Spectra state = initial_spectra(dip, model, evolution.linear(), 7, threads);
    evolution.start(state);
    const auto steps = static_cast<std::int64_t>(std::lround(1.0 / dt));
    for (std::int64_t step = 0; step < steps; ++step) evolution.advance(step, state);
    numerics::Fields fields(square, state.count());
    numerics::Transform(square, evolution.linear().degree, threads).backward(state, fields);
    return fields[physics::form(model).bead_velocity][0];
}

TEST(StepError, of_the_velocity_far_from_a_dip_in_the_density_is_below_one_percent) {
    // Drag that acts within a step (a density of 0.01: 25 drag times) must not slow the beads elsewhere.  A step of
    // 1 ms resolves it.
    for (const double least : {0.3, 0.03, 0.01}) {
        const double resolved = velocity_far_from_dip(least, 1e-3);
        // Far away the beads accelerate alone, but for the mean density, which is below 1.
        EXPECT_NEAR(resolved, 0.3 * -std::expm1(-5.0), 0.02 * 0.3) << least;
        EXPECT_NEAR(velocity_far_from_dip(least, 0.05), resolved, 0.01 * resolved) << least;
    }
}

}  // namespace
}  // namespace drover::physics::step_error_tests
