// run/late_order.cpp: order that a run without noise shows late, also along a ramp in time.
#include <algorithm>
#include <cmath>

#include "measure/field_setting.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "run/field_prediction.hpp"
#include "run/scene_equations.hpp"
#include "run/warnings.hpp"

namespace drover::run {

namespace {
/// Uniform order about the references, at any time: of the given components of a state.
class UniformOrder {
public:
    UniformOrder(const model::Integrated& what, const numerics::Grid& grid, std::vector<int> components)
        : rate_(model::system_of(what, grid, one_)),
          state_(grid, static_cast<int>(what.equations.state_components().size())),
          components_(std::move(components)) {
        const model::UniformState reference = what.equations.reference();
        for (int c = 0; const int place : what.equations.state_components())
            state_[c++][0] = reference[static_cast<std::size_t>(place)];
    }

    /// Its rates, without those of no order.
    Eigen::VectorXd rates(double t, const Eigen::VectorXd& order) {
        return whole_rates(t, order) - whole_rates(t, Eigen::VectorXd::Zero(order.size()));
    }
    /// The order that grows fastest: its shape, of norm 1, what measures it in any order, and its rate.
    struct Mode {
        Eigen::VectorXd shape, measure;
        double rate = 0.0;
    };
    Mode fastest(double t) {
        const auto count = static_cast<Eigen::Index>(components_.size());
        Eigen::MatrixXd slopes(count, count);
        for (Eigen::Index k = 0; k < count; ++k)
            slopes.col(k) = rates(t, tiny * Eigen::VectorXd::Unit(count, k)) / tiny;
        if (!slopes.allFinite()) return {};
        numerics::DenseEigen modes = numerics::dense_eigen(slopes.cast<std::complex<double>>());
        Eigen::Index at = 0, largest = 0;
        const double rate = modes.values.real().maxCoeff(&at);
        modes.vectors.col(at).cwiseAbs().maxCoeff(&largest);
        modes.vectors.col(at) /= std::polar(1.0, std::arg(modes.vectors(largest, at)));  // real, for a real rate
        return {modes.vectors.col(at).real(), numerics::inverse(modes.vectors).row(at).real(), rate};
    }
    /// The size at which it stops growing; infinite: none.
    double saturated(double t, const Mode& mode) {
        const auto grows = [&](double size) { return mode.measure.dot(rates(t, size * mode.shape)) > 0.0; };
        double low = tiny, high = 2.0 * tiny;
        while (low < 1e9 && grows(high)) low = high, high *= 2.0;
        if (low >= 1e9) return INFINITY;
        for (int half = 0; half < 50; ++half) (grows((low + high) / 2.0) ? low : high) = (low + high) / 2.0;
        return low;
    }

private:
    static constexpr double tiny = 1e-6;
    Eigen::VectorXd whole_rates(double t, const Eigen::VectorXd& order) {
        Eigen::VectorXd found(order.size());
        for (Eigen::Index k = 0; k < found.size(); ++k) state_[components_[static_cast<std::size_t>(k)]][0] = order(k);
        const numerics::Spectra rate = rate_(t, state_);
        for (Eigen::Index k = 0; k < found.size(); ++k)
            found(k) = rate[components_[static_cast<std::size_t>(k)]][0].real();
        return found;
    }

    Threads one_{1};
    numerics::WholeRate rate_;
    numerics::Spectra state_;
    std::vector<int> components_;
};

/// The root mean square of a field over the cell at the end.
double last_size(const files::ArchiveReader& archive, const model::Equations& equations,
                 const measure::MeasuredField& field) {
    const std::vector<double> variances = series_of(archive, "variance_" + field.name);
    if (variances.empty()) return INFINITY;
    const auto series = [&](const std::string& name) { return series_of(archive, name); };
    const model::UniformState means = sampled_means(equations, series, variances.size() - 1).back();
    const auto x = static_cast<std::size_t>(equations.state_components()[static_cast<std::size_t>(field.first)]);
    return std::sqrt(means[x] * means[x] + means[x + 1] * means[x + 1] + variances.back());
}
}  // namespace

/// Without noise order grows from what the start or another run has left, as on a ramp: such a run ends before its
/// state.
void add_late_order(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                    std::vector<std::string>& warnings) try {
    const bool is_given = scene.initial.kind == "file" || scene.initial.kind == "uniform";
    if (what.equations.has_noise() || (!is_given && placed_term_of(scene, what.equations).empty()) ||
        stays_at_start(scene, what.equations) || calls_program(scene))
        return;
    measure::FieldSetting setting = measure::make_field_setting(what.equations, scene.grid, what.kept_degree);
    std::erase_if(setting.fields, [&](const measure::MeasuredField& field) {
        return field.spin == 0 || field.first >= setting.of_state;
    });
    std::vector<int> components;
    for (const measure::MeasuredField& field : setting.fields)
        components.insert(components.end(), {field.first, field.first + 1});
    if (components.empty()) return;
    const numerics::Grid& grid = scene.grid;
    UniformOrder order(what, {std::min(grid.nx, 8), std::min(grid.ny, 8), grid.lx, grid.ly}, components);
    const double end = scene.time.end, first = order.fastest(0.0).rate;
    const UniformOrder::Mode last = order.fastest(end);
    const bool is_ramp = std::abs(last.rate - first) > 1e-6 * std::abs(first);
    double exponent = 0.0;  // of the growth since the onset
    constexpr int parts = 100;
    for (int part = 1; part <= parts; ++part)
        exponent = std::max(0.0, exponent + order.fastest(end * (part - 0.5) / parts).rate * end / parts);
    constexpr double min_exponent = 0.5, far = 0.1;  // of the exponent, and of the order
    if (!(is_given || is_ramp) || exponent <= min_exponent || !(last.rate > 0.0)) return;
    Eigen::Index at = 0;  // the first field that grows: others follow
    while (last.shape.segment<2>(2 * at).norm() < 1e-3) ++at;
    const measure::MeasuredField& field = setting.fields[static_cast<std::size_t>(at)];
    const double whole = order.saturated(end, last) * last.shape.segment<2>(2 * at).norm(),
                 size = last_size(archive, what.equations, field);
    if (!std::isfinite(whole) || size >= far * whole) return;
    warnings.push_back(
        text("{} is {:.2g} at the end, far below the {:.2g} at which it saturates: without noise it has grown since "
             "its onset by a factor of {:.2g} at most, from what the start contains, at {:.3g} /s at the end; choose "
             "{}, a larger initial.amplitude, or noise",
             field.name, size, whole, std::exp(exponent), last.rate,
             is_ramp      ? "a longer run, or a slower change in time"
             : size > 0.0 ? text("time.end = {:.3g}", end + 1.5 * std::log(whole / size) / last.rate)
                          : "another initial.kind"));
} catch (const Error& error) {  // the state without order lies outside the domain of a term
    if (error.fault() != Fault::run) throw;
}

}  // namespace drover::run
