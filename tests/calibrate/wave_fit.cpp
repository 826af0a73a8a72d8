// tests/calibrate/wave_fit.cpp: coefficients from waves of runs whose coefficients are known.
#include "calibrate/wave_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/refusal.hpp"
#include "drover/numerics/stepper.hpp"
#include "numerics/fields/shells.hpp"
#include "physics/evolution.hpp"
#include "physics/rod_bead_model.hpp"
#include "physics/whole_rate.hpp"
#include "rod_bead_waves.hpp"

namespace drover::calibrate::wave_fit_tests {
namespace {

constexpr numerics::Grid grid{8, 8, 10.0, 8.0};

/// Rods about their isotropic state.
physics::Model rods() {
    return {.uniform = {.rod_density = 1.0},
            .current = {.speed = 0.8},
            .relaxation = {.rate = 0.4},
            .elasticity = {.stiffness = 0.3},
            .pressure = {.rods = 0.5},
            .diffusion = {.rods = 0.1},
            .noise = {.order = 0.3, .rods = 0.1}};
}

/// Rods and beads about their isotropic state; every field has noise of its own.
physics::Model rods_and_beads() {
    physics::Model model = rods();
    model.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"};
    model.uniform.bead_density = 1.2;
    model.inertia.bead_mass = 1.3;
    model.drag.coefficient = 1.1;
    model.viscosity = {.shear = 0.5, .bulk = 0.3};
    model.driving.strength = 0.6;
    model.stiffness = {.beads = 0.9, .rods = 0.3};
    model.weathercock.strength = 0.25;
    model.pressure.beads = 0.2;
    model.diffusion.beads = 0.1;
    model.noise.beads = 0.05;
    model.noise.velocity = 0.2;
    return model;
}

std::vector<RodBeadNumber> fitted(const std::vector<std::string>& keys) {
    std::vector<RodBeadNumber> numbers;
    for (const std::string& key : keys) {
        const physics::CoefficientRow& row = physics::coefficient_row(key);
        numbers.push_back(
            {.key = key,
             .in = [key](physics::ModelValues& model) -> double& { return physics::number_in(model, key); },
             .min = row.range.min});
    }
    return numbers;
}

/// The longest waves of a run, frame by frame.
class Recorder {
public:
    explicit Recorder(double spacing) {
        record.spacing = spacing;
        record.area = numerics::area(grid);
        for (const auto& [column, row] : {std::pair<std::size_t, std::size_t>{0, 0}, {1, 0}, {0, 1}, {1, 1}, {1, 7}}) {
            modes_.push_back(row * numerics::columns(grid) + column);
            record.q.push_back(numerics::wavevector(grid, column, row));
        }
        record.amplitudes.resize(modes_.size());
    }
    void add(const numerics::Spectra& state) {
        ++record.frames;
        for (std::size_t n = 0; n < modes_.size(); ++n)
            for (int c = 0; c < state.count(); ++c) record.amplitudes[n].push_back(state[c][modes_[n]]);
    }
    WaveRecord record;

private:
    std::vector<std::size_t> modes_;
};

/// A linear run from its stationary state, exact at any step.
WaveRecord stationary_record(const physics::Model& model, double spacing, std::uint64_t frames, std::uint64_t seed) {
    const physics::Equations e(model);
    const numerics::System system = physics::linear_system(model, grid);
    Threads threads(1);
    numerics::Stepper stepper(system, numerics::stepper_table("etdrk2"), spacing, seed, threads);
    numerics::Spectra state(grid, numerics::components(physics::layout(physics::form(e.model))));
    numerics::draw_stationary(system, {.seed = seed, .stream = Stream::stationary_state}, state);
    Recorder recorder(spacing);
    for (std::uint64_t k = 0; k < frames; ++k) {
        recorder.add(state);
        stepper.step(0.0, k, state);
    }
    return recorder.record;
}

physics::UniformPoint rest_of(const physics::ModelValues& model) {
    return physics::at_rest(physics::mean_densities(model));
}

/// The model with each fitted number at a multiple of its value.
physics::ModelValues scaled(physics::ModelValues model, const std::vector<RodBeadNumber>& numbers) {
    double factor = 0.5;  // 0.5, 2, 0.5, ...
    for (const RodBeadNumber& number : numbers) {
        number.in(model) *= factor;
        factor = 1.0 / factor;
    }
    return model;
}

/// (estimate - truth)/error of each number, from other starting values.
Eigen::VectorXd deviations(physics::ModelValues truth, const std::vector<RodBeadNumber>& numbers,
                           const WaveRecord& record, NoiseOf noise = NoiseOf::model) {
    const WaveFit fit = fit_waves(rod_bead_waves(scaled(truth, numbers), rest_of(truth), numbers), record, noise);
    Eigen::VectorXd result(static_cast<Eigen::Index>(numbers.size()));
    for (Eigen::Index i = 0; i < result.size(); ++i) {
        const RodBeadNumber& number = numbers[static_cast<std::size_t>(i)];
        const FittedValue& found = fit.values[static_cast<std::size_t>(i)];
        result(i) = (found.value - number.in(truth)) / found.error;
        EXPECT_NEAR(found.error / found.error_of_model, 1.0, 0.7) << number.key;  // of 32 segments: 13 %
    }
    return result;
}

/// Shares of 200 runs with the true value within one error, and the number of values beyond three.
struct Coverage {
    Eigen::ArrayXd inside;
    int far = 0;
};
Coverage coverage_of(const std::vector<RodBeadNumber>& numbers, NoiseOf noise) {
    constexpr int runs = 200;
    Coverage result{.inside = Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(numbers.size()))};
    for (std::uint64_t run = 1; run <= runs; ++run) {
        const Eigen::ArrayXd z = deviations(rods(), numbers, stationary_record(rods(), 0.5, 401, run), noise);
        result.inside += (z.abs() < 1.0).cast<double>() / runs;
        result.far += static_cast<int>((z.abs() > 3.0).count());
    }
    return result;
}

// A share of 68 % of 200 runs is known to 3.3 %; with errors from 32 segments, of Student's t, it is 67.5 %, and 0.5 %
// of the values are beyond 3 errors.
TEST(WaveFitStatistics, covers_the_true_coefficients_as_often_as_its_errors_say) {
    const std::vector<RodBeadNumber> numbers = fitted({"relaxation.rate", "elasticity.stiffness", "current.speed",
                                                       "pressure.rods", "diffusion.rods", "noise.order", "noise.rods"});
    const Coverage found = coverage_of(numbers, NoiseOf::model);
    for (Eigen::Index i = 0; i < found.inside.size(); ++i)
        EXPECT_NEAR(found.inside(i), 0.675, 3.0 * 0.033) << numbers[static_cast<std::size_t>(i)].key;
    EXPECT_LE(found.far, 20);  // of 1400: 7(3)
}

TEST(WaveFitStatistics, covers_them_with_any_noise_too) {
    const std::vector<RodBeadNumber> numbers = fitted({"relaxation.rate", "elasticity.stiffness", "current.speed"});
    const Coverage found = coverage_of(numbers, NoiseOf::frames);
    for (Eigen::Index i = 0; i < found.inside.size(); ++i)
        EXPECT_NEAR(found.inside(i), 0.675, 3.0 * 0.033) << numbers[static_cast<std::size_t>(i)].key;
    EXPECT_LE(found.far, 12);  // of 600: 3(2)
}

TEST(WaveFit, finds_all_coefficients_of_rods_and_beads) {
    const physics::Model model = rods_and_beads();
    const std::vector<RodBeadNumber> numbers =
        fitted({"relaxation.rate", "elasticity.stiffness", "current.speed", "pressure.rods", "pressure.beads",
                "weathercock.strength", "drag.coefficient", "driving.strength", "viscosity.shear", "viscosity.bulk",
                "stiffness.beads", "stiffness.rods", "noise.order", "noise.velocity", "noise.rods", "noise.beads"});
    const Eigen::VectorXd z = deviations(model, numbers, stationary_record(model, 0.3, 3001, 5));
    for (Eigen::Index i = 0; i < z.size(); ++i)
        EXPECT_LT(std::abs(z(i)), 3.5) << numbers[static_cast<std::size_t>(i)].key;  // of 16: 1 % beyond
}

TEST(WaveFit, finds_the_flow_exactly_where_only_the_rods_drive_it) {
    physics::Model model = rods_and_beads();
    model.noise.velocity = 0.0;
    const std::vector<RodBeadNumber> numbers = fitted({"relaxation.rate", "drag.coefficient", "driving.strength"});
    const WaveRecord record = stationary_record(model, 0.3, 1001, 6);
    const Eigen::VectorXd z = deviations(model, numbers, record);
    EXPECT_LT(z.cwiseAbs().maxCoeff(), 3.5);
    const WaveFit fit = fit_waves(rod_bead_waves(model, rest_of(model), numbers), record, NoiseOf::model);
    // Within a step noise on p changes v by its integral: errors of alpha are far below those of a.
    EXPECT_LT(fit.values[2].error / model.driving.strength, 0.3 * fit.values[0].error / model.relaxation.rate);
}

TEST(WaveFit, finds_couplings_where_one_noise_moves_two_fields) {
    // p and v of the mean alone, d_t v = -g v + k p + f/2, d_t p = -a p + lambda v + f: exact steps, drawn here.
    physics::Model model = rods_and_beads();
    const double g = model.drag.coefficient / (model.inertia.bead_mass * model.uniform.bead_density),
                 k = model.driving.strength / (model.inertia.bead_mass * model.uniform.bead_density);
    Eigen::Matrix2d rates;
    rates << -g, k, model.weathercock.strength, -model.relaxation.rate;
    constexpr double spacing = 0.4;
    const Eigen::Matrix2d step = Eigen::Matrix2d::Identity() + spacing * rates +
                                 0.5 * spacing * spacing * rates * rates +
                                 std::pow(spacing, 3) / 6.0 * rates * rates * rates +
                                 std::pow(spacing, 4) / 24.0 * rates * rates * rates * rates;
    WaveRecord record{.spacing = spacing, .area = 1.0, .frames = 8001, .q = {{0.0, 0.0}}, .amplitudes = {{}}};
    std::vector<double> normals(4 * record.frames);
    fill_normal({.seed = 3, .stream = Stream::test}, 0, 1, normals);
    Eigen::Matrix2d state = Eigen::Matrix2d::Zero();  // rows v, p; columns x, y
    for (std::size_t n = 0; n < record.frames; ++n) {
        const Eigen::Vector2d shared(normals[4 * n], normals[4 * n + 1]), own(normals[4 * n + 2], normals[4 * n + 3]);
        state = step * state;
        state.row(0) += 0.5 * shared.transpose() + 0.1 * own.transpose();
        state.row(1) += shared.transpose();
        for (const double value : {model.uniform.bead_density, model.uniform.rod_density, state(0, 0), state(0, 1),
                                   state(1, 0), state(1, 1)})
            record.amplitudes[0].push_back(value);
    }
    const std::vector<RodBeadNumber> numbers =
        fitted({"relaxation.rate", "weathercock.strength", "drag.coefficient", "driving.strength"});
    EXPECT_LT(deviations(model, numbers, record, NoiseOf::frames).cwiseAbs().maxCoeff(), 3.5);
    // alpha/Gamma, the flow of the order, is known better than either: their errors go together.
    const std::vector<FittedValue> any =
        fit_waves(rod_bead_waves(model, rest_of(model), numbers), record, NoiseOf::frames).values;
    EXPECT_EQ(any[2].correlations.size(), 4u);
    EXPECT_NEAR(any[2].correlations[2], 1.0, 1e-12);
    EXPECT_NEAR(any[2].correlations[3], any[3].correlations[2], 1e-12);
    EXPECT_GT(any[2].correlations[3], 0.3);
    // With the noise of the model, which moves each field on its own, the couplings are wrong by far.
    const WaveFit fit = fit_waves(rod_bead_waves(model, rest_of(model), numbers), record, NoiseOf::model);
    EXPECT_GT(std::abs(fit.values[3].value - model.driving.strength), 5.0 * fit.values[3].error);
}

TEST(WaveFit, does_not_depend_on_the_spacing_of_the_frames) {
    const physics::Model model = rods();
    const std::vector<RodBeadNumber> numbers = fitted({"relaxation.rate", "elasticity.stiffness", "current.speed"});
    const WaveRecord record = stationary_record(model, 0.25, 4001, 7);
    for (const std::size_t every : {1, 2, 8}) {
        const WaveRecord some = thinned(record, every);
        EXPECT_EQ(some.frames, 4000 / every + 1);
        EXPECT_LT(deviations(model, numbers, some).cwiseAbs().maxCoeff(), 3.5) << every;
    }
}

TEST(WaveFit, is_exact_where_a_field_decays_by_any_factor_between_two_frames) {
    // Fields without coupling: the most likely strength of each is 2 k <|a' - e^{-ks} a|^2>/(1 - e^{-2ks}).
    // exp(+k s) of the fast one would overflow the digits of the other at k s = 40, and the numbers at 800.
    for (const double fast : {1.0, 8.0, 40.0, 800.0}) {
        constexpr double slow = 0.7;
        WaveRecord record{.spacing = 1.0, .area = 80.0, .frames = 200, .q = {{0.3, 0.0}}, .amplitudes = {{}}};
        std::vector<double> parts(4 * record.frames);
        fill_normal({.seed = 5, .stream = Stream::stationary_state}, 0, 1, parts);
        for (std::size_t k = 0; k < parts.size(); k += 2) record.amplitudes[0].emplace_back(parts[k], parts[k + 1]);
        const WaveModel model{
            .fields = {{}, {}},
            .numbers = {{.key = "slow", .start = 1.0, .min = 0.0}, {.key = "fast", .start = 1.0, .min = 0.0}},
            .at = [&](const std::vector<double>& strengths) {
                const auto diagonal = [](double first, double second) {
                    model::Symbol symbol = model::Symbol::Zero(2, 2);
                    symbol(0, 0) = first;
                    symbol(1, 1) = second;
                    return symbol;
                };
                return LinearWaves{.symbol = [=](const auto&) { return diagonal(-slow, -fast); },
                                   .noise = [=](const auto&) { return diagonal(strengths[0], strengths[1]); }};
            }};
        const WaveFit fit = fit_waves(model, record, NoiseOf::model);
        for (const std::size_t field : {0u, 1u}) {
            const double rate = field == 0 ? slow : fast, kept = std::exp(-rate);
            double square = 0.0;
            for (std::size_t k = 1; k < record.frames; ++k)
                square +=
                    std::norm(record.amplitudes[0][2 * k + field] - kept * record.amplitudes[0][2 * k - 2 + field]);
            square /= static_cast<double>(record.frames - 1);
            // The search ends within 1e-4 of an error, which is 7 % of the value here.
            EXPECT_NEAR(fit.values[field].value, record.area * 2.0 * rate * square / (1.0 - kept * kept),
                        1e-5 * fit.values[field].value)
                << "of field " << field << " with " << fast;
        }
    }
}

TEST(WaveFit, of_a_flock_finds_what_stops_and_what_carries_its_order) {
    constexpr double weak = 1e-6;  // of a natural noise: waves of 1e-3 of the order, so that they are linear to 1e-6
    physics::Model model = rods();
    model.relaxation = {.rate = -0.4, .saturation = 0.9};
    model.advection = {.strength = 0.5};
    model.orienting_field = {.x = 0.05};  // holds the direction
    model.pressure.rods = 0.2;
    model.noise = {.order = 0.3 * weak, .rods = 0.1 * weak};
    physics::Evolution run(model, grid);
    const physics::StationaryStates states = physics::stationary_states(physics::Equations(model));
    const physics::UniformPoint flock = states.states.front().point;
    ASSERT_GT(flock.order.x(), 0.5);
    numerics::Spectra state(grid, 3);
    state[0][0] = flock.rod_density;
    state[1][0] = flock.order.x();
    Recorder recorder(0.4);
    numerics::Stepper stepper = run.stepper("etdrk4-krogstad", 0.1);
    for (std::uint64_t k = 0; k < 2001; ++k) {
        recorder.add(state);
        for (std::uint64_t n = 0; n < 4; ++n) stepper.step(0.0, k * 4 + n, state);
    }
    recorder.record.q.erase(recorder.record.q.begin());  // the mean has the order of the flock itself
    recorder.record.amplitudes.erase(recorder.record.amplitudes.begin());
    const std::vector<RodBeadNumber> numbers =
        fitted({"relaxation.saturation", "advection.strength", "elasticity.stiffness", "pressure.rods", "noise.order"});
    const WaveFit fit =
        fit_waves(rod_bead_waves(scaled(model, numbers), flock, numbers), recorder.record, NoiseOf::model);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        physics::ModelValues truth = model;
        const double known = numbers[i].in(truth);
        EXPECT_LT(std::abs(fit.values[i].value - known), 3.5 * fit.values[i].error) << numbers[i].key;
        EXPECT_LT(fit.values[i].error, 0.2 * known) << numbers[i].key;
    }
}

