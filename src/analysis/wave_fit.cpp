// analysis/wave_fit.cpp: drover fit: from frames to waves, the numbers of the equations that they determine, and a
// table of estimates.
#include "analysis/wave_fit.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "drover/theory/theory.hpp"
#include "io/scene.hpp"
#include "measure/fields.hpp"
#include "model/start.hpp"
#include "physics/integrated.hpp"
#include "run/fields/scene_equations.hpp"

namespace drover::analysis {

namespace {
using calibrate::FittedValue;
using calibrate::WaveModel;
using calibrate::WaveRecord;

/// The waves of frames, and the equations about the state of their means.
struct WaveProblem {
    calibrate::WaveRecord record;
    calibrate::WaveModel waves;
    calibrate::NoiseOf noise = calibrate::NoiseOf::frames;
    std::vector<std::string> units;  ///< of the numbers
    std::string about;               ///< "an ordered state": the uniform state of the waves
    std::vector<run::Entry> state;   ///< its values
};

/// An archive of frames, what messages call it, and its scene.
struct FrameSource {
    const files::ArchiveReader& archive;
    std::string name;
    const io::Scene& scene;
};

/// Whether the mean of a vector over the frames is the order of a flock, by |mean|^2/<|F|^2>.  Throws an input Error
/// for an order that is neither there nor gone.
bool is_steady(double mean_square, double square, const std::string& archive, const std::string& field) {
    const double steadiness = square > 0.0 ? mean_square / square : 0.0;
    require(
        steadiness <= 0.5 || steadiness > 0.9, {archive},
        "has a mean of {} over these frames of {:.2g} of its root mean square; expected less than 0.7 (no order) or "
        "more than 0.95 (a flock that keeps its direction): choose more frames, or fewer with --from and --to",
        field, std::sqrt(steadiness));
    return steadiness > 0.5;
}

/// Of each component with a rate over the frames.
struct FrameMeans {
    std::vector<double> values;   ///< of a field with a spin 0 where it is not steady
    std::vector<double> squares;  ///< of the mean over the cell
    bool is_ordered = false;
};

/// Whether the mean of a vector is 0 but for rounding, beside the waves.
bool is_rounding(const WaveRecord& record, std::size_t part, std::size_t parts, double square) {
    double largest = 0.0;
    for (std::size_t wave = 1; wave < record.q.size(); ++wave)
        for (const std::size_t i : {part, part + 1})
            largest = std::max(largest, std::norm(record.amplitudes[wave][(record.frames - 1) * parts + i]));
    return square < 1e-20 * largest;
}

/// order: the name of the field that alone decides whether there is order; "": each field for itself.
FrameMeans means_of(const WaveRecord& record, const model::Equations& equations, const std::string& archive,
                    const std::string& order) {
    const std::vector<model::StateComponent> parts = model::components_of_state(equations);
    FrameMeans means{.values = std::vector<double>(parts.size(), 0.0),
                     .squares = std::vector<double>(parts.size(), 0.0)};
    for (std::size_t frame = 0; frame < record.frames; ++frame)
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const double value = record.amplitudes.front()[frame * parts.size() + i].real();
            means.values[i] += value / static_cast<double>(record.frames);
            means.squares[i] += value * value / static_cast<double>(record.frames);
        }
    const auto clear = [&](std::size_t i) { means.values[i] = means.values[i + 1] = 0.0; };
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const model::Field& field = equations.model().fields[parts[i].field];
        if (field.spin == 0 || parts[i].part != 0) continue;
        if (!order.empty() && field.name != order) {
            others.push_back(i);
            continue;
        }
        const double mean = std::hypot(means.values[i], means.values[i + 1]),
                     square = means.squares[i] + means.squares[i + 1];
        const bool is_order =
            !is_rounding(record, i, parts.size(), square) && is_steady(mean * mean, square, archive, field.name);
        if (is_order) means.is_ordered = true;
        else clear(i);
    }
    if (!means.is_ordered) std::ranges::for_each(others, clear);
    return means;
}

