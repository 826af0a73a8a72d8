// report/shown.hpp: reports, tables and files as text for people, and as JSON for --json of the program and for Python.
// Numbers that are not finite become null.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibrate/table.hpp"
#include "io/scene.hpp"
#include "jobs/sweep/sweep.hpp"
#include "run/report/report.hpp"
#include "run/result.hpp"

namespace drover::report {

/// Scalars, structure factors and number fluctuations, each with its prediction.
std::string text_of(const run::Report& report);
nlohmann::json json_of(const run::Report& report);

/// One line for each point, then remarks.
std::string text_of(const calibrate::Table& table);
/// Coefficients by name, each with its points.
nlohmann::json json_of(const calibrate::Table& table);

std::string text_of(const jobs::SweepTable& table);
nlohmann::json json_of(const jobs::SweepTable& table);

/// What a file holds: an archive of a run, a table of coefficients, or extended XYZ.
std::string info_text(const std::filesystem::path& file, bool with_scene);
nlohmann::json info_json(const std::filesystem::path& file);

/// Warnings that are known before a run.  Throws an input Error where a run, sweep, calibration or boundary of the
/// scene would: a file of its start that is not there, memory or disk that are not free.
std::vector<std::string> check_scene(const io::Scene& scene);

/// Fields, the terms of their equations, coefficients, kept modes and the growth about the references, or bodies;
/// memory, disk and wall time, for which a few steps are timed.  Of a scene with a time step.
run::Result explain(const io::Scene& scene);

/// Throws as check_output: for the start of a command, before it computes the result.  `inputs`: beside those of the
/// scene.
void check_result_file(const std::filesystem::path& file, std::vector<std::filesystem::path> inputs,
                       const io::Scene& scene, bool overwrite);

/// Writes the archive of a result with its provenance; `what`: "stability", "boundary".  The file appears when it is
/// complete.  Throws as check_result_file and files::write_archive.
void write_result(const run::Result& result, const std::filesystem::path& file, const std::string& what,
                  const io::Scene& scene, int threads, bool overwrite);

/// The sections of scenes, with their keys.
nlohmann::json schema_json(const std::vector<io::SectionDescription>& sections);

}  // namespace drover::report
