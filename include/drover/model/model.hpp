// model/model.hpp: a model as data: declared fields, their equations in vector notation, coefficients and noise.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::model {

/// A formula in vector notation (base/formula.hpp), with the place of its first character.
struct Text {
    std::string text = {};
    SourceLocation where = {};
};

/// The left side of an equation.
enum class LeftSide {
    rate,    ///< d_t F
    balance  ///< 0: the field follows the others at every instant
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
    Text mass = {};                ///< m in m d_t F = right side: a scalar of the fields; empty: 1
    Text equation = {};            ///< the right side; empty: 0
    bool conserved = false;        ///< the mean does not change: checked
    double reference = 0.0;        ///< of a true scalar: its value in the state about which the linear part is exact
    double noise = 0.0;            ///< D: <f f> = D delta delta for each component of the noise f in d_t F
    bool noise_conserves = false;  ///< <f f> = D q^2 delta delta: the noise is the divergence of a random flux
    SourceLocation where = {};
};

/// A named part of the equations: "mu" = "phi^3 - phi - lap phi".
struct Definition {
    std::string name;
    Text value;
};

struct Model {
    std::vector<Field> fields;
    std::vector<Definition> definitions;
    std::map<std::string, double> coefficients;  ///< by symbol
    bool chiral = false;                         ///< allows terms that distinguish left and right
};

/// "p_x" and "p_y" of a vector, "Q_xx" and "Q_xy" of a nematic, "F_1" and "F_2" of other spins, "phi" of a scalar.
std::vector<std::string> component_names(const Field& field);

/// The same from the name of the field, as files and figures have them: "polar_order_x".
std::vector<std::string> dataset_names(const Field& field);

inline int components(const Field& field) { return field.spin == 0 ? 1 : 2; }

}  // namespace drover::model
