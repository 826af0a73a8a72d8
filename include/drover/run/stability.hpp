// run/stability.hpp: what drover stability finds of a scene: its uniform states, their coefficients, modes, instabilities, fluctuations.
#pragma once
#include <string>
#include <vector>

#include "drover/files/archive.hpp"
#include "drover/io/scene.hpp"
#include "drover/physics/fluctuations.hpp"
#include "drover/physics/long_waves.hpp"
#include "drover/physics/stability.hpp"

namespace drover::run {

/// Slow modes at one angle to p0.
struct SlowAngle {
    double angle = 0.0;  ///< [rad]
    std::vector<physics::SlowMode> modes;
};

struct StateStability {
    physics::StationaryState state;
    std::vector<physics::Instability> instabilities;  ///< empty: stable against all waves searched
    physics::LongWaves waves;
    std::vector<SlowAngle> slow;       ///< at 0, 30, 60 and 90 degrees; empty where waves.undefined says why
    double direction_diffusion = 0.0;  ///< of the mean order, D area [rad^2 mm^2/s]
};

struct StabilityReport {
    io::Scene scene;
    std::string form;
    physics::EffectiveCoefficients coefficients;
    std::vector<StateStability> states;
    std::string no_order;            ///< why there is no ordered state; empty when there is one
    physics::Search search;          ///< the waves looked at
    std::vector<std::string> notes;  ///< what a reader must know
};

/// Throws an input Error for a search without room.
StabilityReport make_stability(const io::Scene& scene);

/// For people.
std::string stability_text(const StabilityReport& report);

/// One group for each state, named after it ("along_the_field"): branches over angle and wavenumber (growth_rate, frequency, shapes), slow
/// modes by angle, structure factors (not-a-number where a mode grows) and the dynamic structure factors at stability.sound.
std::vector<files::ResultTable> stability_tables(const StabilityReport& report, Threads& threads);

}  // namespace drover::run
