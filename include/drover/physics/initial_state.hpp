// physics/initial_state.hpp: the state a run starts from.
#pragma once
#include <cstdint>
#include <string>

#include "drover/base/threads.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

struct InitialState {
    std::string kind = "uniform";  ///< uniform, random, mode, stationary, formula or file
    double amplitude = 0.0;        ///< of random or mode, in the unit of the field; of formula: random, added to it
    std::string field = "polar_order_x";  ///< of mode
    int mode_x = 1, mode_y = 0;           ///< mode numbers of mode
    double phase = 0.0;                   ///< of mode [rad]
    // Of formula: in x and y [mm]; "": the uniform state.
    std::string bead_density = {}, rod_density = {}, bead_velocity_x = {}, bead_velocity_y = {}, polar_order_x = {},
                polar_order_y = {};
    std::string file = {};  ///< of file: an archive
    int frame = -1;         ///< of file: -1 is the last
};

/// Throws an input Error, at its place, for a field, a mode or a kind that the model and grid do not have.
void check(const InitialState& initial, const Model& model, const numerics::Grid& grid,
           const Dealiasing& dealiasing = {}, const LocationOf& place = no_location);

/// The fields of every kind but "file": the uniform state and the perturbation.  Random: independent normal numbers of
/// the given deviation in each cell of each field, the means of the densities unchanged.  Throws as check().
numerics::Spectra initial_spectra(const InitialState& initial, const Model& model, const numerics::System& system,
                                  std::uint64_t seed, Threads& threads);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::InitialState>>& schema<physics::InitialState>();
}  // namespace drover
