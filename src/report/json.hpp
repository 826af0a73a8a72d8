// report/json.hpp: reports, tables and files as JSON, for --json of the program and for Python. Numbers that are not
// finite become null.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "calibrate/table.hpp"
#include "files/archive_reader.hpp"
#include "io/scene.hpp"
#include "jobs/sweep.hpp"
#include "run/report.hpp"
#include "run/result.hpp"

namespace drover::report {

nlohmann::json report_json(const run::Report& report);

/// Coefficients by name, each with its points.
nlohmann::json table_json(const calibrate::Table& table);

nlohmann::json table_json(const jobs::SweepTable& table);

/// The sections of scenes, with their keys.
nlohmann::json schema_json(const std::vector<io::SectionDescription>& sections);

/// What a file holds: an archive of a run, a table of coefficients, or extended XYZ.
nlohmann::json info_json(const std::filesystem::path& file);

}  // namespace drover::report
