// run/warning_parts.hpp: what the warnings of runs of fields share.
#pragma once
#include <string>
#include <vector>

#include "files/archive_reader.hpp"
#include "io/scene.hpp"
#include "model/field_evolution.hpp"

namespace drover::run {

/// Whether terms are functions of the calling program, which may fail where a run does not ask them.
bool calls_program(const io::Scene& scene);
/// Whether a run starts in a uniform stationary state, and has no noise.
bool stays_at_start(const io::Scene& scene, const model::Equations& equations);

/// Negative densities, and values beyond a table.
void add_density_warnings(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                          std::vector<std::string>& warnings);
/// Order that has not grown yet.
void add_late_order(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                    std::vector<std::string>& warnings);

/// The recorded values of an observable of a run of fields; empty in archives without it.
std::vector<double> series_of(const files::ArchiveReader& archive, const std::string& name);

}  // namespace drover::run
