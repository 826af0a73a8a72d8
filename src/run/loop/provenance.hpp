// run/loop/provenance.hpp: the provenance of an archive, as root attributes; whether files belong to one run, and if
// not, in what the runs differ.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "drover/base/error.hpp"
#include "files/archive.hpp"
#include "files/archive_reader.hpp"
#include "files/checkpoint.hpp"
#include "files/record_folder.hpp"
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

/// An input Error: files of several runs are mixed up.  It is of their folder, and of no scene.
class MixedFiles : public Error {
public:
    MixedFiles(const std::filesystem::path& file, const std::string& message)
        : Error(Fault::input, {.file = file.string()}, message) {}
};

/// Throws MixedFiles unless both have the same run id and, apart from what a restart may change, the same scene.
/// Archives of earlier versions have no run id.  The Error names the first difference: a key of the scene, the version
/// of drover, or the ids.
void require_same_run(const files::ArchiveReader& archive, const std::filesystem::path& file,
                      const files::Checkpoint& checkpoint);

/// The end of a run that counts as one of a scene.
enum class End { same, any };

/// Throws MixedFiles, which names the first difference, unless the archive is of a run of this scene: with any number
/// of threads, and with a time step of its own choice where the scene gives none.  Throws another input Error for a
/// file that cannot be read.
void require_archive_of(const io::Scene& scene, const std::filesystem::path& file, End end);

/// The keys in which two scenes differ, each from a file of TOML or the one that an archive stores.
std::vector<files::TextDifference> scene_differences(const std::filesystem::path& one,
                                                     const std::filesystem::path& other);

}  // namespace drover::run
