// run/fields/field_problem.cpp: the components of a run of fields, their observables, and the frame from which it
// starts.
#include "run/fields/field_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/log.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/transform.hpp"
#include "files/archive_reader.hpp"
#include "model/start.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/scene_support.hpp"

namespace drover::run {

namespace {
std::vector<files::Quantity> quantities(const std::vector<model::StateComponent>& components) {
    return mapped(components, [](const model::StateComponent& one) {
        return files::Quantity{one.name, one.unit, one.meaning, {"y", "x"}};
    });
}

double variance_of(std::span<const double> values) {
    const auto count = static_cast<double>(values.size());
    double mean = 0.0, squares = 0.0;
    for (const double value : values) mean += value / count;
    for (const double value : values) squares += (value - mean) * (value - mean) / count;
    return squares;
}

/// The fields with the modes that both grids have.  degree: that decides which modes `to` keeps.
numerics::Fields resampled(const numerics::Fields& fields, const numerics::Grid& from, const numerics::Grid& to,
                           int degree) {
    Threads one(1);
    const numerics::Transform source(from, 1, one), target(to, degree, one);
    numerics::Spectra given(from, fields.count()), wanted(to, fields.count());
    source.forward(fields, given);
    const numerics::Grid common{.nx = std::min(from.nx, to.nx),
                                .ny = std::min(from.ny, to.ny),
                                .lx = to.lx,
                                .ly = to.ly};
    const std::vector<numerics::ModePair> at_source = numerics::shared_modes({common}, {from}),
                                          at_target = numerics::shared_modes({common}, {to});
    for (int c = 0; c < fields.count(); ++c)
        for (std::size_t k = 0; k < at_source.size(); ++k) wanted[c][at_target[k].fine] = given[c][at_source[k].fine];
    numerics::Fields result(to, fields.count());
    target.backward(wanted, result);
    return result;
}

/// Says that the fields of a frame are on other points, and what is lost.
void tell_resampled(const io::Scene& scene, const std::vector<files::Quantity>& names, const numerics::Grid& from,
                    const numerics::Fields& before, const numerics::Fields& after) {
    log_information("{}: {} by {} points; the fields are taken on {} by {} by their Fourier modes", scene.initial.file,
                    from.nx, from.ny, scene.grid.nx, scene.grid.ny);
    constexpr double much = 0.01;
    for (std::size_t c = 0; c < names.size(); ++c) {
        const double whole = variance_of(before[static_cast<int>(c)]);
        const double lost = 1.0 - variance_of(after[static_cast<int>(c)]) / whole;
        if (whole > 0.0 && lost > much)
            log_warning(
                "{}: {:.2g} % of the variance of {} is in waves that {} by {} points do not have, and is left out; "
                "choose more points to keep it",
                scene.initial.file, 100.0 * lost, names[c].name, scene.grid.nx, scene.grid.ny);
    }
}

/// The grid of a field of frames: any points in the cell of the scene.
numerics::Grid grid_of(const files::ArchiveReader& archive, const std::string& dataset, const io::Scene& scene) {
    const std::vector<std::size_t> shape = archive.shape(dataset);
    const auto points = [&](std::size_t axis) { return shape.size() == 3 ? static_cast<int>(shape[axis]) : 0; };
    numerics::Grid grid = scene.grid;
    grid.nx = points(2);
    grid.ny = points(1);
    require(grid.nx >= 1 && grid.ny >= 1 && archive.read("/x").values == cell_corners(grid.nx, grid.lx) &&
                archive.read("/y").values == cell_corners(grid.ny, grid.ly),
            io::locate(scene, "initial.file"),
            "initial.file = \"{}\" has another cell; expected one of {} by {}, with any number of points",
            scene.initial.file, scene.grid.lx, io::in_unit("{}", scene.grid.ly, "mm", scene.units));
    const auto is_even = [](int count) { return count >= 4 && count % 2 == 0; };
    require(
        is_even(grid.nx) && (grid.ny == 1 || is_even(grid.ny)), io::locate(scene, "initial.file"),
        "initial.file = \"{}\" has {} by {} points; expected an archive of drover: even numbers of at least 4, or one "
        "row",
        scene.initial.file, grid.nx, grid.ny);
    return grid;
}

/// A frame of an archive as the state; its fields and cell must be those of the scene.
numerics::Fields frame_of(const files::ArchiveReader& archive, const io::Scene& scene,
                          const std::vector<files::Quantity>& names, int degree) {
    const SourceLocation here = io::locate(scene, "initial.file");
    for (const files::Quantity& field : names)
        require(archive.has("/" + field.name), here,
                "initial.file = \"{}\" has no field {}; expected an archive of this model", scene.initial.file,
                field.name);
    const numerics::Grid grid = grid_of(archive, "/" + names.front().name, scene);
    numerics::Fields frame(grid, static_cast<int>(names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string dataset = "/" + names[c].name;
        require(archive.shape(dataset) == archive.shape("/" + names.front().name), here,
                "initial.file = \"{}\" has {} and {} on different points; expected fields of one run",
                scene.initial.file, names.front().name, names[c].name);
        const auto frames = static_cast<int>(archive.shape(dataset)[0]);
        require(scene.initial.frame < frames && frames >= 1, io::locate(scene, "initial.frame"),
                "initial.frame = {}; expected one of the frames 0 to {} of the archive, or -1 for the last",
                scene.initial.frame, frames - 1);
        const int number = scene.initial.frame < 0 ? frames - 1 : scene.initial.frame;
        const files::Array row = archive.read_row(dataset, static_cast<std::size_t>(number));
        require(std::ranges::all_of(row.values, [](double value) { return std::isfinite(value); }), here,
                "initial.file = \"{}\" has a {} that is not finite in frame {}; expected finite values: choose another "
                "frame",
                scene.initial.file, names[c].name, number);
        std::ranges::copy(row.values, frame[static_cast<int>(c)].begin());
    }
    for (const files::Quantity& field : names) {
        const std::string unit = archive.text_attribute("/" + field.name, "units"),
                          expected = io::renamed(field.unit, scene.units);
        require(unit == expected, here, "initial.file = \"{}\" has {} in {}; expected {}", scene.initial.file,
                field.name, unit, expected);
    }
    if (grid.nx == scene.grid.nx && grid.ny == scene.grid.ny) return frame;
    numerics::Fields result = resampled(frame, grid, scene.grid, degree);
    tell_resampled(scene, names, grid, frame, result);
    return result;
}
}  // namespace

FieldObserver::FieldObserver(measure::FieldSetting setting, Threads& threads,
                             std::unique_ptr<model::EnergyMeter> energy)
    : setting_(std::move(setting)),
      transform_(setting_.grid, setting_.degree, threads),
      balanced_(setting_.grid, setting_.in_balance),
      rows_(measure::field_observables(setting_)),
      energy_(std::move(energy)) {}

std::vector<files::Quantity> FieldObserver::quantities() const { return quantities_of(rows_); }

std::size_t FieldObserver::values() const {
    std::size_t values = 0;
    for (const auto& row : rows_) values += measure::size_of(row.axes);
    return values;
}

std::vector<std::vector<double>> FieldObserver::measure(const FieldState& state) {
    if (balanced_.count() > 0) transform_.forward(state.balanced, balanced_);
    measure::FieldMoment moment{.setting = setting_,
                                .state = state.spectra,
                                .state_on_grid = state.fields,
                                .balanced = balanced_,
                                .balanced_on_grid = state.balanced,
                                .step_error = state.step_error};
    if (energy_) moment.energy = energy_->measure(state.time, state.spectra);
    return measure_all(rows_, moment);
}

SharedObserver field_observer(const io::Scene& scene, const model::Integrated& what, Threads& threads) {
    measure::FieldSetting setting = measure::make_field_setting(what.equations, scene.grid, what.kept_degree);
    setting.watches_error = scene.time.max_error > 0.0;
    if (!scene.output.powers) return std::make_shared<FieldObserver>(std::move(setting), threads);
    setting.terms = names_of_terms(scene, what.equations);
    return std::make_shared<FieldObserver>(std::move(setting), threads,
                                           std::make_unique<model::EnergyMeter>(what.equations, scene.grid,
                                                                                what.kept_degree, threads));
}

SharedObserver observer_of_state(const SharedObserver& whole, Threads& threads) {
    measure::FieldSetting setting = whole->setting();
    if (!setting.watches_error && !setting.terms) return whole;
    setting.watches_error = false;
    setting.terms.reset();
    return std::make_shared<FieldObserver>(std::move(setting), threads);
}

void check_result_names(const io::Scene& scene) {
    if (scene.kind != io::SceneKind::model) return;
    const model::Equations equations = equations_of(scene);
    numerics::Grid small = scene.grid;  // the names do not depend on it
    small.nx = std::min(small.nx, 8);
    small.ny = std::min(small.ny, 8);
    const measure::FieldSetting setting = measure::make_field_setting(equations, small, 1);
    const auto series = mapped(measure::field_observables(setting), [](const auto& row) {
        return measure::recorded_series(row, std::vector<double>(measure::size_of(row.axes)));
    });
    std::vector<std::string> names;
    for (const measure::SummaryRow& row : measure::summarise(measure::field_recording(setting, series)).rows)
        for (const char* ending : measure::result_endings) names.push_back(row.name + ending);
    std::ranges::sort(names);
    const auto twice = std::ranges::adjacent_find(names);
    if (twice == names.end()) return;
    std::vector<std::string> fields;
    for (const model::Field& field : equations.model().fields)
        if (twice->find(field.name) != std::string::npos) fields.push_back(field.name);
    fail_input({scene.file},
               "two results of the fields {} would both be named {} in archives; rename one of the fields",
               joined(fields), *twice);
}

FieldProblem field_problem(const io::Scene& scene) {
    FieldProblem problem{.integrated = integrated_in_run(scene)};
    problem.components = quantities(model::components_of_state(problem.integrated.equations));
    problem.balanced = quantities(model::components_in_balance(problem.integrated.equations));
    complete_problem(scene, problem);
    return problem;
}

bool is_finite(numerics::Complex value, std::size_t modes) {
    const double max = std::numeric_limits<double>::max() / static_cast<double>(2 * modes);
    return std::abs(value.real()) < max && std::abs(value.imag()) < max;
}

void find_balanced(const model::FieldEvolution& evolution, double time, const numerics::Spectra& state,
                   numerics::Fields& to) {
    if (to.count() == 0) return;
    const numerics::Fields now = evolution.balanced(time, state);
    std::ranges::copy(now.values, to.values.begin());
}

std::vector<double> cell_corners(int count, double side) {
    std::vector<double> result;
    for (int i = 0; i < count; ++i) result.push_back(side / count * i);
    return result;
}

numerics::Fields frame_of_file(const io::Scene& scene, const std::vector<files::Quantity>& fields, int degree) {
    const files::ArchiveReader archive = named_archive(scene, "initial.file", scene.initial.file);
    numerics::Fields frame = frame_of(archive, scene, fields, degree);
    warn_of_unfinished(archive, "initial.file", scene.initial.file, scene.initial.frame);
    const files::Attribute same{"seed", std::int64_t{scene.run.seed}};
    if (io::has_noise(scene) && std::ranges::count(archive.attributes(), same) > 0)
        log_warning(
            "initial.file = \"{}\" is of a run with the same run.seed = {}: with the same time.dt this run has the "
            "noise of that one again, and is no independent sample; choose another run.seed",
            scene.initial.file, scene.run.seed);
    return frame;
}

}  // namespace drover::run
