// tests/calibrate/scattering.cpp: the kernel of collisions of two rods against that of a rule known in closed form.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <numbers>

#include "calibrate/catalogue.hpp"
#include "calibrate/collision_rule.hpp"
#include "drover/base/random.hpp"

namespace drover::calibrate::scattering_tests {
namespace {
using std::numbers::pi;

/// The rule, with noise between encounters and a square periodic cell.
struct World : CollisionRule {
    double diffusion = 0.5, side = 26.0;
};
constexpr World turning{{.kept = 0.6, .reach = 2.0, .speed = 12.0}};

class Collisions : public ParticleSystem {
public:
    Collisions(const World& rule, std::uint64_t seed) : rule_(rule), key_{.seed = seed, .stream = Stream::test} {
        std::array<double, 6> drawn{};
        fill_uniform(key_, 0, 1, drawn);
        for (std::size_t r = 0; r < 2; ++r)
            rods_.push_back({.x = rule.side * drawn[3 * r],
                             .y = rule.side * drawn[3 * r + 1],
                             .angle = 2.0 * pi * drawn[3 * r + 2]});
        has_met_ = distance() < 2.0 * rule.reach;
    }
    void impose(const dem::BodyForces&) override {}
    void advance_to(double time) override {
        constexpr double step = 0.01;
        for (; time_ < time - 0.5 * step; time_ += step) advance(step);
    }
    std::vector<RodPose> rods() const override { return rods_; }
    BeadMotion beads() const override { return {}; }
    std::vector<Position> bead_positions() const override { return {}; }
    double shear_wave(int) const override { return 0.0; }
    double density_wave(int) const override { return 0.0; }

private:
    double distance() const {
        return std::hypot(std::remainder(rods_[1].x - rods_[0].x, rule_.side),
                          std::remainder(rods_[1].y - rods_[0].y, rule_.side));
    }
    void advance(double step) {
        std::array<double, 2> noise{};
        RandomKey key = key_;
        key.substep = 1;
        fill_normal(key, next_++, 1, noise);
        for (std::size_t r = 0; r < 2; ++r) {
            RodPose& rod = rods_[r];
            rod.angle += std::sqrt(2.0 * rule_.diffusion * step) * noise[r];
            rod.x += rule_.speed * step * std::cos(rod.angle);
            rod.y += rule_.speed * step * std::sin(rod.angle);
        }
        const double apart = distance();
        if (apart > 2.0 * rule_.reach) has_met_ = false;
        if (apart > rule_.reach || has_met_) return;
        has_met_ = true;
        const double turn = 0.5 * (1.0 - rule_.kept) * std::remainder(rods_[1].angle - rods_[0].angle, 2.0 * pi);
        rods_[0].angle += turn;
        rods_[1].angle -= turn;
    }

