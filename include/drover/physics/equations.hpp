// physics/equations.hpp: the equations of rods and beads, as the model layer has them, and their linearisations.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "drover/model/linearised_at.hpp"
#include "drover/numerics/grid.hpp"
#include "drover/physics/compiled_model.hpp"
#include "drover/physics/symbol.hpp"

namespace drover::physics {

/// A compiled model with its equations: those of rod_bead.toml and the terms of the scene, without what is zero.
struct Equations : CompiledModel {
    explicit Equations(const Model& model);  ///< throws as check()
    /// Shares the tables of `like` where their data are equal, and what was compiled where constants alone differ:
    /// saves time when many models differ in few values.
    Equations(const Model& model, const Equations& like);

    /// The same with some terms only.
    Equations only(const std::vector<std::string>& names) const;

    /// d_t of all fields but the velocity, whose rate is the force on the beads: slaved or not, not divided by m rho.
    /// The constants in it may be those of the model with which it is shared: use linearised() and uniform_forces().
    const model::Equations& forces() const { return *forces_; }
    /// The rates of forces() in a uniform state: of all its components.
    Eigen::VectorXd uniform_forces(const UniformPoint& at) const;
    /// One for each of forces().terms(): the key of its coefficient, or terms[n] for a text of the scene.
    const std::vector<std::string>& terms() const { return terms_; }
    /// What is integrated: a velocity has inertia or is in balance.  The linear part is taken about this state.
    model::Equations solver(const Reference& about) const;

    /// The first component of each field in forces() and solver(), by FieldIndex; -1: not there.
    int component(int field) const { return components_[static_cast<std::size_t>(field)]; }
    bool is_force(std::size_t term) const;

    /// The linearised equations about a uniform state, stationary or not; its components are those of forces().  Throws
    /// an input Error for a term that depends on position or time, because no uniform state satisfies it.
    std::shared_ptr<const model::LinearisedAt> linearised(const UniformPoint& about) const;

private:
    struct Cache;
    void compile(const std::vector<std::string>* only);
    std::shared_ptr<const model::Equations> forces_;
    std::vector<std::string> terms_;
    std::vector<double> factors_;  ///< of the terms in forces_
    std::vector<std::string> only_;
    bool has_all_ = true;
    std::array<int, FieldIndex::count> components_{};
    std::shared_ptr<Cache> cache_;
};

/// Throws an input Error, with its location, for a model with invalid parameters or text terms.
void check(const Model& model, const LocationOf& location_of = no_location);

/// What Equations::terms() are: "-a p", the texts of the scene and its functions.
std::vector<std::string> written_terms(const Equations& equations);

/// Whether a slaved velocity is a nonlinear function of the fields: some force on the beads is evaluated on the grid.
bool has_pointwise_velocity(const Equations& equations);

}  // namespace drover::physics
