// run/warnings/late_order.cpp: order that a run without noise shows late, also along a ramp in time.
#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "measure/fields.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "run/fields/field_prediction.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/warnings/warnings.hpp"

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

    /// The rates of no order.
    Eigen::VectorXd sources(double t) {
        return whole_rates(t, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(components_.size())));
    }
    /// Its rates, without those of no order.
    Eigen::VectorXd rates(double t, const Eigen::VectorXd& order) { return whole_rates(t, order) - sources(t); }
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
        if (low >= 1e9) return infinite;
        for (int half = 0; half < 50; ++half) (grows((low + high) / 2.0) ? low : high) = (low + high) / 2.0;
        return low;
    }

    static constexpr double tiny = 1e-6;

private:
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

/// A field that orders: a vector and the like, a scalar, or both parts of a complex one.
struct Ordering {
    std::string name;
    std::vector<std::string> measured;  ///< names in observables
    std::vector<int> components;        ///< of the state
};

std::vector<Ordering> orderings_of(const measure::FieldSetting& setting) {
    std::vector<Ordering> all;
    for (const measure::MeasuredField& field : setting.fields) {
        if (field.first >= setting.of_state) continue;
        if (field.part == model::Part::imaginary && !all.empty() && all.back().name + "_im" == field.name) {
            all.back().measured.push_back(field.name);
            all.back().components.push_back(field.first);
        } else if (field.spin > 0) {
            all.push_back({field.name, {field.name}, {field.first, field.first + 1}});
        } else if (field.reference == 0.0 && field.part != model::Part::imaginary) {
            const bool is_real_part = field.part == model::Part::real;
            all.push_back(
                {field.name.substr(0, field.name.size() - (is_real_part ? 3 : 0)), {field.name}, {field.first}});
        }
    }
    return all;
}

std::vector<int> components_of(const std::vector<Ordering>& orderings) {
    std::vector<int> components;
    for (const Ordering& one : orderings)
        components.insert(components.end(), one.components.begin(), one.components.end());
    return components;
}

/// Their part of a vector with a number for each component.
double part_of(const Eigen::VectorXd& all, const std::vector<Ordering>& orderings, std::size_t n) {
    Eigen::Index begin = 0;
    for (std::size_t k = 0; k < n; ++k) begin += static_cast<Eigen::Index>(orderings[k].components.size());
    return all.segment(begin, static_cast<Eigen::Index>(orderings[n].components.size())).norm();
}

/// Without those that do not rest at 0.
std::vector<Ordering> without_sources(const std::vector<Ordering>& all, UniformOrder& order, double end) {
    std::vector<Ordering> kept;
    const Eigen::VectorXd sources = order.sources(0.0).cwiseAbs().cwiseMax(order.sources(end).cwiseAbs());
    const double negligible =
        1e-3 * order.rates(0.0, UniformOrder::tiny * Eigen::VectorXd::Ones(sources.size())).norm();
    for (std::size_t n = 0; n < all.size(); ++n)
        if (all[n].components.size() > 1 || part_of(sources, all, n) <= negligible) kept.push_back(all[n]);
    return kept;
}

/// The root mean square of a field over the cell, at each sample; empty: it was not observed.
std::vector<double> sizes_of(const files::ArchiveReader& archive, const model::Equations& equations,
                             const Ordering& ordering) {
    const auto series = [&](const std::string& name) { return series_of(archive, name); };
    std::vector<double> squares;
    for (const std::string& name : ordering.measured) {
        const std::vector<double> variances = series("variance_" + name);
        squares.resize(variances.size(), 0.0);
        std::ranges::transform(variances, squares, squares.begin(), std::plus<>());
    }
    const std::vector<model::UniformState> means = sampled_means(equations, series, 0);
    if (means.size() != squares.size()) return {};
    for (std::size_t i = 0; i < means.size(); ++i)
        for (const int component : ordering.components) {
            const double mean =
                means[i][static_cast<std::size_t>(equations.state_components()[static_cast<std::size_t>(component)])];
            squares[i] += mean * mean;
        }
    for (double& square : squares) square = std::sqrt(square);
    return squares;
}
}  // namespace

/// Without noise order grows from what the start or another run has left, as on a ramp: such a run ends before its
/// state.
void add_late_order(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                    std::vector<std::string>& warnings) try {
    const bool is_given =
        scene.initial.kind == model::StartKind::file || scene.initial.kind == model::StartKind::uniform;
    if (what.equations.has_noise() || (!is_given && placed_term_of(scene, what.equations).empty()) ||
        stays_at_start(scene, what.equations) || calls_program(scene))
        return;
    const numerics::Grid grid{std::min(scene.grid.nx, 8), std::min(scene.grid.ny, 8), scene.grid.lx, scene.grid.ly};
    const double end = scene.time.end;
    std::vector<Ordering> orderings =
        orderings_of(measure::make_field_setting(what.equations, scene.grid, what.kept_degree));
    if (orderings.empty()) return;
    UniformOrder all(what, grid, components_of(orderings));
    orderings = without_sources(orderings, all, end);
    if (orderings.empty()) return;
    UniformOrder order(what, grid, components_of(orderings));
    const double first = order.fastest(0.0).rate;
    const UniformOrder::Mode last = order.fastest(end);
    const bool is_ramp = std::abs(last.rate - first) > 1e-6 * std::abs(first);
    double exponent = 0.0;  // of the growth since the onset
    constexpr int parts = 100;
    for (int part = 1; part <= parts; ++part)
        exponent = std::max(0.0, exponent + order.fastest(end * (part - 0.5) / parts).rate * end / parts);
    constexpr double min_exponent = 0.5, far = 0.1;  // of the exponent, and of the order
    if (!(is_given || is_ramp) || exponent <= min_exponent || !(last.rate > 0.0)) return;
    std::size_t at = 0;  // the first field that grows: others follow
    while (part_of(last.shape, orderings, at) < 1e-3) ++at;
    // A scalar may pass through 0 as it oscillates, or rest there beside others that have grown.
    if (!is_ramp && orderings[at].components.size() == 1) return;
    const double whole = order.saturated(end, last) * part_of(last.shape, orderings, at);
    const std::vector<double> sizes = sizes_of(archive, what.equations, orderings[at]);
    if (sizes.empty() || !std::isfinite(whole) || sizes.back() >= far * whole) return;
    const double size = sizes.back(), samples = std::ceil(1.0 / (last.rate * scene.output.sample_every));
    // In the last 1/rate it does not grow as it would alone; samples farther apart do not tell.
    if (samples > 1.0 && samples < static_cast<double>(sizes.size()) && size > 0.0 &&
        !(size > sizes[sizes.size() - 1 - static_cast<std::size_t>(samples)]))
        return;
    warnings.push_back(
        text("{} is {:.2g} at the end, far below the {:.2g} at which it saturates: without noise it only grows from "
             "what the start contains, by a factor of at most {:.2g} since its onset, and at {} at the end; "
             "choose {}, a larger initial.amplitude, or noise",
             orderings[at].name, size, whole, std::exp(exponent), io::in_unit("{:.3g}", last.rate, "/s", scene.units),
             is_ramp      ? "a longer run, or a slower change in time"
             : size > 0.0 ? text("time.end = {:.3g}", end + 1.5 * std::log(whole / size) / last.rate)
                          : "another initial.kind"));
} catch (const Error& error) {  // the state without order lies outside the domain of a term
    if (error.fault() != Fault::run) throw;
}

}  // namespace drover::run
