// run/model_fit.cpp: the waves of the fields of a declared model, and its coefficients that they determine.
#include <algorithm>
#include <cmath>
#include <memory>

#include "drover/model/start.hpp"
#include "drover/model/theory.hpp"
#include "run/model_coefficients.hpp"
#include "run/wave_problem.hpp"

namespace drover::run {

namespace {
using calibrate::WaveModel;
using calibrate::WaveRecord;

/// The mean over frames of each component with a rate; of a field with a spin 0 where it is not steady.
struct FrameMeans {
    std::vector<double> values;
    bool is_ordered = false;
};

FrameMeans means_of(const WaveRecord& record, const model::Equations& equations, const std::string& archive) {
    const std::vector<model::StateComponent> parts = model::components_of_state(equations);
    FrameMeans means{.values = std::vector<double>(parts.size(), 0.0)};
    std::vector<double> squares(parts.size(), 0.0);
    for (std::size_t frame = 0; frame < record.frames; ++frame)
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const double value = record.amplitudes.front()[frame * parts.size() + i].real();
            means.values[i] += value / static_cast<double>(record.frames);
            squares[i] += value * value / static_cast<double>(record.frames);
        }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const model::Field& field = equations.model().fields[parts[i].field];
        if (field.spin == 0 || parts[i].part != 0) continue;
        const double mean = std::hypot(means.values[i], means.values[i + 1]);
        if (is_steady(mean * mean, squares[i] + squares[i + 1], archive, "mean of " + field.name))
            means.is_ordered = true;
        else means.values[i] = means.values[i + 1] = 0.0;
    }
    return means;
}

/// Whether the noise depends on one of these coefficients.
bool is_in_noise(const io::DeclaredModel& declared, const std::vector<std::string>& names) {
    const model::Equations start = equations_with(declared, {});
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
        const double value = declared.coefficients.at(name);
        const model::Equations changed = equations_with(declared, {{name, value + 0.5 * std::abs(value) + 1.0}});
        return changed.noise(changed.reference(), {1.0, 0.0}) != start.noise(start.reference(), {1.0, 0.0});
    });
}

/// Marks the components whose mean is conserved.  Returns false where a sum of several is conserved.
bool mark_conserved(const model::Equations& equations, const std::vector<double>& means,
                    std::vector<WaveModel::Field>& fields) {
    fields.resize(means.size());
    for (std::size_t i = 0; i < means.size(); ++i) fields[i].size = std::abs(means[i]);
    const Eigen::MatrixXd conserved = model::conserved_means(equations);
    bool are_single = true;
    for (Eigen::Index row = 0; row < conserved.rows(); ++row) {
        Eigen::Index largest = 0;
        if (conserved.row(row).cwiseAbs().maxCoeff(&largest) > 1.0 - 1e-12)
            fields[static_cast<std::size_t>(largest)].is_conserved = true;
        else are_single = false;
    }
    return are_single;
}
}  // namespace

WaveProblem model_wave_problem(const io::Scene& scene, const std::vector<std::string>& keys, const WaveChoice& choice,
                               const files::ArchiveReader& archive, const std::string& file, const io::Scene& source) {
    require(source.kind == io::SceneKind::model, {file},
            "is no run of a model of its own; expected one with the fields of {}", scene.file);
    const model::Equations equations = equations_with(scene.declared, {});
    if (const model::TermSummary* placed = equations.placed_term())
        fail_input(placed->where, "{} depends on position or time; expected equations with uniform states",
                   placed->text);
    for (const model::Field& field : equations.model().fields)
        require(!field.solenoidal || field.left == model::LeftSide::balance, field.where,
                "{} is solenoidal, and waves of it have one component only, which drover fit does not know yet; "
                "expected fields without that constraint",
                field.symbol);
    std::vector<std::string> names;
    for (const std::string& key : keys) names.push_back(coefficient_of(scene, "fit", key, {scene.file}));
    RecordedFields recorded{.grid = source.grid,
                            .kept_degree = io::kept_degree(source, model::Equations(io::model_of(source.declared)))};
    for (const model::StateComponent& one : model::components_of_state(equations))
        recorded.components.push_back({one.name, one.unit});
    WaveProblem problem{.record = field_waves(archive, file, recorded, choice)};
    const FrameMeans means = means_of(problem.record, equations, file);
    model::UniformState about = equations.reference();
    for (std::size_t i = 0; i < means.values.size(); ++i)
        about[static_cast<std::size_t>(equations.state_components()[i])] = means.values[i];
    if (!mark_conserved(equations, means.values, problem.waves.fields) || means.is_ordered)
        leave_out_mean(problem.record, file, choice.max_wavenumber);
    for (const std::string& name : names) {
        problem.waves.numbers.push_back({.key = "coefficients." + name, .start = scene.declared.coefficients.at(name)});
        problem.units.emplace_back("1");
    }
    problem.waves.at = [declared = scene.declared, names, about](const std::vector<double>& values) {
        std::vector<std::pair<std::string, double>> changes;
        for (std::size_t i = 0; i < names.size(); ++i) changes.emplace_back(names[i], values[i]);
        const auto linear = std::make_shared<const model::LinearisedAt>(equations_with(declared, changes), about);
        return calibrate::LinearWaves{.symbol = [linear](const numerics::Wavevector& q) { return linear->symbol(q); },
                                      .noise = [linear](const numerics::Wavevector& q) -> Eigen::MatrixXcd {
                                          return linear->noise(q);
                                      }};
    };
    problem.noise = is_in_noise(scene.declared, names) ? calibrate::NoiseOf::model : calibrate::NoiseOf::frames;
    problem.about = means.is_ordered ? "an ordered state" : "the state without order";
    std::size_t at = 0;
    const model::UniformState whole = equations.completed(about);
    for (const model::Field& field : equations.model().fields)
        for (const std::string& name : model::dataset_names(field))
            problem.state.push_back(
                {.name = name, .unit = field.unit, .meaning = name + " of the uniform state", .value = whole[at++]});
    return problem;
}

}  // namespace drover::run
