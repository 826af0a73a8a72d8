// tests/calibrate/rod_bead_waves.hpp: waves of rods and beads for fits, by their forces.
#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "calibrate/wave_fit.hpp"
#include "physics/uniform_points.hpp"

namespace drover::calibrate {

/// A number of rods and beads.
struct RodBeadNumber {
    std::string key;
    std::function<double&(physics::ModelValues&)> in;
    double min = -std::numeric_limits<double>::infinity();
};

/// The fields of a record are those with a rate, in the order of the model file.
inline WaveModel rod_bead_waves(const physics::ModelValues& start, const physics::UniformPoint& about,
                                const std::vector<RodBeadNumber>& numbers) {
    const physics::Equations of_start(start);
    WaveModel waves;
    const auto at_start = physics::linearised(of_start, about);
    for (const int component : at_start->state_components()) {
        const bool beads = component == of_start.component("rho"), rods = component == of_start.component("sigma");
        waves.fields.push_back({.is_conserved = beads || rods, .size = beads ? about.bead_density : about.rod_density});
    }
    physics::ModelValues model = start;
    for (const RodBeadNumber& number : numbers)
        waves.numbers.push_back({.key = number.key, .start = number.in(model), .min = number.min});
    waves.at = [=](const std::vector<double>& values) {
        physics::ModelValues changed = start;
        for (std::size_t i = 0; i < values.size(); ++i) numbers[i].in(changed) = values[i];
        const auto linear = physics::linearised(physics::Equations(changed), about);
        return LinearWaves{.symbol = [linear](const numerics::Wavevector& q) { return linear->symbol(q); },
                           .noise = [linear](const numerics::Wavevector& q) { return linear->noise(q); }};
    };
    return waves;
}

}  // namespace drover::calibrate
