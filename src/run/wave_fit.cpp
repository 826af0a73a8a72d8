// run/wave_fit.cpp: drover fit: the model, its uniform state in the frames, and a table of estimates.
#include "drover/run/wave_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "drover/io/scene_text.hpp"
#include "drover/physics/linear_theory.hpp"
#include "run/wave_problem.hpp"

namespace drover::run {

namespace {
using calibrate::FittedValue;
using calibrate::WaveRecord;

/// The uniform state about which the waves of a record are small.
struct State {
    physics::UniformPoint point;
    bool is_flock = false;
};

State state_of(const WaveRecord& record, const physics::Form& form, const physics::Model& model,
               const std::string& name) {
    const auto fields = record.amplitudes.front().size() / record.frames;
    std::vector<double> means(fields, 0.0);
    double square = 0.0;
    const auto order = static_cast<std::size_t>(form.polar_order);
    for (std::size_t frame = 0; frame < record.frames; ++frame) {
        const auto* at = &record.amplitudes.front()[frame * fields];
        for (std::size_t i = 0; i < fields; ++i) means[i] += at[i].real() / static_cast<double>(record.frames);
        square += (std::norm(at[order]) + std::norm(at[order + 1])) / static_cast<double>(record.frames);
    }
    State state{.point = physics::at_rest(physics::reference(model.uniform))};
    if (form.bead_density >= 0) state.point.bead_density = means[static_cast<std::size_t>(form.bead_density)];
    if (form.rod_density >= 0) state.point.rod_density = means[static_cast<std::size_t>(form.rod_density)];
    const Eigen::Vector2d mean(means[order], means[order + 1]);
    state.is_flock = is_steady(mean.squaredNorm(), square, name, "mean order");
    if (!state.is_flock) return state;
    state.point.order = mean;
    if (form.velocity == physics::Velocity::dynamic) {
        const auto velocity = static_cast<std::size_t>(form.bead_velocity);
        state.point.velocity = {means[velocity], means[velocity + 1]};
    }
    return state;
}

std::vector<calibrate::RodBeadNumber> numbers_of(const std::vector<std::string>& keys, const physics::Model& model,
                                                 std::vector<std::string>& units) {
    std::vector<calibrate::RodBeadNumber> numbers;
    for (const std::string& key : keys) {
        const io::ModelNumber number = io::model_number(key, {}, model);
        require(key != "uniform.rod_density" && key != "uniform.bead_density", {},
                "{} is that of the frames; expected a coefficient of the equations", key);
        numbers.push_back({.key = key, .in = number.in, .least = number.range.min});
        units.push_back(number.unit.empty() ? "1" : number.unit);
    }
    return numbers;
}

Record row_of(const std::string& key, const std::string& unit, double start, const FittedValue& found,
              const std::optional<FittedValue>& sparse) {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    const auto entry = [](const char* name, const char* meaning, double value) {
        return Entry{.name = name, .unit = "", .meaning = meaning, .value = value, .digits = 4};
    };
    Record row;
    row.entries = {{.name = "key", .unit = "", .meaning = "number of the model", .value = key},
                   entry("value", "estimate", found.value),
                   entry("error", "standard error, from the scatter of 32 segments of time", found.error),
                   entry("error_of_model", "the standard error that the model predicts", found.error_of_model),
                   entry("scene", "value in the scene", start),
                   entry("at_twice_the_spacing", "estimate from every second frame", sparse ? sparse->value : nothing),
                   {.name = "unit", .unit = "", .meaning = "of the number", .value = unit},
                   {.name = "at_bound",
                    .unit = "1",
                    .meaning = "1: the value is the least allowed, and the waves would prefer a smaller one",
                    .value = found.at_bound,
                    .shown = {.text = false}},
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
std::vector<Entry> entries_of(const WaveProblem& problem, double largest, const std::vector<std::string>& remarks) {
    const WaveRecord& record = problem.record;
    std::vector<Entry> entries{{.name = "about",
                                .unit = "",
                                .meaning = "uniform state of the waves",
                                .value = problem.about,
                                .shown = {.text = false}}};
    entries.insert(entries.end(), problem.state.begin(), problem.state.end());
    const std::vector<Entry> rest{{.name = "waves",
                                   .unit = "1",
                                   .meaning = "wavevectors, one of each pair q and -q",
                                   .value = static_cast<std::int64_t>(record.q.size()),
                                   .shown = {.text = false}},
                                  {.name = "max_wavenumber",
                                   .unit = "mm-1",
                                   .meaning = "largest |q|",
                                   .value = largest,
                                   .shown = {.text = false}},
                                  {.name = "frames",
                                   .unit = "1",
                                   .meaning = "frames used",
                                   .value = static_cast<std::int64_t>(record.frames),
                                   .shown = {.text = false}},
                                  {.name = "spacing",
                                   .unit = "s",
                                   .meaning = "time between them",
                                   .value = record.spacing,
                                   .shown = {.text = false}},
                                  {.name = "remarks",
                                   .unit = "",
                                   .meaning = "what the estimates do not show by themselves",
                                   .value = remarks,
                                   .shown = {.text = false}}};
    entries.insert(entries.end(), rest.begin(), rest.end());
    return entries;
}

WaveProblem rod_bead_problem(const io::Scene& scene, const WaveFitOptions& options, const WaveChoice& choice,
                             const files::ArchiveReader& archive, const io::Scene& source) {
    const physics::Equations equations(scene.model);
    const physics::Form& form = equations.form;
    const std::string beyond = physics::nonuniform_term(equations);
    require(beyond.empty(), {scene.file}, "{} depends on position or time; expected equations with uniform states",
            beyond);
    WaveProblem problem;
    const std::vector<calibrate::RodBeadNumber> numbers = numbers_of(options.keys, scene.model, problem.units);
    if (source.kind == io::SceneKind::particles) {
        problem.record = particle_waves(archive, options.archive, source, form, choice);
    } else {
        RecordedFields recorded{.grid = source.grid,
                                .kept_degree =
                                    physics::kept_degree(physics::Equations(source.model), source.dealiasing)};
        for (const physics::Component& one : physics::component_names(form))
            recorded.components.push_back({one.name, one.unit});
        problem.record = field_waves(archive, options.archive, recorded, choice);
    }
    const State state = state_of(problem.record, form, scene.model, options.archive);
    if (state.is_flock)
        leave_out_mean(problem.record, options.archive, options.max_wavenumber);  // the mean is the flock itself
    const bool fits_noise = std::any_of(options.keys.begin(), options.keys.end(),
                                        [](const std::string& key) { return key.starts_with("noise."); });
    problem.noise = fits_noise ? calibrate::NoiseOf::model : calibrate::NoiseOf::frames;
    problem.waves = calibrate::rod_bead_waves(scene.model, state.point, numbers);
    problem.about = state.is_flock ? "a flock" : "the state without order";
    problem.state = {{.name = "order",
                      .unit = form.order_is_density ? "mm-2" : "1",
                      .meaning = "its polar order",
                      .value = std::vector<double>{state.point.order.x(), state.point.order.y()},
                      .shown = {.text = state.is_flock}}};
    return problem;
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

Result make_wave_fit(const io::Scene& scene, const WaveFitOptions& options) {
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
    WaveProblem problem = scene.kind == io::SceneKind::model
                              ? model_wave_problem(scene, options.keys, choice, archive, options.archive, source)
                              : rod_bead_problem(scene, options, choice, archive, source);
    const std::vector<calibrate::FittedNumber> numbers = problem.waves.numbers;
    const calibrate::WaveFit fit = calibrate::fit_waves(problem.waves, problem.record, problem.noise);
    std::optional<calibrate::WaveFit> sparse;
    if (problem.record.frames > 2 * calibrate::min_wave_pairs + 1) {
        for (std::size_t i = 0; i < numbers.size(); ++i) problem.waves.numbers[i].start = fit.values[i].value;
        sparse = calibrate::fit_waves(problem.waves, calibrate::thinned(problem.record, 2), problem.noise);
    }
    List list{.name = "coefficients", .heading = {}};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        list.rows.push_back(row_of(numbers[i].key, problem.units[i], numbers[i].start, fit.values[i],
                                   sparse ? std::optional(sparse->values[i]) : std::nullopt));
    const std::vector<std::string> remarks = remarks_of(numbers, fit, sparse);
    double largest = 0.0;
    for (const numerics::Wavevector& q : problem.record.q) largest = std::max(largest, std::hypot(q.x, q.y));
    Result result;
    result.root.header = {text("waves of {} about {}: {} up to {:.4g} /mm, in {} frames {:.4g} s apart",
                               options.archive, problem.about, problem.record.q.size(), largest, problem.record.frames,
                               problem.record.spacing)};
    result.root.entries = entries_of(problem, largest, remarks);
    result.root.lists = {std::move(list)};
    result.root.footer = remarks;
    return result;
}

}  // namespace drover::run
