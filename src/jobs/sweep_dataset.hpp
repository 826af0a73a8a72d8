// jobs/sweep_dataset.hpp: all results of a sweep as one file of arrays over the varied keys and the seeds.
#pragma once
#include <filesystem>
#include <map>

#include "io/scene.hpp"
#include "jobs/run_record.hpp"
#include "jobs/sweep_table.hpp"

namespace drover::jobs {

/// Writes the file, which netCDF-4 libraries open: over the varied keys, the branch of a ramp and its own axes, each
/// result as <name> with <name>_error, the mean over the seeds, and with several seeds <name>_of_runs and its error,
/// which have the axis seed too.  NaN: not there.  Where runs differ in an axis of a result, as in the wavenumbers of
/// different cells, that axis counts from 0, and <axis>_values has its values at each point.  Where two points have the
/// same values, as on a ramp that comes back, the axis of all is `point`, and the keys are results.  `table`: of the
/// same results, of which it holds the single numbers.
void write_sweep_dataset(const std::filesystem::path& file, const io::Scene& scene, const SweepLayout& layout,
                         const std::map<std::string, RunResults>& results, const SweepTable& table);

}  // namespace drover::jobs
