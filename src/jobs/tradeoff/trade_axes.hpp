// jobs/tradeoff/trade_axes.hpp: the ways in which a scene is made cheaper or more accurate.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/scene.hpp"

namespace drover::jobs {

/// One change of a scene.
struct AxisLevel {
    std::string name;  ///< "dt = 0.5 s", "96 by 96", "without advection.strength"
    std::vector<std::string> overrides;
    std::optional<std::string> reason = {};  ///< why the scene cannot be changed so
    double sample_every = 0.0;               ///< where it must be longer than that of the scene [s]
    std::string name_of_row = {};            ///< of a grid: its name for models with one row
    bool has_one_row = false;                ///< of a model, on every grid
    bool saves_no_time = false;              ///< it is there to tell its error: a lower time is scatter
};

/// A method of time stepping (or, of particles, the step alone) with ever shorter steps.
struct StepLadder {
    std::string method;
    std::vector<AxisLevel>
        levels;            ///< coarsest first; each has half the step, or a tenth of the tolerance, of the one before
    double order = 2.0;    ///< of the bias of means; with noise 2, or 1 where it multiplies fields
    double shorter = 2.0;  ///< ratio of the steps of two levels
};

/// The override that gives a key a number.
std::string set(const std::string& key, double value);
std::string set(const std::string& key, int value);

/// Why a scene does not allow changes; nothing when it does.
std::optional<std::string> reason_against(const io::Scene& scene, const std::vector<std::string>& overrides);

/// The level without a change.
bool is_given(const AxisLevel& level);

/// Ladders of the methods that a scene allows, the given one first.
std::vector<StepLadder> step_ladders(const io::Scene& scene);

/// `count` shorter steps at the end of a ladder.
void add_shorter(const io::Scene& scene, StepLadder& ladder, int count);

/// Whether the start has random numbers, which are others on another grid.
bool has_random_start(const io::Scene& scene);

/// The given grid without a change, or another one, of more or fewer points along both axes.
AxisLevel grid_level(const io::Scene& scene, int nx, int ny);

/// On a grid: a quarter, half, the given and twice the points along each axis, as far as they hold the start; of
/// particles: none.  `same_start`: none where the start is random, and so another on each grid; false where the wanted
/// means do not depend on it.
std::vector<AxisLevel> grid_levels(const io::Scene& scene, bool same_start = true);

/// The full model first; then simpler models, without one coefficient, field or dimension each, those that the scene
/// does not allow with the reason.
std::vector<AxisLevel> model_levels(const io::Scene& scene);

/// A cell of twice the sides, with the same distance of points and the same density of bodies; none where the start is
/// not uniform.
std::optional<AxisLevel> larger_cell(const io::Scene& scene);

}  // namespace drover::jobs
