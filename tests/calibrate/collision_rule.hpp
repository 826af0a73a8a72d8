// tests/calibrate/collision_rule.hpp: an encounter of two rods whose kernel of collisions is known in closed form.
#pragma once

#include <cmath>
#include <numbers>

namespace drover::calibrate {

/// Two points that run straight at `speed` and come closer than `reach` keep this part of the angle between them.
struct CollisionRule {
    double kept, reach, speed;
};

/// J_kq of the rule by the midpoint rule: points meet at the rate 2 reach v/A, v = 2 speed sin(angle/2).
inline double kernel(const CollisionRule& rule, int k, int q) {
    constexpr int points = 4000;
    double sum = 0.0;
    for (int i = 0; i < points; ++i) {
        const double angle = (i + 0.5) / points * std::numbers::pi;  // z_1 = 1, z_2 = exp(i angle)
        const auto wave = [&](double phase) { return std::cos(k * phase + (q - k) * angle); };
        sum +=
            2.0 * rule.reach * rule.speed * std::sin(0.5 * angle) *
            (wave(0.5 * (1.0 - rule.kept) * angle) + wave(0.5 * (1.0 + rule.kept) * angle) - wave(0.0) - wave(angle)) /
            points;
    }
    return sum;
}

}  // namespace drover::calibrate
