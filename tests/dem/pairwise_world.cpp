// tests/dem/pairwise_world.cpp: the step of the pairwise law: balances, symmetry, restarts, and a program of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "bench/particles/plain_rod.hpp"
#include "dem/contact/contact_law.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::pairwise_world_tests {
namespace {

/// The paper's plates, rods and contacts about a periodic square.
dem::Setup printed(double side) {
    dem::Setup setup = square(side);
    setup.contacts.law = GroupLaw::pairwise;
    setup.rods.bearing = Bearing::all;
    return setup;
}

Bodies one_rod(const dem::Setup& setup, const Rod& rod) {
    return {.shapes = {rod_shape(setup)}, .beads = {}, .rods = {rod}};
}

/// A rod between the plates with a random direction, height and tilt.
Rod random_rod(const dem::Setup& setup, Drawn& drawn) {
    Rod rod = lying_rod(setup, 0.0, 0.0, std::numbers::pi * drawn());
    const double tilt = 0.02 * drawn();
    rod.axis = {rod.axis.x * std::sqrt(1.0 - tilt * tilt), rod.axis.y * std::sqrt(1.0 - tilt * tilt), tilt};
    rod.position.z += 0.015 * drawn();
    return rod;
}

TEST(PairwiseWorld, the_energy_balance_closes_in_a_shaken_mixture_with_every_order_and_friction) {
    Threads threads(2);
    for (const ContactOrder order : {ContactOrder::tail_first, ContactOrder::random, ContactOrder::fastest_first})
        for (const PairwiseFriction friction : {PairwiseFriction::stop_or_slide, PairwiseFriction::decoupled}) {
            dem::Setup setup = printed(12.0);
            setup.contacts.order = order;
            setup.contacts.friction = friction;
            setup.beads.count = 1;  // the bodies are given below
            setup.forces = {.bead_x = 50.0, .rod_y = 300.0, .torque = 2e4, .angle = 0.4, .hold_beads = true};
            setup.gravity.x = 300.0;
            Drawn drawn(2);
            World world(setup, mixture(setup, drawn), 1e-5, 1, threads);
            const double before = world.energy_kinetic();
            run(world, 0, 6000);
            const EnergyBalance balance = world.balance();
            EXPECT_NEAR(world.energy_kinetic() - before, sum(balance), 1e-9 * balance.plates)
                << name_of(order) << name_of(friction);
            EXPECT_LT(balance.impact, 0.0);
            EXPECT_LT(balance.friction, 0.0);
            EXPECT_NE(balance.kicks, 0.0);
            EXPECT_GT(world.counts().rod_plate, 10);
            EXPECT_GT(world.counts().bead_plate, 10);
            EXPECT_GT(world.counts().bead_bead, 10);
            EXPECT_GT(world.counts().rod_bead, 10);
            EXPECT_EQ(world.counts().groups + world.counts().limited, 0);
            // Overlaps stay, and remain far below contacts.max_overlap.
            EXPECT_GT(world.worst_overlap().of_radius, 0.0);
            EXPECT_LT(world.worst_overlap().of_radius, 0.01);
        }
}

TEST(PairwiseWorld, the_energy_balance_closes_at_extremes_and_counts_limited_friction) {
    Threads threads;
    std::int64_t limited = 0;
    for (const double e : {0.0, 1.0})
        for (const double mu : {0.0, 10.0}) {
            dem::Setup setup = printed(12.0);
            setup.restitution = {e, e, e, 0.3, e, e, e};
            setup.friction = {mu, mu, mu, mu, mu, mu, mu};
            setup.contacts.max_overlap = 0.2;  // without rebound, bodies at rest sink into a plate by g dt^2 a step
            Drawn drawn(5);
            World world(setup, mixture(setup, drawn), 1e-5, 1, threads);
            const double before = world.energy_kinetic();
            run(world, 0, 3000);
            const EnergyBalance balance = world.balance();
            const double scale = std::abs(balance.plates) + std::abs(balance.gravity) - balance.impact;
            EXPECT_NEAR(world.energy_kinetic() - before, sum(balance), 1e-9 * scale) << e << " " << mu;
            EXPECT_LT(balance.impact + balance.friction, 1e-9 * scale);  // no contact creates energy
            limited += world.counts().limited;
        }
    EXPECT_GT(limited, 0);
}

TEST(PairwiseWorld, a_frictionless_elastic_gas_conserves_energy_and_momentum) {
    Threads threads(2);
    Drawn drawn(1);
    dem::Setup setup = elastic(16.0);
    setup.contacts.law = GroupLaw::pairwise;
    const Bodies bodies = lattice(setup, 16, 16, 0.8, 40.0, drawn);
    World world(setup, bodies, 1e-5, 1, threads);
    const auto momentum = [&] {
        Vector total;
        for (const Bead& bead : world.bodies().beads) total = total + bodies.shapes[0].mass * bead.velocity;
        return total;
    };
    const double before = world.energy_kinetic();
    const Vector start = momentum();
    run(world, 0, 20000);
    EXPECT_GT(world.counts().bead_bead, 1000);
    EXPECT_NEAR(world.energy_kinetic() / before, 1.0, 1e-11);  // 1e4 roundings of 1e-16 walk to 1e-14
    const Vector change = momentum() - start;
    EXPECT_LT(std::hypot(change.x, change.y), 1e-11 * 256 * 0.7 * 40.0);
}

TEST(PairwiseWorld, is_bitwise_equal_for_any_number_of_threads_and_after_a_restart) {
    dem::Setup setup = printed(14.0);
    setup.contacts.order = ContactOrder::random;  // its numbers are counted, too
    Threads one(1), three(3);
    const auto make = [&](Threads& threads) {
        Drawn drawn(4);
        return World(setup, mixture(setup, drawn), 1e-5, 7, threads);
    };
    World a = make(one), b = make(three), c = make(three);
    run(a, 0, 3000);
    run(b, 0, 1111);
    c.restore(b.save());
    run(b, 1111, 3000);
    run(c, 1111, 3000);
    const auto same = [](const World& x, const World& y) {
        const std::vector<double> p = x.save(), q = y.save();
        return p.size() == q.size() && std::equal(p.begin(), p.end(), q.begin(), [](double s, double t) {
                   return std::bit_cast<std::uint64_t>(s) == std::bit_cast<std::uint64_t>(t);
               });
    };
    EXPECT_TRUE(same(a, b));
    EXPECT_TRUE(same(a, c));
}

TEST(PairwiseWorld, mirrored_and_rotated_scenes_have_mirrored_and_rotated_trajectories) {
    Threads threads;
    dem::Setup setup = printed(20.0);
    setup.kick.strength = 0.0;
    const auto flown = [&](int quarters, bool mirrored) {
        const auto turn = [&](Vector v, bool axial) {
            if (mirrored) v = axial ? Vector{-v.x, v.y, -v.z} : Vector{v.x, -v.y, v.z};
            for (int k = 0; k < quarters; ++k) v = {-v.y, v.x, v.z};
            return v;
        };
        Rod rod = lying_rod(setup, 1.0, 2.0, 0.3);
        rod.position = turn(rod.position, false);
        rod.axis = turn(rod.axis, false);
        rod.velocity = turn({2.0, 3.0, -10.0}, false);
        rod.angular_momentum = turn({1.0, 20.0, 5.0}, true);
        World world(setup, one_rod(setup, rod), 1e-5, 1, threads);
        run(world, 0, 4000);
        return world.bodies().rods.front();
    };
    // Rounding, multiplied by some hundred impacts.
    const Rod plain = flown(0, false), quarter = flown(1, false), mirror = flown(0, true);
    EXPECT_LT(length(quarter.position - Vector{-plain.position.y, plain.position.x, plain.position.z}), 1e-8);
    EXPECT_LT(length(mirror.position - Vector{plain.position.x, -plain.position.y, plain.position.z}), 1e-8);
    EXPECT_LT(length(mirror.axis - Vector{plain.axis.x, -plain.axis.y, plain.axis.z}), 1e-8);
    EXPECT_GT(length(plain.position - Vector{1.0, 2.0, plain.position.z}), 0.1);  // it did move
}

TEST(PairwiseWorld, a_rod_collides_with_its_own_image_and_the_balance_closes) {
    Threads threads;
    dem::Setup setup = printed(4.6);
    setup.cell.ly = 3.0;
    Rod rod = lying_rod(setup, 0.0, 0.0, 0.0);
    rod.angular_momentum = {0.0, 0.0, 2000.0};
    World world(setup, one_rod(setup, rod), 1e-5, 1, threads);
    const double before = world.energy_kinetic();
    run(world, 0, 20000);
    EXPECT_GT(world.counts().rod_rod, 0);
    EXPECT_NEAR(world.energy_kinetic() - before, sum(world.balance()), 1e-9 * world.balance().plates);
}

constexpr double frame = 0.025, warm_up = 0.25, seconds = 0.75;
constexpr int starts = 8;

/// Mean speeds of rods along their axes over 0.5 s after 0.25 s, of as many starts.
std::vector<double> speeds_of_world(dem::Setup setup, double step) {
    Threads threads;
    setup.contacts.rod_step = step;
    std::vector<double> speeds;
    Drawn drawn(9);
    for (std::uint64_t seed = 0; seed < starts; ++seed) {
        World world(setup, one_rod(setup, random_rod(setup, drawn)), 1e-5, seed, threads);
        const auto at = [&] {
            const Rod rod = world.bodies().rods.front();
            return plain::Frame{rod.position.x, rod.position.y, rod.axis.x, rod.axis.y};
        };
        std::vector<plain::Frame> frames{at()};
        for (std::int64_t f = 0; f < std::llround(seconds / frame); ++f) {
            run(world, f * 2500, (f + 1) * 2500);
            frames.push_back(at());
        }
        speeds.push_back(plain::speed(frames, frame, warm_up));
    }
    return speeds;
}

std::vector<double> speeds_of_plain(const plain::Choice& choice) {
    std::vector<double> speeds;
    for (std::uint64_t seed = 0; seed < starts; ++seed)
        speeds.push_back(plain::speed(plain::run(choice, seed, seconds, frame), frame, warm_up));
    return speeds;
}

/// The same mean within four standard errors.
void expect_same_mean(const std::vector<double>& some, const std::vector<double>& others) {
    const auto mean_and_error = [](const std::vector<double>& values) {
        double sum = 0.0, squares = 0.0;
        for (const double v : values) {
            sum += v;
            squares += v * v;
        }
        const auto count = static_cast<double>(values.size());
        return std::array{sum / count,
                          std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)) / (count - 1.0))};
    };
    const auto [mean, error] = mean_and_error(some);
    const auto [expected, expected_error] = mean_and_error(others);
    EXPECT_NEAR(mean, expected, 4.0 * std::hypot(error, expected_error));
}

