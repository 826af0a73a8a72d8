// calibrate/closures.hpp: what follows from measured coefficients at one state: one list, for tables and for the models of fields.
#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"

namespace drover::calibrate {

/// Rows of a table that others follow from.
enum Input {
    bead_area,
    rod_area,
    bead_mass,
    relaxation,
    weathercock,
    drag,
    response,
    speed,
    damping,
    viscosity,
    stiffness
};
constexpr std::size_t input_count = 11;
const char* row_name(Input input);

/// The numbers that one closure needs, at one state; others are zero.
struct Measured {
    double bead_fraction = 0.0, rod_fraction = 0.0;
    std::array<double, input_count> numbers{}, errors{};

    double operator[](Input input) const { return numbers[input]; }
    double bead_density() const { return bead_fraction / numbers[bead_area]; }
    double rod_density() const { return rod_fraction / numbers[rod_area]; }
    double mass_density() const { return numbers[bead_mass] * bead_density(); }
    double friction() const { return mass_density() / numbers[response]; }
    /// g = lambda_s alpha/(Gamma D_r); lambda_s is 2 lambda.
    double alignment() const { return 2.0 * numbers[weathercock] * numbers[drag] / numbers[relaxation]; }
};

/// Whether a coefficient is to be taken no less than its error: response_time alone.  No flow follows in less than no time, and one that follows faster than was
/// resolved has that for a bound.
inline bool is_below_error(Input input, double value, double error) { return input == response && value < error; }

/// Why a coefficient cannot be divided by: it lies within three errors of zero.  "" when it can.
std::string divisor_refusal(Input input, double value, double error);

/// Gives a closure one of the numbers that it needs.
void put(Measured& at, Input input, double value, double error);

using Formula = std::function<double(const Measured&)>;

struct Closure {
    std::string row = {};  ///< of a table, where p = sigma u P; "" for none, or one that an assay or the setup gives
    std::string key = {};  ///< of a model; "" for none
    std::string unit = {}, formula = {};                  ///< of the row
    Origin origin = Origin::set;                          ///< unless what it follows from is less
    std::vector<Input> of = {};                           ///< what it follows from
    std::vector<Input> under = {};                        ///< those of them that it is divided by
    double order_power = 0.0;                             ///< of p/P, by which it is multiplied when p is not P
    Formula value = [](const Measured&) { return 0.0; };  ///< for p = P
};

/// The closure for a p that is P times this scale, which follows from these; one that does not know of p, or is zero, as it is.
Closure scaled(Closure closure, const std::vector<Input>& scale_of, const Formula& scale);

/// Those of a model in the order of a scene, and the others.
const std::vector<Closure>& closures();

/// The formula and its error to first order in those of `of`, taken as independent: half of what lies between `part` of an error to either side.
Uncertain evaluated(Measured at, const std::vector<Input>& of, const Formula& value, double part = 1e-3);

}  // namespace drover::calibrate
