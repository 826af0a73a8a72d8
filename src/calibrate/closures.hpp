// calibrate/closures.hpp: formulas for what follows from measured coefficients, shared by tables and calibrated models.
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "calibrate/table.hpp"

namespace drover::calibrate {

/// lambda_s/lambda: in two dimensions the average of (1 - nn).v over rod directions is v/2.
inline constexpr double single_rod_factor = 2.0;

/// Rows of a table from which others follow.
enum Input {
    bead_area,
    rod_area,
    bead_mass,
    relaxation,
    weathercock,
    drag,
    cubic,
    response,
    speed,
    damping,
    viscosity,
    stiffness,
    contact,
    scattered,
    scattered_second,
    scattered_excitation,
    scattered_saturation
};
constexpr auto names_of(Input) {
    return std::array{"bead_area",
                      "rod_area",
                      "bead_mass",
                      "relaxation_rate",
                      "weathercock",
                      "drag",
                      "drag_cubic",
                      "response_time",
                      "propulsion",
                      "damping_rate",
                      "viscosity_kinematic",
                      "stiffness",
                      "contact_alignment",
                      "contact_scattering",
                      "scattering_second",
                      "scattering_excitation",
                      "scattering_saturation"};
}
constexpr std::size_t input_count = names_of(Input{}).size();

/// The numbers that one closure needs at one point; others are zero.
struct ClosureNumbers {
    double bead_fraction = 0.0, rod_fraction = 0.0;
    std::array<double, input_count> numbers{}, errors{};

    double operator[](Input input) const { return numbers[input]; }
    double bead_density() const { return bead_fraction / numbers[bead_area]; }
    double rod_density() const { return rod_fraction / numbers[rod_area]; }
    double mass_density() const { return numbers[bead_mass] * bead_density(); }
    double friction() const { return mass_density() / numbers[response]; }
    /// g_flow = lambda_s alpha/(Gamma D_r), of rods that align with the flow they drive; lambda_s is 2 lambda.
    double alignment_by_flow() const {
        return single_rod_factor * numbers[weathercock] * numbers[drag] / numbers[relaxation];
    }
    /// g3 = lambda_s alpha_3/(Gamma D_r), of a flow that is not linear in the order.
    double alignment_cubic() const {
        return single_rod_factor * numbers[weathercock] * numbers[cubic] / numbers[relaxation];
    }
    /// g = g_flow + 2 c sigma/D_r, with contacts; c of many rods, or of pairs.
    double alignment(Input c = contact) const {
        return alignment_by_flow() + 2.0 * numbers[c] * rod_density() / numbers[relaxation];
    }
    /// Of collisions of pairs and the flow: rates of psi_2, of its excitation by psi_1^2, and s in
    /// d_t psi_1 = -s psi_2 psi_1*.  0 where psi_2 does not decay: what is divided by it then has no bound.
    double second_rate() const {
        return std::max(4.0 * numbers[relaxation] - numbers[scattered_second] * rod_density(), 0.0);
    }
    double excitation() const {
        return numbers[relaxation] * alignment_by_flow() + numbers[scattered_excitation] * rod_density();
    }
    double reaction() const {
        return 0.5 * numbers[relaxation] * alignment_by_flow() + numbers[scattered_saturation] * rod_density();
    }
};

/// Whether a coefficient is replaced by its error because it is smaller: response_time alone.  A response time is
/// positive, and its error bounds a response that is faster than the resolution.
inline bool is_below_error(Input input, double value, double error) { return input == response && value < error; }

/// Whether a coefficient is zero in a table that has no row for it: those that are newer than some tables.
inline bool may_be_absent(Input input) { return input == contact || input == cubic; }

/// Why a coefficient cannot be a divisor (it lies within three errors of zero); "" if it can.
std::string divisor_refusal(Input input, double value, double error);

/// Sets one of the inputs of a closure.
void put(ClosureNumbers& at, Input input, double value, double error);

using Formula = std::function<double(const ClosureNumbers&)>;

struct Closure {
    std::string row = {};  ///< of a table, for p = sigma u P; "" if there is none, or an assay or the setup gives it
    std::string key = {};  ///< of a model; "" if there is none
    std::string unit = {}, formula = {};  ///< of the row
    Origin origin = Origin::set;          ///< unless an input has a lesser origin
    std::vector<Input> of = {};           ///< its inputs
    std::vector<Input> under = {};        ///< those inputs that are divisors
    double order_power = 0.0;             ///< power of p/P by which it is multiplied if p is not P
    Formula value = [](const ClosureNumbers&) { return 0.0; };  ///< for p = P
};

/// The closure for p = P times this scale, which has these inputs.  Unchanged if it does not depend on p, or is zero.
Closure scaled(Closure closure, const std::vector<Input>& scale_of, const Formula& scale);

/// alpha/Gamma of the straight line through the orders of a flock, of the drag assay; it gives c where drag is a slope
/// at P = 0.
inline constexpr const char* straight_drag = "drag_straight";

/// Rows of the assays drag and alignment from which c follows, as far as they were measured.
const std::vector<std::string>& contact_rows();
/// Whether c follows from the rows of this table.
bool has_contact_rows(const Table& table);

/// Adds the row contact_alignment, c at each area fraction of beads, and the closure test alignment_excess, from the
/// assays drag and alignment; c = 0 if the table has neither.  The error of c is that alone which the rows do not have:
/// by which its measurements disagree.
void add_contact_alignment(Table& table);

/// Twice the covariance of a constant and a slope, from the error of constant + reference slope.
double twice_covariance(const TableEntry& constant, const TableEntry& slope, const TableEntry& referred,
                        double reference);

/// All closures; those with a key are in the order of a scene.
const std::vector<Closure>& closures();

}  // namespace drover::calibrate