TEST(PairwiseWorldLong, a_rod_goes_as_fast_as_in_a_plain_program_of_its_own) {
    dem::Setup setup = printed(1000.0);
    for (const double step : {1e-5, 5e-6, 2e-6})
        expect_same_mean(speeds_of_world(setup, step), speeds_of_plain({.step = step}));
    for (const ContactOrder order : {ContactOrder::random, ContactOrder::fastest_first}) {
        setup.contacts.order = order;
        expect_same_mean(speeds_of_world(setup, 5e-6), speeds_of_plain({.step = 5e-6, .order = name_of(order)}));
    }
    setup.contacts.order = ContactOrder::tail_first;
    setup.contacts.friction = PairwiseFriction::decoupled;
    expect_same_mean(speeds_of_world(setup, 5e-6), speeds_of_plain({.step = 5e-6, .decoupled = true}));
}

TEST(PairwiseWorldLong, a_rod_that_bears_on_all_spheres_has_one_gait_and_one_that_bears_on_its_hull_has_others) {
    dem::Setup setup = printed(1000.0);
    for (const double speed : speeds_of_world(setup, 2e-6)) EXPECT_NEAR(speed, 6.0, 1.0);  // starts included
    // Its gaits differ from each other by 6 mm/s, and within each by less than 0.1; some rods change over on the way.
    setup.rods.bearing = Bearing::hull;
    const auto outside = [](const std::vector<double>& speeds) {
        return std::count_if(speeds.begin(), speeds.end(),
                             [](double v) { return std::abs(v - 8.95) < 0.5 || std::abs(v - 3.0) < 0.5; });
    };
    EXPECT_GE(outside(speeds_of_world(setup, 5e-6)), starts - 2);
    EXPECT_GE(outside(speeds_of_plain({.step = 5e-6, .hull = true})), starts - 2);
}

