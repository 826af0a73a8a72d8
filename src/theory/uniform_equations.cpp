// theory/uniform_equations.cpp: rates of uniform states, what they conserve, and whether they turn with space.
#include "theory/uniform_equations.hpp"

#include <cmath>
#include <complex>
#include <map>

#include "base/constants.hpp"
#include "numerics/algebra/dense.hpp"

namespace drover::theory {

double squared_order(const model::Model& model, const model::UniformState& state) {
    double square = 0.0;
    for (const auto& [field, first] : model::placed_fields(model))
        if (field.spin > 0)
            for (const double value : {state[first], state[first + 1]}) square += value * value;
    return square;
}

double squared_distance(const model::UniformState& a, const model::UniformState& b) {
    double square = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
    return square;
}

std::vector<int> fields_of(const model::Equations& equations, const std::vector<int>& components) {
    std::vector<int> of_component, result;
    int number = 0;
    for (const model::Field& field : equations.model().fields)
        of_component.insert(of_component.end(), model::components(field), number++);
    for (const int k : components) result.push_back(of_component[static_cast<std::size_t>(k)]);
    return result;
}

bool has_order(const model::Model& model, const model::UniformState& state) {
    return std::ranges::any_of(model::placed_fields(model), [&](const model::PlacedField& one) {
        return one.field.spin > 0 && (state[one.first] != 0.0 || state[one.first + 1] != 0.0);
    });
}

namespace {
/// The state turned by an angle.
model::UniformState turned_state(const model::Model& model, model::UniformState state, double angle) {
    for (const auto& [field, first] : model::placed_fields(model)) {
        if (field.spin == 0) continue;
        const std::complex<double> value =
            std::complex<double>(state[first], state[first + 1]) * std::polar(1.0, field.spin * angle);
        state[first] = value.real(), state[first + 1] = value.imag();
    }
    return state;
}

constexpr double exact_slopes = 1e-11;

/// By how much linear parts may differ that are the same, relative to their size.
double rounding_of_slopes(const model::Model& model) {
    const auto has_inexact = [](const std::map<std::string, model::GivenFunction>& functions) {
        return std::ranges::any_of(functions, [](const auto& function) { return !function.second.has_exact_slopes; });
    };
    bool is_inexact = has_inexact(model.functions);
    for (const model::Field& field : model.fields)
        for (const model::WrittenTerm& term : field.further)
            is_inexact = is_inexact || (term.scope != nullptr && has_inexact(term.scope->functions));
    return is_inexact ? 1e-6 : exact_slopes;  // differences of smooth functions are right to 1e-8 and better
}

/// The rates of the components with a rate; not finite where a function is not defined.
Eigen::VectorXd rates_at(const model::Equations& equations, const model::UniformState& state) try {
    return equations.uniform_rates(state)(equations.state_components());
} catch (const Error& error) {
    if (error.fault() != Fault::run) throw;
    return Eigen::VectorXd::Constant(static_cast<Eigen::Index>(equations.state_components().size()), nan);
}

/// A random state: true scalars about their references, the nearer the narrower the domain of a function is.
model::UniformState random_state(const model::Equations& equations, Numbers& numbers) {
    model::UniformState state;
    for (double width = 0.4; width > 1e-4; width *= 0.5) {
        state = equations.reference();
        for (double& value : state)
            value = value != 0.0 ? value * numbers.between(1.0 - width, 1.0 + width) : numbers.between(-1.0, 1.0);
        if (rates_at(equations, state).allFinite()) break;
    }
    return state;
}

}  // namespace

UniformEquations::UniformEquations(const model::Equations& equations, const model::UniformState& means)
    : equations_(equations),
      means_(equations.completed(means)),
      conserved_(conserved_means(equations)),
      reference_(of_state(means_)) {
    for (const model::PlacedField& one : model::placed_fields(model()))
        for (int k = 0; k < model::components(one.field); ++k) places_.push_back(one);
    turns_freely_ = commutes_with_turns();
}

UniformEquations::Vector UniformEquations::of_state(const model::UniformState& all) const {
    Vector z(static_cast<Eigen::Index>(equations_.state_components().size()));
    for (Eigen::Index k = 0; k < z.size(); ++k)
        z(k) = all[static_cast<std::size_t>(equations_.state_components()[static_cast<std::size_t>(k)])];
    return z;
}

model::UniformState UniformEquations::state_of(const Vector& z) const {
    model::UniformState all = means_;
    for (Eigen::Index k = 0; k < z.size(); ++k)
        all[static_cast<std::size_t>(equations_.state_components()[static_cast<std::size_t>(k)])] = z(k);
    return all;
}

UniformEquations::Vector UniformEquations::turned(const Vector& z, double angle) const {
    return of_state(turned_state(model(), state_of(z), angle));
}

UniformEquations::Vector UniformEquations::turn_of(const Vector& z) const {
    model::UniformState all = state_of(z), change(all.size(), 0.0);
    for (std::size_t k = 0; k < all.size(); ++k) {
        const auto& [field, first] = places_[k];
        if (const int spin = field.spin; spin > 0) change[k] = k == first ? -spin * all[first + 1] : spin * all[first];
    }
    return of_state(change);
}

UniformEquations::Vector UniformEquations::values(const Vector& z) const {
    ++evaluations_;
    Vector f(count() + conserved_.rows());
    f << rates_at(equations_, state_of(z)), conserved_ * (z - reference_);
    return f;
}

UniformEquations::Matrix UniformEquations::jacobian(const Vector& z) const {
    evaluations_ += 10 * count();
    Matrix j(count() + conserved_.rows(), count());
    try {
        const std::vector<int>& state = equations_.state_components();
        j << equations_.symbol(state_of(z), {})(state, state).real(), conserved_;
    } catch (const Error&) {  // an iterate outside the domain of a function, such as a root of a density below 0
        j.setConstant(nan);
    }
    return j;
}

UniformEquations::Vector UniformEquations::sizes(const Vector& z, const Matrix& j) const {
    Vector sizes = j.cwiseAbs() * z.cwiseAbs();
    sizes.head(count()) += equations_.uniform_rate_sizes(state_of(z))(equations_.state_components());
    sizes.tail(conserved_.rows()) += conserved_.cwiseAbs() * reference_.cwiseAbs();
    return sizes;
}

UniformEquations::Vector UniformEquations::relative(const Vector& z, const Matrix& j) const {
    return relative(values(z), sizes(z, j));
}

UniformEquations::Vector UniformEquations::relative(const Vector& f, const Vector& sizes) {
    return (f.array() == 0.0).select(0.0, f.array().abs() / sizes.array());
}

bool UniformEquations::commutes_with_turns() const {
    Numbers numbers;
    bool is_tested = false;
    constexpr int trials = 12;
    for (int trial = 0; trial < trials; ++trial) {
        // Slopes by differences are right to their error in states of order 1 alone.
        const bool with_waves = trial < 2 || rounding_of_slopes(model()) == exact_slopes;
        model::UniformState state = random_state(equations_, numbers);
        if (trial >= 2)  // as terms of other degrees outweigh all others in other units
            for (const auto& [field, first] : model::placed_fields(model())) {
                const double factor = std::pow(10.0, numbers.between(-15.0, 15.0));
                for (std::size_t k = first; k < first + static_cast<std::size_t>(model::components(field)); ++k)
                    if (equations_.reference()[k] == 0.0) state[k] *= factor;
            }
        const double angle = trial % 2 == 0 ? 0.7 : 2.1;
        const model::UniformState there = turned_state(model(), state, angle);
        const std::optional<bool> is_same = are_turned(state, there, angle, with_waves);
        if (!is_same) continue;
        if (!*is_same && is_well_conditioned(state, with_waves, numbers)) return false;
        is_tested = is_tested || *is_same;
    }
    return is_tested;
}

/// False where rounding errors of a state alone make a difference, so that a comparison there tells nothing.
bool UniformEquations::is_well_conditioned(const model::UniformState& state, bool with_waves, Numbers& numbers) const {
    constexpr int trials = 4;
    constexpr double rounding = 1e-14;
    for (int trial = 0; trial < trials; ++trial) {
        model::UniformState nudged = state;
        for (double& value : nudged) value *= 1.0 + rounding * numbers.between(-1.0, 1.0);
        if (!are_turned(state, nudged, 0.0, with_waves).value_or(false)) return false;
    }
    return true;
}

/// Whether the rates of the second state, and with_waves the linear parts about it, are those of the first turned;
/// nothing where they are not finite.
std::optional<bool> UniformEquations::are_turned(const model::UniformState& one, const model::UniformState& other,
                                                 double angle, bool with_waves) const {
    try {
        const model::LinearisedAt from(equations_, one), to(equations_, other);
        const Vector z = of_state(one), rates = values(z).head(count()), found = values(of_state(other)).head(count());
        if (!rates.allFinite() || !found.allFinite()) return {};
        for (const model::LinearisedAt* at : {&from, &to})
            for (const auto& power : at->powers())
                if (!power.factors.allFinite()) return {};
        const Vector missed = turned(rates, angle) - found, parts = sizes(z, jacobian(z)).head(count());
        const std::vector<int>& state = equations_.state_components();
        for (Eigen::Index k = 0; k < count(); ++k) {
            const auto field = [&](Eigen::Index i) {
                return places_[static_cast<std::size_t>(state[static_cast<std::size_t>(i)])].first;
            };
            double size = 0.0;
            for (Eigen::Index i = 0; i < count(); ++i)
                if (field(i) == field(k)) size += parts(i);
            if (!(std::abs(missed(k)) <= 1e-11 * size)) return false;
        }
        return !with_waves || waves_are_turned(from, to, angle);
    } catch (const Error&) {  // a derivative that is not finite
        return {};
    }
}

/// Order by order in q, so that no length decides which terms are seen.
bool UniformEquations::waves_are_turned(const model::LinearisedAt& from, const model::LinearisedAt& to,
                                        double angle) const {
    const auto n = static_cast<Eigen::Index>(places_.size());
    Matrix turn(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
        model::UniformState unit(static_cast<std::size_t>(n), 0.0);
        unit[static_cast<std::size_t>(k)] = 1.0;
        const model::UniformState column = turned_state(model(), unit, angle);
        turn.col(k) = Eigen::Map<const Vector>(column.data(), n);
    }
    const double rounding = rounding_of_slopes(model());
    const std::map<int, Matrix> sizes = from.sizes_by_order();
    const auto sizes_of = [&](int order) -> Matrix {
        const auto found = sizes.find(order);
        return found != sizes.end() ? found->second : Matrix::Zero(n, n);
    };
    for (const double of_wave : {0.4, 1.9}) {
        std::map<int, Matrix> missed = to.factors_by_order(of_wave + angle);
        for (auto& [order, factors] : missed) factors *= turn;
        for (const auto& [order, factors] : from.factors_by_order(of_wave))
            missed.try_emplace(order, Matrix::Zero(n, n)).first->second -= turn * factors;
        for (const auto& [order, difference] : missed)
            if (!(difference.cwiseAbs().array() <= rounding * sizes_of(order).array()).all()) return false;
    }
    return true;
}

bool turns_freely(const model::Equations& equations) {
    return UniformEquations(equations, equations.reference()).turns_freely();
}

Eigen::MatrixXd conserved_means(const model::Equations& equations) {
    const std::vector<int>& state = equations.state_components();
    const auto n = static_cast<Eigen::Index>(state.size());
    Numbers numbers;
    Eigen::MatrixXd rates(n, 0);
    for (int trial = 0; trial < 64 * n && rates.cols() < 4 * n + 24; ++trial) {
        model::UniformState at = random_state(equations, numbers);
        if (trial % 2 == 1)  // of other units, where one field outweighs all others; and beyond thresholds
            for (std::size_t k = 0; k < at.size(); ++k) {
                const double decades = equations.reference()[k] == 0.0 ? 15.0 : trial % 4 == 3 ? 3.0 : 0.0;
                at[k] *= std::pow(10.0, numbers.between(-decades, decades));
            }
        const Eigen::VectorXd found = rates_at(equations, at);
        if (!found.allFinite()) continue;  // such as the square root of a density below 0
        rates.conservativeResize(Eigen::NoChange, rates.cols() + 1);
        rates.rightCols(1) = found;
    }
    require(
        rates.cols() > 0, {},
        "the rates of the model are not finite in any of {} uniform states; expected functions that are finite about "
        "the references",
        64 * n);
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
    for (int round = 0; round < 3; ++round) {  // states of one size, and rates of one size
        for (Eigen::Index k = 0; k < rates.cols(); ++k)
            if (const double size = rates.col(k).cwiseAbs().maxCoeff(); size > 0.0) rates.col(k) /= size;
        for (Eigen::Index k = 0; k < n; ++k)
            if (const double size = rates.row(k).cwiseAbs().maxCoeff(); size > 0.0) {
                rates.row(k) /= size;
                scale(k) /= size;
            }
    }
    Eigen::MatrixXd combinations = Eigen::MatrixXd::Zero(0, n);
    const auto add = [&](const Eigen::VectorXd& row) {
        combinations.conservativeResize(combinations.rows() + 1, Eigen::NoChange);
        combinations.bottomRows(1) = row.transpose();
    };
    const numerics::DenseSvd<Eigen::MatrixXd> svd = numerics::dense_svd(rates);
    for (Eigen::Index k = 0; k < n; ++k) {
        const bool vanishes = k >= svd.values.size() || svd.values(0) == 0.0 || svd.values(k) <= 1e-12 * svd.values(0);
        if (vanishes) add(scale.asDiagonal() * svd.left.col(k));
    }
    if (combinations.rows() == 0) return combinations;
    return numerics::orthogonal_factor(combinations.transpose()).leftCols(combinations.rows()).transpose();
}

}  // namespace drover::theory
