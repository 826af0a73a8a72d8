// theory/uniform_equations.hpp: the equations of uniform states, with the conserved means given.
#pragma once
#include <cstdint>
#include <optional>
#include <random>

#include "drover/theory/theory.hpp"

namespace drover::theory {

/// Numbers that are the same on every machine.
class Numbers {
public:
    double unit() { return static_cast<double>(engine_()) * 0x1p-32; }
    double between(double low, double high) { return low + (high - low) * unit(); }

private:
    std::mt19937 engine_{20150622};
};

/// Sum of the squares of the components of all fields that turn.
double squared_order(const model::Model& model, const model::UniformState& state);
/// Sum of the squares of the differences of all components.
double squared_distance(const model::UniformState& a, const model::UniformState& b);
/// The fields of these components.
std::vector<int> fields_of(const model::Equations& equations, const std::vector<int>& components);
/// Whether a field with a spin is not 0.
bool has_order(const model::Model& model, const model::UniformState& state);

/// Rates and constraints of the components with a rate.
class UniformEquations {
public:
    using Vector = Eigen::VectorXd;
    using Matrix = Eigen::MatrixXd;

    UniformEquations(const model::Equations& equations, const model::UniformState& means);
    const model::Equations& equations() const { return equations_; }
    const model::Model& model() const { return equations_.model(); }
    /// The field of each component.
    const std::vector<model::PlacedField>& places() const { return places_; }
    const model::UniformState& means() const { return means_; }
    const Vector& reference() const { return reference_; }
    /// Whether turned copies of every state are equivalent, for uniform states and waves.
    bool turns_freely() const { return turns_freely_; }
    Eigen::Index count() const { return reference_.size(); }

    Vector of_state(const model::UniformState& all) const;
    model::UniformState state_of(const Vector& z) const;
    Vector turned(const Vector& z, double angle) const;
    /// The change of a state when it is turned.
    Vector turn_of(const Vector& z) const;

    /// Rates, then how far the conserved means are from those given.
    Vector values(const Vector& z) const;
    /// Not finite where the rates have no finite derivative.
    Matrix jacobian(const Vector& z) const;
    /// What values() and jacobian() have cost: a Jacobian with its decomposition as ten rates for each component.
    std::int64_t evaluations() const { return evaluations_; }
    /// Sizes of the parts of values(); j: the Jacobian there.
    Vector sizes(const Vector& z, const Matrix& j) const;
    /// |values| relative to them.
    Vector relative(const Vector& z, const Matrix& j) const;
    static Vector relative(const Vector& values, const Vector& sizes);

private:
    bool commutes_with_turns() const;
    bool is_well_conditioned(const model::UniformState& state, bool with_waves, Numbers& numbers) const;
    std::optional<bool> are_turned(const model::UniformState& one, const model::UniformState& other, double angle,
                                   bool with_waves) const;
    bool waves_are_turned(const model::LinearisedAt& from, const model::LinearisedAt& to, double angle) const;

    model::Equations equations_;
    model::UniformState means_;
    std::vector<model::PlacedField> places_;
    Matrix conserved_;
    Vector reference_;
    bool turns_freely_ = false;
    mutable std::int64_t evaluations_ = 0;
};

}  // namespace drover::theory
