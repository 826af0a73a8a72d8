// run/stability_maps.hpp: arrays over wavenumber, angle and frequency of one uniform state.
#pragma once
#include "drover/files/archive.hpp"
#include "drover/io/scene.hpp"
#include "drover/physics/long_waves.hpp"
#include "drover/physics/stability.hpp"

namespace drover::run {

/// 2 pi over the longer side of the cell [1/mm].
double smallest_wavenumber(const numerics::Grid& grid);

void add_map(const std::string& name, const std::string& unit, const std::string& meaning,
             std::vector<std::string> axes, std::vector<double> values, files::ResultTable& table);

files::ResultTable stability_maps(const io::Scene& scene, const physics::Equations& equations,
                                  const physics::StationaryState& state, const model::LongWaves& waves,
                                  const model::GrowthSearch& search, Threads& threads);

}  // namespace drover::run