/// Marks the components whose mean is conserved.  Returns false where a sum of several is conserved.
bool mark_conserved(const model::Equations& equations, const std::vector<double>& means,
                    std::vector<WaveModel::Field>& fields) {
    fields.resize(means.size());
    for (std::size_t i = 0; i < means.size(); ++i) fields[i].size = std::abs(means[i]);
    const Eigen::MatrixXd conserved = theory::conserved_means(equations);
    bool are_single = true;
    for (Eigen::Index row = 0; row < conserved.rows(); ++row) {
        Eigen::Index largest = 0;
        if (conserved.row(row).cwiseAbs().maxCoeff(&largest) > 1.0 - 1e-12)
            fields[static_cast<std::size_t>(largest)].is_conserved = true;
        else are_single = false;
    }
    return are_single;
}

/// Whether a scalar that is not conserved fluctuates about another value than 0.
bool has_mean(const FrameMeans& means, const model::Equations& equations, const std::vector<WaveModel::Field>& fields) {
    // Of the mean square: of fluctuations about 0 it is 2 tau/T on average, here T = 20 tau.
    constexpr double share = 0.1;
    const std::vector<model::StateComponent> parts = model::components_of_state(equations);
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (equations.model().fields[parts[i].field].spin == 0 && !fields[i].is_conserved &&
            means.values[i] * means.values[i] > share * means.squares[i])
            return true;
    return false;
}

/// What fluctuates of the components at q, as the rows of LinearisedAt::symbol: of a divergence-free field the part
/// across q alone.
class FreeParts {
public:
    explicit FreeParts(const model::Equations& equations) {
        const std::vector<model::StateComponent> parts = model::components_of_state(equations);
        count_ = static_cast<Eigen::Index>(parts.size());
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const bool is_pair = equations.model().fields[parts[i].field].solenoidal;
            parts_.push_back({static_cast<Eigen::Index>(i), is_pair});
            if (is_pair) ++i;
        }
    }
    bool are_all() const { return std::ranges::none_of(parts_, &Part::is_across); }

    /// Rows: the parts, of unit length; columns: the components.
    Eigen::MatrixXd at(const numerics::Wavevector& q) const {
        const double length = std::hypot(q.x, q.y);
        Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parts_.size()), count_);
        for (Eigen::Index row = 0; row < rows.rows(); ++row) {
            const Part& part = parts_[static_cast<std::size_t>(row)];
            rows(row, part.component) = part.is_across ? -q.y / length : 1.0;
            if (part.is_across) rows(row, part.component + 1) = q.x / length;
        }
        return rows;
    }

    void keep(WaveRecord& record) const {
        const auto before = static_cast<std::size_t>(count_);
        for (std::size_t wave = 0; wave < record.q.size(); ++wave) {
            const Eigen::MatrixXd rows = at(record.q[wave]);
            std::vector<std::complex<double>> kept;
            for (std::size_t frame = 0; frame < record.frames; ++frame) {
                const Eigen::Map<const Eigen::VectorXcd> all(record.amplitudes[wave].data() + frame * before, count_);
                const Eigen::VectorXcd parts = rows * all;
                kept.insert(kept.end(), parts.begin(), parts.end());
            }
            record.amplitudes[wave] = std::move(kept);
        }
    }

    void keep(std::vector<WaveModel::Field>& fields) const {
        fields = mapped(parts_, [&](const Part& part) { return fields[static_cast<std::size_t>(part.component)]; });
    }

private:
    struct Part {
        Eigen::Index component;
        bool is_across;  ///< of this component and the next
    };
    Eigen::Index count_ = 0;
    std::vector<Part> parts_;
};