    World rule_;
    RandomKey key_;
    std::vector<RodPose> rods_;
    double time_ = 0.0;
    std::uint64_t next_ = 1;
    bool has_met_ = false;
};

Measurement measured(const World& rule, std::uint64_t seed, std::size_t trials) {
    const Assay assay = scattering({.cell = rule.side,
                                    .range = 2.0 * rule.reach,
                                    .max_duration = 0.6,
                                    .warm_up = 0.0,
                                    .time = 12.0,
                                    .frame = 0.02});
    Conditions conditions{.setup = {}, .seed = seed};
    conditions.setup.rods.count = 2;
    conditions.setup.rods.length = rule.reach;
    const SystemFactory make = [rule](const dem::Setup&, std::uint64_t one) {
        return std::make_unique<Collisions>(rule, one);
    };
    return carry_out(assay, make, conditions,
                     {.relative_error = 1e-9, .round = trials, .min_rounds = 1, .max_trials = trials});
}

struct Expected {
    std::size_t place;
    double value;
};
std::vector<Expected> expected(const CollisionRule& rule) {
    return {{0, kernel(rule, 1, 0) + kernel(rule, 1, 1)},
            {1, kernel(rule, 2, 0) + kernel(rule, 2, 2)},
            {2, kernel(rule, 2, 1)},
            {3, -kernel(rule, 1, 2) - kernel(rule, 1, -1)}};
}

// Noise turns a rod by 0.5 within an encounter of 0.3 s, by more than the other rod does: without its correction c
// would have the wrong sign.  What is left of it is small against the statistical errors of 10 %.
TEST(Scattering, of_points_that_turn_to_each_other_has_the_known_kernel) {
    const World rule = turning;
    const Measurement found = measured(rule, 3, 1200);
    for (const auto& [place, value] : expected(rule)) {
        ASSERT_TRUE(found.estimates[place].error) << found.estimates[place].why_no_error;
        EXPECT_NEAR(found.estimates[place].mean, value, 3.0 * *found.estimates[place].error) << place;
        EXPECT_LT(*found.estimates[place].error, 0.15 * std::abs(value)) << place;
    }
    const double rate = 4.0 * rule.reach * 4.0 * rule.speed / pi;  // mean of v over angles is 4 u/pi
    EXPECT_NEAR(found.estimates[4].mean, rate, 3.0 * *found.estimates[4].error);
    EXPECT_NEAR(found.estimates[6].mean, rule.diffusion, 3.0 * *found.estimates[6].error);
}

TEST(Scattering, of_points_that_do_not_meet_has_no_kernel) {
    const Measurement found = measured({{.kept = 1.0, .reach = 2.0, .speed = 12.0}}, 5, 1200);
    for (std::size_t place = 0; place < 4; ++place)
        EXPECT_NEAR(found.estimates[place].mean, 0.0, 3.0 * *found.estimates[place].error) << place;
}

TEST(Scattering, refuses_encounters_that_begin_in_contact_and_cells_where_a_rod_meets_two_images) {
    const World rule{{.kept = 0.6, .reach = 1.0, .speed = 12.0}};
    Conditions conditions{.setup = {}, .seed = 1};
    conditions.setup.rods.count = 2;  // of 4.5 mm
    const SystemFactory make = [rule](const dem::Setup&, std::uint64_t one) {
        return std::make_unique<Collisions>(rule, one);
    };
    // The head is 2.5584 mm from the centre of mass, so that two heads touch at 5.117 mm, further than the length.
    EXPECT_THROW((void)run_trial(scattering({.range = 5.11}), make, conditions, 0), Error);
    EXPECT_NO_THROW((void)run_trial(scattering({.range = 5.12}), make, conditions, 0));
    conditions.setup.rods.size_tolerance = 0.01;
    EXPECT_THROW((void)run_trial(scattering({.range = 5.12}), make, conditions, 0), Error);
    conditions.setup.rods.diameters = {1.1};  // a ball, of which the length is not read
    EXPECT_NO_THROW((void)run_trial(scattering({.range = 2.0}), make, conditions, 0));
    EXPECT_THROW((void)scattering({.cell = 10.0, .range = 5.0}), Error);
    EXPECT_THROW((void)scattering({.max_duration = 0.1, .frame = 0.1}), Error);
}

TEST(ScatteringStatistics, has_errors_that_cover_the_true_value_in_68_percent_of_repeats) {
    const World rule = turning;
    const std::vector<Expected> truths = expected(rule);
    std::vector<int> covered(truths.size());
    constexpr int repeats = 200;
    for (int i = 0; i < repeats; ++i) {
        const Measurement found = measured(rule, 100 + static_cast<std::uint64_t>(i), 60);
        for (std::size_t t = 0; t < truths.size(); ++t) {
            const measure::Estimate& one = found.estimates[truths[t].place];
            covered[t] += one.error && std::abs(one.mean - truths[t].value) <= *one.error;
        }
    }
    // 3 standard deviations of the binomial distribution.
    for (const int count : covered) EXPECT_NEAR(count, 0.683 * repeats, 3.0 * std::sqrt(0.683 * 0.317 * repeats));
}

}  // namespace
}  // namespace drover::calibrate::scattering_tests