TEST(PairwiseWorld, the_steps_of_rods_do_not_depend_on_the_time_step_of_beads) {
    Threads threads;
    dem::Setup setup = printed(100.0);
    setup.contacts.rod_step = 5e-6;
    Drawn drawn(3);
    const Rod rod = random_rod(setup, drawn);
    World coarse(setup, one_rod(setup, rod), 2e-5, 1, threads), fine(setup, one_rod(setup, rod), 5e-6, 1, threads);
    run(coarse, 0, 500);
    run(fine, 0, 2000);
    // The height of the plates is a series about the start of the time step: its rounding, multiplied by impacts.
    EXPECT_LT(length(coarse.bodies().rods[0].position - fine.bodies().rods[0].position), 1e-7);
}

TEST(PairwiseWorld, a_plate_that_goes_too_deep_into_a_rod_fails_with_the_step_to_choose) {
    Threads threads;
    dem::Setup setup = printed(100.0);
    setup.contacts.rod_step = 2e-4;
    setup.contacts.max_overlap = 0.001;
    World world(setup, one_rod(setup, lying_rod(setup, 0.0, 0.0, 0.0)), 2e-4, 1, threads);
    try {
        run(world, 0, 2000);
        FAIL() << "expected an error";
    } catch (const Error& error) {
        const std::string words = error.what();
        for (const char* part : {"rod 0", "overlap by", "contacts.rod_step <= "})
            EXPECT_NE(words.find(part), std::string::npos) << words;
    }
}

