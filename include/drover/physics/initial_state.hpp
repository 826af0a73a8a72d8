// physics/initial_state.hpp: the initial state of a run.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/model/start.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

struct InitialState {
    std::string kind = "uniform";  ///< uniform, random, mode, stationary, formula or file
    double amplitude = 0.0;        ///< of random or mode, in the unit of the field; formula: of added random noise
    std::string field = "polar_order_x";  ///< of mode
    int mode_x = 1, mode_y = 0;           ///< mode numbers of mode
    double phase = 0.0;                   ///< of mode [rad]
    // Of formula: expressions in x, y and the sides of the cell, lx and ly [mm]; "": the uniform state.
    std::string bead_density = {}, rod_density = {}, bead_velocity_x = {}, bead_velocity_y = {}, polar_order_x = {},
                polar_order_y = {};
    std::string file = {};  ///< of file: an archive
    int frame = -1;         ///< of file: -1 is the last
};

/// Throws an input Error, with its location, for a field, mode or kind that the model or grid does not have, and for a
/// formula of whose variance the grid cuts more than half.
void check(const InitialState& initial, const Model& model, const numerics::Grid& grid,
           const Dealiasing& dealiasing = {}, const LocationOf& place = no_location);

/// The same in the terms of any model, with the places of its formulas.
model::Start start_of(const InitialState& initial, const LocationOf& place = no_location);

/// The initial fields for every kind except "file": the uniform state plus the perturbation.  Random: independent
/// normal numbers of the given standard deviation in each cell of each field; the mean densities do not change.
/// Throws as check().
numerics::Spectra initial_spectra(const InitialState& initial, const Model& model, const numerics::System& system,
                                  std::uint64_t seed, Threads& threads);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::InitialState>>& schema<physics::InitialState>();
}  // namespace drover