/// Removes the mean of an archive from its waves.  Throws an input Error where no other wave is left.
void leave_out_mean(WaveRecord& record, const std::string& archive, const char* whose) {
    require(record.q.size() > 1, {archive},
            "is of {}, whose mean is no wave, and has no other up to the largest wavenumber; expected some: choose a "
            "larger --max-wavenumber",
            whose);
    record.q.erase(record.q.begin());
    record.amplitudes.erase(record.amplitudes.begin());
}

/// Adds the numbers that are fitted; returns whether the noise about the state depends on one of them.
bool add_numbers(const io::Scene& scene, const std::vector<std::string>& keys, const model::UniformState& about,
                 WaveProblem& problem) {
    const auto noise_of = [&](const io::Scene& changed) { return run::equations_of(changed).noise(about, {1.0, 0.0}); };
    const model::Symbol noise = noise_of(scene);
    bool is_in_noise = false;
    for (const std::string& key : keys) {
        const run::SceneNumber number = run::number_of(scene, "fit", key, {scene.file});
        for (const calibrate::FittedNumber& other : problem.waves.numbers)
            require(other.key != number.key, {}, "{} is given twice; expected each number once", key);
        calibrate::FittedNumber fitted{.key = number.key, .start = number.value};
        if (scene.kind != io::SceneKind::model) {
            require(!key.starts_with("uniform."), {},
                    "{} is that of the frames; expected a coefficient of the equations", key);
            fitted.min = io::model_number(key, {}, scene.model).range.min;
        }
        const double other = number.value + 0.5 * std::abs(number.value) + 1.0;
        is_in_noise = is_in_noise || noise_of(run::scene_with(scene, number.key, other)) != noise;
        problem.waves.numbers.push_back(std::move(fitted));
        problem.units.push_back(io::unit_in_results(scene, number.unit));
    }
    return is_in_noise;
}

WaveRecord record_of(const io::Scene& scene, const model::Equations& equations, WaveChoice choice,
                     const FrameSource& source) {
    choice.units = source.scene.units;
    const bool is_own = scene.kind == io::SceneKind::model, is_of_own = source.scene.kind == io::SceneKind::model;
    require(!is_own || is_of_own, {source.name}, "is no run of a model of its own; expected one with the fields of {}",
            scene.file);
    if (source.scene.kind == io::SceneKind::particles)
        return particle_waves(source.archive, source.name, source.scene, equations.model(), choice);
    RecordedFields recorded{.grid = source.scene.grid, .kept_degree = run::compiled_of(source.scene).kept_degree};
    for (const model::StateComponent& one : model::components_of_state(equations))
        recorded.components.push_back({one.name, io::renamed(one.unit, source.scene.units)});
    return field_waves(source.archive, source.name, recorded, choice);
}
/// The numbers that `keys` name of the equations of a scene, which may be another one than that of the frames with the
/// same fields.
WaveProblem wave_problem(const io::Scene& scene, const std::vector<std::string>& keys, const WaveChoice& choice,
                         const FrameSource& source) {
    const model::Integrated what = run::compiled_of(scene);
    const model::Equations& equations = what.equations;
    const std::string placed = run::placed_term_of(scene, equations);
    require(placed.empty(), {scene.file}, "{} depends on position or time; expected equations with uniform states",
            placed);
    WaveProblem problem;
    problem.record = record_of(scene, equations, choice, source);
    const measure::FieldSetting observed = measure::make_field_setting(equations, scene.grid, what.kept_degree);
    const FrameMeans means =
        means_of(problem.record, equations, source.name, measure::name_of(observed, observed.order));
    model::UniformState about = equations.reference();
    for (std::size_t i = 0; i < means.values.size(); ++i)
        about[static_cast<std::size_t>(equations.state_components()[i])] = means.values[i];
    problem.noise = add_numbers(scene, keys, about, problem) ? calibrate::NoiseOf::model : calibrate::NoiseOf::frames;
    const FreeParts free(equations);
    const bool are_single = mark_conserved(equations, means.values, problem.waves.fields);
    const char* without_mean = means.is_ordered                                   ? "a flock"
                               : !free.are_all()                                  ? "a divergence-free field"
                               : !are_single                                      ? "fields whose sum is conserved"
                               : has_mean(means, equations, problem.waves.fields) ? "a field with a mean"
                                                                                  : nullptr;
    if (without_mean != nullptr) leave_out_mean(problem.record, source.name, without_mean);
    if (!free.are_all()) {
        free.keep(problem.record);
        free.keep(problem.waves.fields);
    }
    problem.waves.at = [scene, numbers = problem.waves.numbers, about](const std::vector<double>& values) {
        io::Scene changed = scene;
        for (std::size_t i = 0; i < numbers.size(); ++i) changed = run::scene_with(changed, numbers[i].key, values[i]);
        const auto linear = std::make_shared<const model::LinearisedAt>(run::equations_of(changed), about);
        return calibrate::LinearWaves{.symbol = [linear](const numerics::Wavevector& q) { return linear->symbol(q); },
                                      .noise = [linear](const numerics::Wavevector& q) -> Eigen::MatrixXcd {
                                          return linear->noise(q);
                                      }};
    };
    problem.about = means.is_ordered ? "an ordered state" : "the state without order";
    std::size_t at = 0;
    const model::UniformState whole = equations.completed(about);
    for (const model::Field& field : equations.model().fields)
        for (const std::string& name : model::dataset_names(field))
            problem.state.push_back(run::number(name, field.unit, name + " of the uniform state", whole[at++]));
    return problem;
}

