// calibrate/counterterm.hpp: the saturation of the order without that of the fluctuations of independent rods.
#pragma once
#include "numerics/steppers/kept_modes.hpp"
#include "physics/model_values.hpp"

namespace drover::calibrate {

/// 2 b s [1/s], by which -b |p|^2 p slows the growth of order in fields with noise, s the variance of p of independent
/// rods in the kept waves but q = 0: the sum of Delta/(2 A) [1/(a + K q^2 + K4 q^4)] over the two components, K = K3
/// across q and K3 + K1 along it, a without contacts.  Each wave of few rods has that much |p|^2, though none of them
/// turns less for it.  First order in b, by the means of products of Gaussian fluctuations.  Throws an input Error at
/// `where` unless a, b and Delta are positive, and a from no table.
double counterterm(const physics::ModelValues& model, const numerics::KeptGrid& on, const SourceLocation& where);

/// The same over a: by how much of itself the decay of order is too large in fields; 0 where nothing saturates.
double part_of_waves(const physics::ModelValues& model, const numerics::KeptGrid& on);

/// Makes order grow faster by so much.
void add_counterterm(double rate, physics::ModelValues& model);

}  // namespace drover::calibrate