TEST(WaveFit, keeps_a_coefficient_at_its_least_value_where_waves_would_prefer_less) {
    physics::Model model = rods();
    int at_bound = 0;
    constexpr int runs = 12;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
        const WaveRecord record = stationary_record(model, 0.5, 401, seed);
        physics::Model start = model;
        start.elasticity.splay = 0.2;  // it is 0 in truth
        const WaveFit fit =
            fit_waves(rod_bead_waves(start, rest_of(model), fitted({"elasticity.splay"})), record, NoiseOf::model);
        EXPECT_GE(fit.values[0].value, 0.0);
        EXPECT_LT(fit.values[0].value, 4.0 * fit.values[0].error);
        EXPECT_EQ(fit.values[0].at_bound, fit.values[0].value == 0.0);
        at_bound += fit.values[0].at_bound ? 1 : 0;
    }
    EXPECT_GE(at_bound, 2);  // half of them; 1 or none has a chance of 0.3 %
    EXPECT_LE(at_bound, 10);
}

TEST(WaveFit, refuses_what_waves_do_not_determine) {
    const physics::Model model = rods_and_beads();
    const WaveRecord record = stationary_record(model, 0.3, 201, 8);
    const auto why_no_error = [&](const std::vector<std::string>& keys, const physics::Model& start) {
        return refusal_of(
            [&] { (void)fit_waves(rod_bead_waves(start, rest_of(start), fitted(keys)), record, NoiseOf::model); });
    };
    EXPECT_EQ(why_no_error({"relaxation.rate", "relaxation.contact"}, model),
              "the waves determine only a combination of relaxation.rate and relaxation.contact; expected numbers that "
              "change them differently: leave one of these out, and give its value to the scene");
    EXPECT_EQ(why_no_error({"advection.strength"}, model),
              "the waves do not depend on advection.strength; expected numbers that change them: leave it out");
    physics::Model quiet = model;
    quiet.noise = {};
    EXPECT_EQ(why_no_error({"relaxation.rate"}, quiet),
              "the scene has no noise that reaches every field of the wave at q = (0, 0); expected noise of each "
              "field, or of one that drives it: such as noise.order, and driving.strength for the beads");
    EXPECT_EQ(refusal_of([&] {
                  (void)fit_waves(rod_bead_waves(model, rest_of(model), fitted({"relaxation.rate"})),
                                  thinned(record, 8), NoiseOf::model);
              }),
              "26 frames; expected at least 65: record more frames");
}

}  // namespace
}  // namespace drover::calibrate::wave_fit_tests
