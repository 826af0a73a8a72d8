// model/linearised_at.hpp: the linearisation of equations about one uniform state, as a polynomial in the wavevector.
#pragma once
#include <Eigen/Core>
#include <map>
#include <vector>

#include "drover/model/equations.hpp"

namespace drover::model {

/// The first components of the fields with a spin, in the order in which they are drawn: the first field is the order.
std::vector<int> turning_components(const Model& model);

/// The direction of a uniform state [rad]: that of the first of turning_components() with a value, of a spin m >= 1,
/// from the x axis, in (-pi/m, pi/m]; 0 without one.  Throws an input Error for a state of another size.
double direction_of(const Model& model, const UniformState& state);

/// Left-hand sides that replace those of the equations: mass_density d_t F = right-hand side, with noise on d_t F.
struct LeftSides {
    std::vector<double> factors = {};  ///< of each term; empty: 1
    Eigen::VectorXd mass_density;      ///< of each component; 0: in balance
    Eigen::MatrixXd slopes = {};       ///< of `mass_density` in the components; empty: 0
    Eigen::VectorXd noise,
        flux_noise;          ///< strengths of white noise, and of conserved noise; both empty: as in the equations
    double direction = 0.0;  ///< from which the angles of waves are measured [rad]
};

/// Prepared once, a symbol costs one sum of small matrices.  One that was moved from can only be assigned to or
/// destroyed.
class LinearisedAt {
public:
    /// Fields in balance take the values that follow from the others.  Throws an input Error as Equations::symbol: for
    /// a term that depends on position or time, for a state of another size, where a derivative is not finite.
    LinearisedAt(const Equations& equations, const UniformState& about);
    /// Of equations that have rates alone, with other left sides.  Throws an input Error for left sides of another
    /// number of components.
    LinearisedAt(const Equations& equations, const UniformState& about, LeftSides left);

    const Equations& equations() const { return equations_; }
    const UniformState& about() const { return about_; }
    /// The components with a rate, in the order of the fields.
    const std::vector<int>& state_components() const { return state_; }
    /// What multiplies d/dt of each component; 0: in balance.
    const Eigen::VectorXd& mass_density() const { return left_.mass_density; }

    /// The symbol of state_components(); fields in balance are eliminated.  A divergence-free field has its part across
    /// q alone, except at q = 0.
    Symbol symbol(const numerics::Wavevector& q) const;
    /// The deviations of all components, fields in balance included, from those of symbol(): one row each.
    Symbol all_components(const numerics::Wavevector& q) const;
    /// The linearisation of all right sides without elimination; rows of balances that are solved at every point are 0.
    Symbol whole(const numerics::Wavevector& q) const;
    /// The part of one of Equations::terms() in whole().  Throws an input Error for a number that no term has.
    Symbol term_symbol(std::size_t term, const numerics::Wavevector& q) const;
    /// Strengths of the noise of the rows of symbol(): <f f^H> = noise delta(t - t') per area.
    Symbol noise(const numerics::Wavevector& q) const;

    /// Weights of the forces on all components that give the same sum as `of_rates`, weights of the rates of symbol();
    /// forces on fields in balance act through these fields.  Throws an input Error for another number of weights.
    Eigen::RowVectorXcd of_forces(const Eigen::RowVectorXcd& of_rates, const numerics::Wavevector& q) const;

    /// Whether some field has no divergence, so that waves in the limit of small q are not those at q = 0.
    bool has_solenoidal() const { return has_solenoidal_; }

    /// The direction from which the angles of waves are measured [rad]: direction_of(about()), or as given.
    double direction() const { return left_.direction; }
    /// Whether all directions of waves are equivalent: tried at some.
    bool is_isotropic() const;
    /// Whether a reflection in the line of the direction maps waves to waves: tried at some.
    bool is_mirrored() const;
    /// The wavevector at an angle from the direction of the state.
    numerics::Wavevector wavevector(double q, double angle) const;
    /// A matrix between all components at q with its fields resolved along and across q: of a field of spin m the first
    /// part is cos(m theta) F_1 + sin(m theta) F_2, the second -sin(m theta) F_1 + cos(m theta) F_2, where theta is the
    /// angle of q (0 at q = 0).  Throws an input Error for a matrix of another size.
    Symbol along_and_across(const Symbol& of_components, const numerics::Wavevector& q) const;

    /// factors (i q_x)^x (i q_y)^y: a summand of whole().
    struct Power {
        int x = 0, y = 0;
        Eigen::MatrixXd factors;
    };
    const std::vector<Power>& powers() const { return powers_; }
    /// The factors of (i q)^n in whole(), for each n, of waves at an angle from the x axis.
    std::map<int, Eigen::MatrixXd> factors_by_order(double angle) const;
    /// For each n, the sum of the sizes of these factors in all directions, between the fields of two components.
    std::map<int, Eigen::MatrixXd> sizes_by_order() const;
    /// Components with a rate or in a linear balance, in the order of the fields: those of factors().
    const std::vector<int>& members() const { return members_; }
    /// The members() of waves at an angle from the x axis, one column each: of a divergence-free field the part across.
    Eigen::MatrixXd parts_across(double angle) const;
    /// The factors of (i q_x)^x (i q_y)^y in whole(), between members().
    Eigen::MatrixXd factors(int x, int y) const;

private:
    /// The lists of components at one q: without the parts along q of divergence-free fields.
    struct Parts {
        std::vector<int> state, held, free;
    };
    const Parts& parts_at(const numerics::Wavevector& q) const { return q.x == 0.0 && q.y == 0.0 ? uniform_ : waves_; }
    void set_parts(std::vector<int> free);
    /// From x and y to along and across q, of divergence-free fields alone.
    Eigen::MatrixXd turn_of(const numerics::Wavevector& q) const;
    Symbol resolved(const Symbol& m, const numerics::Wavevector& q) const;
    Symbol eliminated(const numerics::Wavevector& q, Symbol* balance = nullptr) const;

    Equations equations_;
    UniformState about_;
    LeftSides left_;
    std::vector<int> state_, held_, members_;
    Parts uniform_, waves_;  ///< free: components that determine all others
    bool has_solenoidal_ = false;
    std::vector<Power> powers_, substitutes_;
    std::vector<Power> rates_;  ///< powers_ divided by `mass_density`, and what its changes add
};

}  // namespace drover::model
