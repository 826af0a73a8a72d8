// run/json.hpp: results as JSON, for --json of the program and for Python.  Numbers that are not finite become null.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "drover/calibrate/table.hpp"
#include "drover/files/archive_reader.hpp"
#include "drover/io/scene.hpp"
#include "drover/run/report.hpp"
#include "drover/run/result.hpp"
#include "run/sweep.hpp"

namespace drover::run {

/// A number, or null when it is not finite.
nlohmann::json number_json(double value);

nlohmann::json result_json(const Result& result);

nlohmann::json report_json(const Report& report);

/// Coefficients by name, each with its points.
nlohmann::json table_json(const calibrate::Table& table);

nlohmann::json table_json(const SweepTable& table);

/// The sections of scenes, with their keys.
nlohmann::json schema_json(const std::vector<io::SectionDescription>& sections);

/// What a file holds: an archive of a run, a table of coefficients, or extended XYZ.
nlohmann::json info_json(const std::filesystem::path& file);

}  // namespace drover::run
