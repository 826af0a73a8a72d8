// run/loop/provenance.hpp: the provenance of an archive, as root attributes.
#pragma once
#include <string>
#include <vector>

#include "files/archive.hpp"
#include "io/scene.hpp"

namespace drover::run {

/// Version, commit, resolved scene, seed, library versions, threads, host and start time; `what`: "run", "stability",
/// ...
std::vector<files::Attribute> provenance(const io::Scene& scene, int threads, const std::string& what = "run");
/// The same without threads, host and time: of a file that any of several processes may write.
std::vector<files::Attribute> shared_provenance(const io::Scene& scene, const std::string& what);

/// The version and commit of this drover, and those in the provenance of an archive: "0.1.0 (90f3..., changed)".
std::string this_program();
std::string program_of(const files::ArchiveReader& archive);

}  // namespace drover::run
