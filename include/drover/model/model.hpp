// model/model.hpp: a model as data: declared fields, their equations in vector notation, coefficients and noise.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/numerics/grid.hpp"

namespace drover::model {

/// A formula in vector notation (the page "Your own model" of the manual), with the place of its first character.
struct Text {
    std::string text = {};
    SourceLocation where = {};
};

/// An argument of a function: values at points, or one number for all of them.
struct PointArgument {
    const double* values = nullptr;
    double number = 0.0;
};

/// A function of numbers at each point that is no formula: a table, or a function of the calling program.  `values` and
/// `slopes` are required; both must throw a drover::Error outside the domain.
struct GivenFunction {
    int arguments = 1;              ///< >= 1
    int results = 1;                ///< 1: a scalar; 2: the x and y components of a vector
    int degree = 1;                 ///< as a polynomial of its arguments: decides which modes are kept
    bool has_finite_degree = true;  ///< false: it is no such polynomial
    bool has_exact_slopes = true;   ///< false: by differences
    /// Writes the results at points, from any thread; throws what the function throws.
    std::function<void(std::size_t size, std::span<const PointArgument> arguments, std::span<double* const> out)>
        values;
    /// Slopes at one point, [result][argument], from any thread; by differences where has_exact_slopes is false.
    std::function<std::vector<double>(std::span<const double> arguments)> slopes;
};

/// The names of a term with a vocabulary of its own, besides x, y and t.
struct Scope {
    std::map<std::string, std::string> names;  ///< what they are in formulas of the model: "order_x" is "p_x"
    std::map<std::string, double> parameters;  ///< numbers
    std::map<std::string, GivenFunction> functions;
};

/// A summand of a right side that is written apart.
struct WrittenTerm {
    std::string name;                         ///< of its TermSummary
    std::vector<Text> texts;                  ///< one of the rank of the field, or one for each component
    bool is_flux = false;                     ///< the texts are those of a vector J, and the term is -div J
    bool is_explicit = false;                 ///< nothing of it is in the exact linear part
    std::shared_ptr<const Scope> scope = {};  ///< nullptr: the names of the model
};

/// A source at a point that may move: of the strength, with a Gaussian profile.
struct PointSource {
    double x = 0.0, y = 0.0;                    ///< strength: its integral over space; y: of a vector
    double at_x = 0.0, at_y = 0.0;              ///< position at t = 0
    double velocity_x = 0.0, velocity_y = 0.0;  ///< of the position
    double width = 0.0;                         ///< standard deviation of the profile; 0: band-limited delta function
};

/// The left side of an equation.
enum class LeftSide {
    rate,     ///< d_t F
    balance,  ///< 0: the field follows the others at every instant
    given     ///< none: the field is a point source
};

/// Which part of the value of its equation a field is.
enum class Part {
    whole,
    real,      ///< of a complex field, which is two scalars that do not turn: the part of its name with _re
    imaginary  ///< _im
};

/// How observables are derived from a field, and how they are named if not by the name of the field.
struct Observed {
    std::string short_name = {};  ///< in structure factors: "rods"
    std::string counted = {};     ///< a body of a density, whose number fluctuations are measured: "rod"
    /// Symbol of the density whose bodies have a vector: the mean over them or, in the unit of that density, their sum.
    std::string of = {};
    std::string body = {};        ///< of a density or a vector of bodies: "rod"; "": it is of none
    bool name_first = false;      ///< "polar_order_mean_x" in place of "mean_polar_order_x"
    int drawn = 0;                ///< its place among observables and in figures; 0: that in the model
    std::string energy = {};      ///< of its energy, "energy_flow" of "flow"; "": its own name; "none": it has none
    std::string mass_unit = "1";  ///< of the mass of the field: for its energy
};

/// A declared field.  In two dimensions a field of spin m has one component (m = 0) or two (m >= 1): those of the
/// complex number F = F_1 + i F_2 that turns by the angle m theta when space is turned by theta.  A vector has spin 1
/// (F = v_x + i v_y), a nematic spin 2 (F = Q_xx + i Q_xy).
struct Field {
    std::string name;    ///< in files and figures: "rod_density"
    std::string symbol;  ///< in formulas: "sigma"
    int spin = 0;        ///< 0 to 6
    bool odd = false;    ///< changes sign under reflections, besides what its spin does: a pseudoscalar, ...
    std::string unit = "1", meaning = {};
    LeftSide left = LeftSide::rate;
    Text mass = {};                         ///< m in m d_t F = right side: a scalar of the fields; empty: 1
    Text equation = {};                     ///< the right side; empty: 0
    Part part = Part::whole;                ///< the right side is this part of the equation
    std::vector<WrittenTerm> further = {};  ///< summands besides those of `equation`
    PointSource source = {};                ///< of a given field
    bool conserved = false;                 ///< the mean does not change: checked
    bool solenoidal = false;       ///< a vector without divergence: the pressure that keeps it so is eliminated
    double reference = 0.0;        ///< of a true scalar: its value in the state about which the linear part is exact
    double noise = 0.0;            ///< D: <f f> = D delta delta for each component of a noise f of its own in d_t F
    bool noise_conserves = false;  ///< <f f> = D q^2 delta delta: the noise is the divergence of a random flux
    Observed observed = {};
    SourceLocation where = {};
};

/// White noise of unit strength, a name in equations: <xi xi> = delta delta for each component.  Fields whose equations
/// have it are driven by the same noise.
struct WhiteNoise {
    std::string symbol;
    int spin = 0;  ///< 0 to 6
    bool odd = false;
    SourceLocation where = {};
};

/// A named part of the equations: "mu" = "phi^3 - phi - lap phi".
struct Definition {
    std::string name;
    Text value;
    bool is_table = false;  ///< of the fields that the table names: no arguments follow
};

struct Model {
    std::vector<Field> fields = {};
    std::vector<Definition> definitions = {};
    std::map<std::string, double> coefficients = {};  ///< by symbol
    std::map<std::string, GivenFunction> functions = {};
    std::vector<WhiteNoise> noises = {};
    bool chiral = false;  ///< allows terms that distinguish left and right
    /// The sum of q_x^x q_y^y over the modes of the white noises, per area [1/mm^(2 + x + y)]: noise that multiplies
    /// fields is in the sense of Stratonovich.  Empty: in that of Ito.
    std::function<double(int x, int y)> noise_moment = {};
};

/// Model::noise_moment of the noise of a grid, of the modes that products of this degree keep.
double noise_moment(const numerics::Grid& grid, int kept_degree, int x, int y);

/// "p_x" and "p_y" of a vector, "Q_xx" and "Q_xy" of a nematic, "F_1" and "F_2" of other spins, "phi" of a scalar.
std::vector<std::string> component_names(const Field& field);

/// The same from the name of the field, as files and figures have them: "polar_order_x".
std::vector<std::string> dataset_names(const Field& field);

inline int components(const Field& field) { return field.spin == 0 ? 1 : 2; }
inline std::size_t components(const Model& model) {
    std::size_t count = 0;
    for (const Field& field : model.fields) count += static_cast<std::size_t>(components(field));
    return count;
}

/// A field of a model, and the first of its components among those of all fields.
struct PlacedField {
    const Field& field;
    std::size_t first;
};
inline std::vector<PlacedField> placed_fields(const Model& model) {
    std::vector<PlacedField> result;
    std::size_t first = 0;
    for (const Field& field : model.fields) {
        result.push_back({field, first});
        first += static_cast<std::size_t>(components(field));
    }
    return result;
}

/// Where the components of each field begin in a state.
std::vector<int> first_components(const Model& model);

/// The fields in the order in which they are drawn.
std::vector<std::size_t> drawn_fields(const Model& model);

/// What a density counts in boxes, a conserved scalar of positive mean by its own name; "" of other fields.
inline std::string counted_by(const Field& field) {
    const bool is_density = field.spin == 0 && field.conserved && field.reference > 0.0;
    return field.observed.counted.empty() && is_density ? field.name : field.observed.counted;
}

/// Its name in structure factors.
inline std::string short_name(const Field& field) {
    return field.observed.short_name.empty() ? field.name : field.observed.short_name;
}

}  // namespace drover::model
