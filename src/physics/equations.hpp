// physics/equations.hpp: the equations of a model of a model file, as the model layer has them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "drover/numerics/grid.hpp"
#include "physics/compiled_model.hpp"
#include "theory/point_theory.hpp"

namespace drover::physics {

/// A compiled model with its equations: those of the model file and the terms of the scene, without what is zero.
struct Equations : CompiledModel {
    explicit Equations(const ModelValues& model) : Equations(CompiledModel(model)) {}
    /// Throws an input Error, with its location, for a text that changes what is conserved, for a balance without drag,
    /// for products beside derivatives of its field in one, and for texts that a balance cannot have.
    explicit Equations(CompiledModel compiled, const Locate& locate = no_location);
    /// Shares the tables of `like` where their data are equal, and what was compiled where constants alone differ:
    /// saves time when many models differ in few values.
    Equations(const ModelValues& model, const Equations& like);

    /// d_t of all fields, where a mass is 1 and a field in balance has the sum of its terms as rate.  The constants in
    /// it may be those of the model with which it is shared: use theory().
    const model::Equations& right_sides() const { return *right_sides_; }
    /// Of uniform states and waves, by right_sides().  Throws an input Error for a function that this program does not
    /// have.
    theory::PointTheory theory() const;
    static theory::PointTheory theory(const std::shared_ptr<const Equations>& equations);
    /// One for each of right_sides().terms(): the key of its coefficient, or terms[n] for a text of the scene.
    const std::vector<std::string>& terms() const { return terms_; }
    /// What is integrated, with masses and balances.  The linear part is taken about these densities, and the other
    /// fields at 0.
    model::Equations solver(const Densities& about) const;
    model::Equations solver() const { return solver(mean_densities(model)); }  ///< about the means of the model

    /// The first component of a field in right_sides() and solver(), by its symbol; -1: not there.
    int component(const std::string& symbol) const;
    bool is_of(std::size_t term, const FieldRow& field) const;

private:
    struct Cache;
    void compile(const Locate& locate);
    void check_terms(const Locate& locate) const;
    std::shared_ptr<const model::Equations> right_sides_;
    std::vector<std::string> terms_;
    std::vector<double> factors_;  ///< of the terms in right_sides_
    std::shared_ptr<Cache> cache_;
};

/// What Equations::terms() are: "-a p", the texts of the scene and its functions.
std::vector<std::string> written_terms(const Equations& equations);

/// Compiles a model, with the functions and the solver that it needs.  Throws as CompiledModel and Equations, for a
/// function that this program does not have, and for what cannot be integrated.
Equations check(const ModelValues& model, const Locate& locate = no_location);

/// The field of the file whose balance is a nonlinear function of the fields: some of its terms are evaluated on the
/// grid; nullptr: none.
const FieldRow* pointwise_balance(const Equations& equations);

}  // namespace drover::physics
