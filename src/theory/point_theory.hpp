// theory/point_theory.hpp: rates of uniform states and waves about them, of models that differ in a few numbers.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "drover/model/linearised_at.hpp"
#include "drover/theory/theory.hpp"

namespace drover::theory {

/// What stability needs of one model.  Copies share what is compiled.
class PointTheory {
public:
    explicit PointTheory(const model::Equations& equations)
        : equations_(equations), unknowns_(equations.state_components()) {}
    /// Of right sides alone, where every field has a rate: the same with its terms times factors, and with these left
    /// sides.  solver: the equations with masses and balances, for a search of all states.
    PointTheory(const model::Equations& right_sides, std::vector<double> factors,
                std::function<model::LeftSides(const model::UniformState&)> left,
                std::function<model::Equations()> solver);

    /// The same with its terms times factors more, of equations that a solver gives.
    PointTheory scaled(const std::vector<double>& more, std::function<model::Equations()> solver) const;

    const model::Equations& equations() const { return equations_; }
    /// The equations with masses and balances.
    model::Equations solver() const { return solver_ ? solver_() : equations_; }
    /// The components that a uniform state has to find; the others follow from them.
    const std::vector<int>& unknowns() const { return unknowns_; }
    /// Their rates, which masses may multiply.
    Eigen::VectorXd rates(const model::UniformState& at) const;
    /// Throws as LinearisedAt.
    model::LinearisedAt linearised(const model::UniformState& about) const;
    /// The derivatives of rates() in the unknowns.
    Eigen::MatrixXd slopes(const model::LinearisedAt& at) const;

private:
    model::Equations equations_;
    std::vector<int> unknowns_;
    std::vector<double> factors_;
    std::function<model::LeftSides(const model::UniformState&)> left_;
    std::function<model::Equations()> solver_;
};

/// The first component of the order: of the first field that turns and has a rate; -1: there is none.
int order_component(const model::Equations& equations);

/// A uniform state of one point, with its linearisation.
struct PointState {
    model::UniformState values;
    model::LinearisedAt linear;
};

/// How ordered states are found.
struct OrderSearch {
    /// By the whole search of stationary_states() at every point: where the equations name a direction in another way
    /// than by a uniform source.
    bool is_whole = false;
    bool turns_freely = false;  ///< turned copies of every state are equivalent, without a source of the order
};
/// That of a model, and of others that differ from it in values of coefficients alone.
OrderSearch order_search(const model::Equations& equations);

/// The isotropic state with these conserved means: no order, and no source of it.  Nothing where there is none, or
/// where rates are not finite.  Where densities that are not conserved have several values, the ones next to `means`.
std::optional<PointState> isotropic_state(const PointTheory& theory, const model::UniformState& means);

/// The state of the largest order.  Along one axis, that of the source of the order or x, the order has one unknown:
/// Newton's method for its square from the side of large order, which ends in the largest root where the rate falls
/// with the order; or the whole search.  Nothing where there is none.
std::optional<PointState> ordered_state(const PointTheory& theory, const model::UniformState& means,
                                        const OrderSearch& search = {});

/// The isotropic state and the ordered one where these are all: no source of the order, a rate of it that is cubic
/// along its axis, and other fields that follow it in one way alone, which the caller knows.  Nothing where that is not
/// so or not sure.
std::optional<StationaryStates> states_of_cubic_order(const PointTheory& theory, const model::UniformState& means);

/// The rate at which order decays in an isotropic state, after elimination of the fields that turn as it does; < 0: it
/// grows.  NaN without a field that turns, and where such a field does not decay by itself.
double relaxation_of_order(const PointTheory& theory, const PointState& isotropic);

}  // namespace drover::theory
