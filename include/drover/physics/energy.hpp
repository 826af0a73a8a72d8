// physics/energy.hpp: the energy of the beads and of the order, and the power of every term.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

/// Energies and powers of one state.  Kinetic energy: integral of m rho v^2/2 if the velocity is dynamic; energy of the
/// order: integral of p^2/2.  The time derivative of each is the sum of its powers, for the modes that the grid keeps
/// and without noise.
struct EnergyBudget {
    double kinetic = 0.0;                ///< [mg mm^2/s^2]
    double order = 0.0;                  ///< [[p]^2 mm^2]
    std::vector<double> kinetic_powers;  ///< of each term [mg mm^2/s^3]
    std::vector<double> order_powers;    ///< of each term [[p]^2 mm^2/s]
};

/// Measures the energy budget.  Evaluates each term separately with the linear part and right-hand side of the solver.
class EnergyMeter {
public:
    EnergyMeter(const Equations& equations, const numerics::Grid& grid, const Dealiasing& dealiasing, Threads& threads);
    ~EnergyMeter();

    std::vector<std::string> terms() const;  ///< names, in the order of the powers
    EnergyBudget measure(double t, const numerics::Spectra& state) const;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace drover::physics
