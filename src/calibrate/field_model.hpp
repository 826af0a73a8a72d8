// calibrate/field_model.hpp: coefficients of the equations from a table at two area fractions, their mean field, and
// the numbers that a model leaves out.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "calibrate/table.hpp"
#include "physics/model_values.hpp"

namespace drover::calibrate {

/// A point of a table.
struct StatePoint {
    double bead_fraction = 0.0, rod_fraction = 0.0;
    std::size_t varied = 0;
    numerics::Outside outside = numerics::Outside::refuse;
};

/// What p is in the equations: the mean orientation P of the rods, with J = u sigma P; or sigma P, with J = u p.
/// (The current p = sigma u P of the paper's Methods would need powers of sigma u; calibrated scenes keep u.)
enum class OrderKind { orientation, density };

/// A number of the model and its origin.
struct FieldNumber {
    Uncertain number;
    Origin origin = Origin::set;
};

/// Numbers of the model:
///     rho = Phi_b/(area of a bead), sigma = Phi_r/(area of a rod), J = u sigma P,
///     Gamma = m rho/tau, alpha = (alpha/Gamma) Gamma, alpha_3 = (alpha_3/Gamma) Gamma, eta = [eta/(m rho)] m rho, E,
///     a, c and lambda as measured (alpha_3 and c = 0 in a table without them);
///     a tau below its error is replaced by its error (the flow responds faster than was resolved), and Gamma and alpha
///     then count as closures;
///     K3 = u^2/(16 a), B = u/(2 sigma), Delta = a/sigma: independent rods (closures), D_r being a;
///     b such that the uniform flock has the mean-field order of order_of_alignment() in calibrate/alignment.hpp, g
///     being (lambda_s alpha/Gamma + 2 c sigma)/a and g3 being lambda_s alpha_3/(Gamma a);
///     w = 3 g u/16 (in P), of the same expansion about the onset; A, F, zeta and K1 zero.
/// The error is half of the distance from 16 to 84 % over redrawn_tables().  Throws an input Error for missing entries
/// and for points outside the table.
std::vector<FieldNumber> field_numbers(const Table& table, const std::vector<std::string>& keys,
                                       const StatePoint& point, OrderKind kind);
inline FieldNumber field_number(const Table& table, const std::string& key, const StatePoint& point, OrderKind kind) {
    return field_numbers(table, {key}, point, kind).front();
}
/// The values alone, also where a divisor is not significantly different from 0.
std::vector<double> field_values(const Table& table, const std::vector<std::string>& keys, const StatePoint& point,
                                 OrderKind kind);

/// The coefficients that may depend on densities, at the nodes of the table and at three positions between any two, so
/// that splines through them are those of field_numbers() between nodes too; the relaxation rate is a - c sigma.
/// Without errors, which the nodes share: see redrawn_models().
physics::TableData density_table(const Table& table, const StatePoint& point, OrderKind kind);

/// Mean-field prediction for a uniform system with these coefficients; errors as those of field_numbers().
struct MeanField {
    Uncertain alignment;             ///< g
    Uncertain alignment_cubic;       ///< g3, of a flow that is not linear in the order
    Uncertain effective_relaxation;  ///< abar = a - c sigma - lambda alpha/Gamma [1/s]
    Uncertain order;                 ///< P
    Uncertain bead_velocity;         ///< (alpha + alpha_3 P^2) P/Gamma [mm/s]
    Uncertain response_time;         ///< tau of the flow [s], at least its error
};
MeanField mean_field(const Table& table, const StatePoint& point);

/// Mean-field prediction for the rods of one cell, of which there are few; see order_of_rods().
struct CellPrediction {
    int rods = 0;
    Uncertain alignment;     ///< g; a flock of infinitely many rods for g > 2
    double order = 0.0;      ///< <|P|> of these rods
    double low = 0.0;        ///< <|P|> one error of g below, g3 as it is
    double high = 0.0;       ///< <|P|> one error of g above
    double deviation = 0.0;  ///< standard deviation of |P| in time
    double line = 0.0;       ///< <|P|> of these rods at g = 2, the onset unless g3 > 1
};
CellPrediction predict_cell(const Table& table, const StatePoint& point, double cell_area);

/// What a table gave to a model: "drag.coefficient", and in words "measured, 3.1 +- 0.2".
struct FilledNumber {
    std::string key, origin;
};

/// Which keys a table is to provide: those that it has, the form has a field for, and `is_given` denies.  With `local`
/// coefficients also "table", the values at all its nodes.
std::vector<std::string> missing_keys(const physics::ModelValues& model, bool local,
                                      const std::function<bool(const std::string& key)>& is_given);

/// Fills these keys of a model.  Throws an input Error for missing values, and for values out of the range of the key.
std::vector<FilledNumber> fill_model(const Table& table, const StatePoint& point, const std::vector<std::string>& keys,
                                     physics::ModelValues& model);

/// The model with these keys filled from tables redrawn within their errors, each with all that follows from it.  A
/// table with a number out of the range of its key is left out, so there may be fewer than `count`.
std::vector<physics::ModelValues> redrawn_models(const Table& table, const StatePoint& point,
                                                 const std::vector<std::string>& keys,
                                                 const physics::ModelValues& model, int count);

/// What the mean field of the table expects.
std::vector<std::string> expected_texts(const Table& table, const StatePoint& point);

}  // namespace drover::calibrate
