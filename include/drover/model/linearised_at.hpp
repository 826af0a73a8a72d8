// model/linearised_at.hpp: the linearisation of equations about one uniform state, as a polynomial in the wavevector.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "drover/model/equations.hpp"

namespace drover::model {

/// The direction of a uniform state [rad]: that of the first field with a spin m >= 1 and a value, from the x axis, in
/// (-pi/m, pi/m]; 0 without one.
double direction_of(const Model& model, const UniformState& state);

/// Prepared once, a symbol costs one sum of small matrices.
class LinearisedAt {
public:
    /// Fields in balance take the values that follow from the others.  Throws an input Error as Equations::symbol: for
    /// a term that depends on position or time, for a state of another size, where a derivative is not finite.
    LinearisedAt(const Equations& equations, const UniformState& about);

    const Equations& equations() const { return equations_; }
    const UniformState& about() const { return about_; }

    /// The symbol of the components with a rate, in the order of Equations::state_components(); fields in balance are
    /// eliminated.
    Symbol symbol(const numerics::Wavevector& q) const;
    /// The deviations of all components, fields in balance included, from those with a rate: one row each.
    Symbol all_components(const numerics::Wavevector& q) const;
    /// The linearisation of all equations without elimination; rows of balances that are solved at every point are 0.
    Symbol whole(const numerics::Wavevector& q) const;
    /// Strengths of the noise of the components with a rate: <f f^H> = noise delta(t - t') per area.
    Symbol noise(const numerics::Wavevector& q) const;

    /// The components that follow from linear balances.
    const std::vector<int>& held_components() const { return held_; }

    /// The direction from which the angles of waves are measured [rad]: direction_of(about()).
    double direction() const { return direction_; }
    /// Whether all directions of waves are equivalent.
    bool is_isotropic() const { return is_isotropic_; }
    /// The wavevector at an angle from the direction of the state.
    numerics::Wavevector wavevector(double q, double angle) const;
    /// A matrix between all components at q with its fields resolved along and across q: of a field of spin m the first
    /// part is cos(m theta) F_1 + sin(m theta) F_2, the second -sin(m theta) F_1 + cos(m theta) F_2, where theta is the
    /// angle of q (0 at q = 0).
    Symbol along_and_across(const Symbol& of_components, const numerics::Wavevector& q) const;

    /// factors (i q_x)^x (i q_y)^y: a summand of whole().
    struct Power {
        int x = 0, y = 0;
        Eigen::MatrixXd factors;
    };
    const std::vector<Power>& powers() const { return powers_; }
    /// The same of a state in which the fields in balance are completed, without the rest of a linearisation, and with
    /// a factor for each term.
    static std::vector<Power> powers_of(const Equations& equations, const UniformState& about,
                                        const std::vector<double>& factors);

private:
    bool commutes_with_turns() const;

    Equations equations_;
    UniformState about_;
    std::vector<int> held_;
    std::vector<Power> powers_, substitutes_;
    double direction_ = 0.0;
    bool is_isotropic_ = false;
};

}  // namespace drover::model