run::Record row_of(const std::string& key, const std::string& unit, double start, const FittedValue& found,
                   const std::optional<FittedValue>& sparse) {
    const auto entry = [](const char* name, const char* meaning, double value) {
        return run::number(name, "", meaning, value, 4);
    };
    run::Record row;
    row.entries = {run::words("key", "number of the model", key),
                   entry("value", "estimate", found.value),
                   entry("error",
                         "standard error, from the scatter of 32 segments of time, or that of the model where larger",
                         found.error),
                   entry("error_of_model", "the standard error that the model predicts", found.error_of_model),
                   entry("scene", "value in the scene", start),
                   entry("at_twice_the_spacing", "estimate from every second frame", sparse ? sparse->value : nan),
                   run::words("unit", "of the number", unit),
                   run::data_only(run::flag("at_bound",
                                            "1: the value is at its lower bound, towards which the likelihood "
                                            "increases",
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
        if (found.at_bound)
            remarks.push_back(text("{} is at its lower bound, towards which the likelihood increases", key));
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
                                    run::words("remarks", "remarks on the reliability of the estimates", remarks)})
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
    WaveProblem problem = wave_problem(scene, options.keys, options.choice, {archive, options.archive, source});
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
    run::List list{.name = "coefficients", .heading = {}, .has_like_rows = false};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        list.rows.push_back(row_of(numbers[i].key, problem.units[i], numbers[i].start, fit.values[i],
                                   sparse ? std::optional(sparse->values[i]) : std::nullopt));
    std::vector<std::string> remarks = remarks_of(numbers, fit, sparse);
    if (!no_sparse.empty()) remarks.push_back(no_sparse);
    double largest = 0.0;
    for (const numerics::Wavevector& q : problem.record.q) largest = std::max(largest, std::hypot(q.x, q.y));
    run::Result result;
    result.root.header = {text("waves of {} about {}: {} up to {}, in {} frames {} apart", options.archive,
                               problem.about, problem.record.q.size(),
                               io::in_unit("{:.4g}", largest, "/mm", scene.units), problem.record.frames,
                               io::in_unit("{:.4g}", problem.record.spacing, "s", scene.units))};
    result.root.entries = entries_of(problem, largest, remarks);
    result.root.lists = {std::move(list)};
    result.root.footer = remarks;
    return result;
}

}  // namespace drover::analysis
