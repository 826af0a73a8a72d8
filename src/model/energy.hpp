// model/energy.hpp: the energies of the fields of a model, and the power of every term.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/model/equations.hpp"
#include "drover/numerics/field.hpp"

namespace drover::model {

/// The integral of m F^2/2 over the cell, of a field F with a rate and the mass m: 1 unless it has one.  That of a
/// complex field has both of its parts.
struct Energy {
    std::string name;                 ///< in observables, model::Observed: that of the field, unless it has another
    std::vector<std::size_t> fields;  ///< one, or the two parts of a complex field
};
/// Of all fields with a rate that have one, in the order of their observables.
std::vector<Energy> energies_of(const Equations& equations);

/// Energies and powers of one state, in the order of energies_of().  The time derivative of an energy is the sum of its
/// powers, for the modes that the grid keeps and without noise.
struct EnergyBudget {
    std::vector<double> energies;             ///< [unit of the mass times that of F^2 mm^2]
    std::vector<std::vector<double>> powers;  ///< [energy][term], per second
};

/// Measures the energy budget.  Evaluates each term separately, with the linear part and right-hand side of the solver;
/// fields in balance follow from their complete balance.
class EnergyMeter {
public:
    /// kept_degree: as of Equations::system().  Throws an input Error at a mass that depends on time, or on a field
    /// without a rate.
    EnergyMeter(const Equations& equations, const numerics::Grid& grid, int kept_degree, Threads& threads);
    ~EnergyMeter();

    EnergyBudget measure(double t, const numerics::Spectra& state) const;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// The terms that have powers, in their order: those of fields with a rate, by their number in Equations::terms().
std::vector<std::size_t> terms_with_power(const Equations& equations);

}  // namespace drover::model