TEST(PairwiseWorld, a_bead_at_rest_sinks_into_the_base_whatever_its_restitution) {
    Threads threads;
    constexpr double dt = 1e-4;
    constexpr std::int64_t steps = 60;
    for (const double e : {0.0, 0.5, 0.9}) {
        dem::Setup setup = printed(10.0);
        setup.plates.amplitude = 0.0;
        setup.restitution.bead_plate = e;
        const Bodies bodies{.shapes = {make_ball(0.8, 2.7)}, .beads = {{.position = {0.0, 0.0, 0.4}}}, .rods = {}};
        World world(setup, bodies, dt, 1, threads);
        run(world, 0, steps);
        // A step changes v into -e (v - g dt), which tends to e g dt/(1 + e) as (-e)^n, and the bead moves by v - g dt.
        const double g = -setup.gravity.z;
        double depth = 0.0, v = 0.0;
        for (std::int64_t n = 0; n < steps; ++n) {
            depth += g * dt * dt - v * dt;
            v = e * (g * dt - v);
        }
        EXPECT_NEAR(0.4 - world.bodies().beads[0].position.z, depth, 1.5 * g * dt * dt) << e;  // half a step and one
        EXPECT_NEAR(depth, g * dt * dt / (1.0 + e) * steps, 0.05 * depth) << e;
        try {
            run(world, steps, 1000);
            FAIL() << "expected an error";
        } catch (const Error& error) {
            const std::string words = error.what();
            for (const char* part : {"bead 0 and the base", "does not correct overlaps", "smaller time.dt"})
                EXPECT_NE(words.find(part), std::string::npos) << words;
        }
    }
}

TEST(PairwiseWorld, a_time_step_too_long_for_the_vibration_is_rejected) {
    Threads threads;
    const dem::Setup setup = printed(100.0);
    EXPECT_THROW(World(setup, one_rod(setup, lying_rod(setup, 0.0, 0.0, 0.0)), 3e-4, 1, threads), Error);
}

}  // namespace
}  // namespace drover::dem::pairwise_world_tests
