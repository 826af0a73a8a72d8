// dem/bodies/plate_motion.hpp: height and velocity of base and lid at any time, and when a gap closes.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/dem/setup.hpp"

namespace drover::dem {

struct PlateState {
    double height = 0.0, velocity = 0.0, acceleration = 0.0;  ///< [mm], [mm/s], [mm/s^2]
};

/// Motion of the plates about one moment: base(tau) is the base a time tau after it.
class PlateMotion {
public:
    explicit PlateMotion(const Plates& plates, double time = 0.0)
        : plates_(plates), rate_(2.0 * std::numbers::pi * plates.frequency) {
        set_time(time);
    }
    void set_time(double time) {
        // The phase is reduced first: late in a run it would lose digits.
        const double turns = plates_.frequency * time, phase = 2.0 * std::numbers::pi * (turns - std::floor(turns));
        cosine_ = std::cos(phase);
        sine_ = std::sin(phase);
    }
    /// For tau within one step.  The series of sine and cosine are enough: for A = 1 mm, f = 200 1/s and tau = 1e-4 s
    /// the error is below 1e-10 mm.
    PlateState base(double tau = 0.0) const {
        const double angle = rate_ * tau, square = angle * angle;
        const double c = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square / 720.0));
        const double s = angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0)));
        const double cosine = cosine_ * c - sine_ * s, sine = sine_ * c + cosine_ * s;
        return {.height = plates_.amplitude * (1.0 + cosine),
                .velocity = -plates_.amplitude * rate_ * sine,
                .acceleration = -plates_.amplitude * rate_ * rate_ * cosine};
    }
    double gap() const { return plates_.gap; }
    bool lid() const { return plates_.lid; }

private:
    Plates plates_;
    double rate_ = 0.0, cosine_ = 1.0, sine_ = 0.0;
};

inline constexpr double never = 1e300;

/// First t >= 0 at which the gap g + v t + a t^2/2 closes: 0 if it is closed and closing, `never` if it stays open.
inline double closing_time(double g, double v, double a) {
    if (g <= 0.0 && v < 0.0) return 0.0;
    const double d = v * v - 2.0 * g * a;
    if (a < 0.0) return d > 0.0 ? std::max(0.0, (v + std::sqrt(d)) / -a) : v / -a;
    if (v >= 0.0 || d < 0.0) return never;
    return 2.0 * g / (-v + std::sqrt(d));
}

}  // namespace drover::dem
