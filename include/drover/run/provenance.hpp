// run/provenance.hpp: the provenance of an archive, as root attributes.
#pragma once
#include <vector>

#include "drover/files/archive.hpp"
#include "drover/io/scene.hpp"

namespace drover::run {

/// Version, commit, resolved scene, seed, library versions, threads, host and start time; `what`: "run", "stability",
/// ...
std::vector<files::Attribute> provenance(const io::Scene& scene, int threads, const std::string& what = "run");

}  // namespace drover::run
