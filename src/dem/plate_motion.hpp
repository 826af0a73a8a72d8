// dem/plate_motion.hpp: where base and lid are within a step, and when a point that moves between them meets one.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/dem/setup.hpp"

namespace drover::dem {

/// A cubic in time is enough: over a step of 1e-4 s the fifth order of a plate of 1 mm at 200 1/s is 1e-10 mm.
struct Flight {
    double at = 0.0, speed = 0.0, push = 0.0;  ///< place [mm], velocity [mm/s], acceleration [mm/s^2] at a moment
};

/// The plates about one moment: base(tau) with tau from there.
class PlateMotion {
public:
    explicit PlateMotion(const Plates& plates) : plates_(plates), rate_(2.0 * std::numbers::pi * plates.frequency) {}
    void set_time(double time) {
        // The phase is reduced first: late in a run it would lose digits.
        const double turns = plates_.frequency * time, phase = 2.0 * std::numbers::pi * (turns - std::floor(turns));
        cosine_ = std::cos(phase);
        sine_ = std::sin(phase);
    }
    Flight base(double tau) const {
        const double angle = rate_ * tau, square = angle * angle;
        const double c = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square / 720.0));
        const double s = angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0)));
        const double cosine = cosine_ * c - sine_ * s, sine = sine_ * c + cosine_ * s;
        return {.at = plates_.amplitude * (1.0 + cosine),
                .speed = -plates_.amplitude * rate_ * sine,
                .push = -plates_.amplitude * rate_ * rate_ * cosine};
    }
    double gap() const { return plates_.gap; }
    bool lid() const { return plates_.lid; }

private:
    Plates plates_;
    double rate_ = 0.0, cosine_ = 1.0, sine_ = 0.0;
};

/// When a gap g + v t + a t^2/2 closes, from t = 0 on: 0 for one that is closed and closing; `never` for one that stays open.
inline constexpr double never = 1e300;
inline double closing_time(double g, double v, double a) {
    if (g <= 0.0 && v < 0.0) return 0.0;
    const double d = v * v - 2.0 * g * a;
    if (a < 0.0) return d > 0.0 ? std::max(0.0, (v + std::sqrt(d)) / -a) : v / -a;
    if (v >= 0.0 || d < 0.0) return never;
    return 2.0 * g / (-v + std::sqrt(d));
}

}  // namespace drover::dem
