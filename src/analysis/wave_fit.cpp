// analysis/wave_fit.cpp: drover fit: a table of estimates.
#include "analysis/wave_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "analysis/wave_problem.hpp"
#include "io/scene_text.hpp"

namespace drover::analysis {

namespace {
using calibrate::FittedValue;
using calibrate::WaveRecord;

run::Record row_of(const std::string& key, const std::string& unit, double start, const FittedValue& found,
                   const std::optional<FittedValue>& sparse) {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    const auto entry = [](const char* name, const char* meaning, double value) {
        return run::number(name, "", meaning, value, 4);
    };
    run::Record row;
    row.entries = {run::words("key", "number of the model", key),
                   entry("value", "estimate", found.value),
                   entry("error", "standard error, from the scatter of 32 segments of time", found.error),
                   entry("error_of_model", "the standard error that the model predicts", found.error_of_model),
                   entry("scene", "value in the scene", start),
                   entry("at_twice_the_spacing", "estimate from every second frame", sparse ? sparse->value : nothing),
                   run::words("unit", "of the number", unit),
                   run::data_only(run::flag("at_bound",
                                            "1: the value is the least allowed, and the waves would prefer a smaller "
                                            "one",
                                            found.at_bound)),
                   {.name = "correlations",
                    .unit = "1",
                    .meaning = "of the error with those of all values, in the order of the list",
                    .value = found.correlations,
                    .shown = {.text = false}}};
    return row;
}

/// What the estimates do not show by themselves.
std::vector<std::string> remarks_of(const std::vector<calibrate::FittedNumber>& numbers, const calibrate::WaveFit& fit,
                                    const std::optional<calibrate::WaveFit>& sparse) {
    std::vector<std::string> remarks;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const FittedValue& found = fit.values[i];
        const std::string& key = numbers[i].key;
        if (found.at_bound) remarks.push_back(text("{} is at its least value: the waves would prefer less", key));
        if (found.error > 2.0 * found.error_of_model)
            remarks.push_back(
                text("{}: its values in segments of time scatter {:.2g} times as much as the model "
                     "predicts: the waves are not those of its linear equations",
                     key, found.error / found.error_of_model));
        if (!sparse) continue;
        // Half of the pairs are the same, so the difference is known better than either value.
        const double apart = std::abs(sparse->values[i].value - found.value),
                     error = std::max(sparse->values[i].error, found.error);
        if (apart > 3.0 * error)
            remarks.push_back(
                text("{} depends on the spacing of the frames, by {:.2g} errors: the waves have a memory "
                     "that these equations lack, or frames have errors of their own",
                     key, apart / error));
    }
    return remarks;
}

/// What was fitted, for programs.
std::vector<run::Entry> entries_of(const WaveProblem& problem, double largest,
                                   const std::vector<std::string>& remarks) {
    const WaveRecord& record = problem.record;
    std::vector<run::Entry> entries{run::data_only(run::words("about", "uniform state of the waves", problem.about))};
    entries.insert(entries.end(), problem.state.begin(), problem.state.end());
    for (const run::Entry& entry : {run::count("waves", "wavevectors, one of each pair q and -q", record.q.size()),
                                    run::number("max_wavenumber", "mm-1", "largest |q|", largest),
                                    run::count("frames", "frames used", record.frames),
                                    run::number("spacing", "s", "time between them", record.spacing),
                                    run::words("remarks", "what the estimates do not show by themselves", remarks)})
        entries.push_back(run::data_only(entry));
    return entries;
}
}  // namespace

io::Scene fitted_scene(const std::string& archive, const std::string& file, const std::vector<std::string>& overrides) {
    if (!file.empty()) return io::read_scene(file, overrides);
    const std::string text = files::ArchiveReader(archive).text_attribute("scene");
    require(io::archived_scene(text, archive).kind != io::SceneKind::particles, {archive},
            "holds particles, which have no field equations of their own; expected a scene of fields to fit: give "
            "--scene models/calibrated-flock.toml or another");
    return io::parse_scene(text, archive, overrides);
}

run::Result make_wave_fit(const io::Scene& scene, const WaveFitOptions& options) {
    io::require_grid(scene, "fit");
    const files::ArchiveReader archive(options.archive);
    const io::Scene source = io::archived_scene(archive.text_attribute("scene"), options.archive);
    for (auto key = options.keys.begin(); key != options.keys.end(); ++key)
        require(std::find(options.keys.begin(), key, *key) == key, {}, "{} is given twice; expected each number once",
                *key);
    const WaveChoice choice{.max_wavenumber = options.max_wavenumber,
                            .begin = options.begin,
                            .end = options.end,
                            .every = options.every};
    WaveProblem problem = wave_problem(scene, options.keys, choice, {archive, options.archive, source});
    const std::vector<calibrate::FittedNumber> numbers = problem.waves.numbers;
    const calibrate::WaveFit fit = calibrate::fit_waves(problem.waves, problem.record, problem.noise);
    std::optional<calibrate::WaveFit> sparse;
    std::string no_sparse;
    if (problem.record.frames > 2 * calibrate::min_wave_pairs + 1) {
        for (std::size_t i = 0; i < numbers.size(); ++i) problem.waves.numbers[i].start = fit.values[i].value;
        try {
            sparse = calibrate::fit_waves(problem.waves, calibrate::thinned(problem.record, 2), problem.noise);
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;
            no_sparse =
                text("no estimate from every second frame, with which the first would be compared: {}", error.what());
        }
    }
    run::List list{.name = "coefficients", .heading = {}};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        list.rows.push_back(row_of(numbers[i].key, problem.units[i], numbers[i].start, fit.values[i],
                                   sparse ? std::optional(sparse->values[i]) : std::nullopt));
    std::vector<std::string> remarks = remarks_of(numbers, fit, sparse);
    if (!no_sparse.empty()) remarks.push_back(no_sparse);
    double largest = 0.0;
    for (const numerics::Wavevector& q : problem.record.q) largest = std::max(largest, std::hypot(q.x, q.y));
    run::Result result;
    result.root.header = {text("waves of {} about {}: {} up to {:.4g} /mm, in {} frames {:.4g} s apart",
                               options.archive, problem.about, problem.record.q.size(), largest, problem.record.frames,
                               problem.record.spacing)};
    result.root.entries = entries_of(problem, largest, remarks);
    result.root.lists = {std::move(list)};
    result.root.footer = remarks;
    return result;
}

}  // namespace drover::analysis
