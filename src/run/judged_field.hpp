// run/judged_field.hpp: what warnings ask of a kind of scene of fields.
#pragma once
#include <string>
#include <vector>

#include "drover/files/archive_reader.hpp"
#include "drover/io/scene.hpp"

namespace drover::run {

/// A field, and what a warning says of it.
struct JudgedField {
    std::string name;
    int first = 0, parts = 1;        ///< its components in the equations
    std::string smoothing = {};      ///< the key that damps its short waves; "": unknown
    double scale = 0.0;              ///< its size where products matter; 0: its own
    bool judges_transients = false;  ///< the first half of a run counts, too
};
std::vector<JudgedField> judged_fields(const io::Scene& scene);
std::vector<JudgedField> rod_bead_judged(const io::Scene& scene);

/// What is known before a run.
std::vector<std::string> rod_bead_warnings(const io::Scene& scene);
std::vector<std::string> declared_warnings(const io::Scene& scene);

/// Negative densities, and densities beyond a table.
void add_density_warnings(const files::ArchiveReader& archive, const io::Scene& scene,
                          std::vector<std::string>& warnings);
/// Order that has not grown yet.
void add_late_order(const files::ArchiveReader& archive, const io::Scene& scene, std::vector<std::string>& warnings);

/// The recorded values of an observable of a run of fields; empty in archives without it.
std::vector<double> series_of(const files::ArchiveReader& archive, const std::string& name);

}  // namespace drover::run
