// tests/dem/impact_slip.cpp: the impact of a single contact whose slip turns, against an independent integration.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "dem/impact_support.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::impact_slip_tests {
namespace {

/// The impact of one contact by Keller's equations in many equal increments of the normal impulse, by Heun's method: an
/// independent integration.  w: changes of the relative velocity (x, y, normal) by unit impulses.  Returns the relative
/// velocity after.
Vector keller_impact(const std::array<Vector, 3>& w, Vector u, double e, double mu, int parts) {
    const double dp = -u.z / w[2].z / parts;
    double work = 0.0, target = 0.0;
    bool pressing = true;
    const double det = w[0].x * w[1].y - w[0].y * w[0].y;
    const Vector hold{-(w[1].y * w[2].x - w[0].y * w[2].y) / det, -(w[0].x * w[2].y - w[0].y * w[2].x) / det, 0.0};
    const auto rate = [&](const Vector& at) {
        const double slip = std::hypot(at.x, at.y);
        return slip > 0.0 ? w[2] - (mu / slip) * (at.x * w[0] + at.y * w[1]) : w[2];
    };
    for (int part = 0; part < 200 * parts; ++part) {
        const double most = dp * (std::hypot(w[2].x, w[2].y) + mu * (w[0].x + w[1].y));
        Vector change;
        if (std::hypot(u.x, u.y) <= most && std::hypot(hold.x, hold.y) <= mu) {
            u.x = u.y = 0.0;  // sticks
            change = dp * (w[2] + hold.x * w[0] + hold.y * w[1]);
        } else {
            const Vector first = rate(u);
            change = (0.5 * dp) * (first + rate(u + dp * first));
        }
        const Vector next = u + change;
        const double done = 0.5 * dp * (u.z + next.z);
        if (pressing && next.z >= 0.0) {
            pressing = false;
            target = -e * e * work;
            work = 0.0;
        } else {
            work += done;
        }
        if (!pressing && work >= target) return next;
        u = next;
    }
    return u;
}

TEST(Impact, of_a_tilted_rod_and_a_plate_is_right_to_a_thousandth_of_its_approach_in_few_increments) {
    Drawn drawn(21);
    std::vector<double> errors, increments;
    for (int trial = 0; trial < 1500; ++trial) {
        const double tilt = 0.25 * drawn();  // beyond what the gap between the plates allows
        ImpactBody rod = impact_body(the_rod, {std::cos(tilt), 0.0, std::sin(tilt)});
        rod.velocity = drawn.vector(20.0) - Vector{0.0, 0.0, 25.0};
        rod.spin = drawn.vector(10.0);
        const double mu = std::array{0.01, 0.03, 0.1, 0.3, 1.0}[static_cast<std::size_t>(trial % 5)];
        const double e = std::array{0.0, 0.1, 0.5, 1.0}[static_cast<std::size_t>(trial % 4)];
        Contact contact = on_plate(rod, tilt > 0.0 ? 0 : 12, e, mu);
        const Vector before = relative_velocity(contact, {&rod, 1});
        if (before.z > -1.0) continue;
        std::array<Vector, 3> w;
        for (const std::size_t i : {0, 1, 2}) {
            const Vector impulse{i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0};
            const Vector turn = cross(contact.arm_first, impulse);
            const Vector spin =
                rod.across_inverse * turn + ((rod.along_inverse - rod.across_inverse) * dot(turn, rod.axis)) * rod.axis;
            w[i] = rod.mass_inverse * impulse + cross(spin, contact.arm_first);
        }
        const Vector expected = keller_impact(w, before, e, mu, 20000);
        const ImpactOutcome outcome = resolve({&rod, 1}, {&contact, 1}, {});
        errors.push_back(length(relative_velocity(contact, {&rod, 1}) - expected) / -before.z);
        increments.push_back(outcome.increments);
    }
    std::sort(errors.begin(), errors.end());
    // Ten increments or so count, each with an error of a third of 1e-4 or less; where the slip ends, all of 1e-4.  The
    // expected values have 1e-4.
    EXPECT_LT(errors.back(), 1e-3);
    EXPECT_LT(errors[errors.size() / 2], 1e-4);
    // Eight equal increments and the ends of the phases take some 20.
    EXPECT_LT(std::accumulate(increments.begin(), increments.end(), 0.0) / static_cast<double>(increments.size()),
              50.0);
}

}  // namespace
}  // namespace drover::dem::impact_slip_tests
