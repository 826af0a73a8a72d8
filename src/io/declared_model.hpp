// io/declared_model.hpp: the model that a scene declares: [[field]], [[white_noise]], [equations], [define] and
// [coefficients].
#pragma once
#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/model/model.hpp"
#include "numerics/algebra/spline_table.hpp"

namespace drover::io {

enum class FieldRank { scalar, vector, nematic, complex };  ///< complex: two scalars
constexpr auto names_of(FieldRank) { return std::array{"scalar", "vector", "nematic", "complex"}; }

enum class FieldParity { even, odd };
constexpr auto names_of(FieldParity) { return std::array{"even", "odd"}; }

/// The sense of noise that multiplies fields.
enum class Calculus { ito, stratonovich };
constexpr auto names_of(Calculus) { return std::array{"ito", "stratonovich"}; }

/// One [[field]].  Numbers that may be formulas of the coefficients are texts.
struct DeclaredField {
    std::string name;    ///< in figures and archives; "": the symbol
    std::string symbol;  ///< in equations
    FieldRank rank = FieldRank::scalar;
    int spin = -1;  ///< of any rank; -1: that of `rank`
    FieldParity parity = FieldParity::even;
    std::string unit = "1", meaning;
    std::string mass;             ///< m of m d_t F = equation; "": 1
    std::string mass_unit = "1";  ///< for its energy
    std::string energy;           ///< its name; "": that of the field; "none": it has none
    bool balance = false, conserved = false, solenoidal = false;
    std::string reference = "0";
    std::string noise = "0";
    bool conserved_noise = false;
    std::map<std::string, SourceLocation> places = {};  ///< of its keys; "" is the field itself

    static Rows<DeclaredField> rows();
};

/// One [[white_noise]].
struct DeclaredNoise {
    std::string symbol;  ///< in equations
    FieldRank rank = FieldRank::scalar;
    int spin = -1;  ///< of any rank; -1: that of `rank`
    FieldParity parity = FieldParity::even;
    SourceLocation where = {};

    static Rows<DeclaredNoise> rows();
};

/// One [[tabulated]]: a coefficient that is a smooth function of one or two scalars, by its values on a mesh.
struct DeclaredTable {
    std::string symbol;           ///< in equations
    std::vector<std::string> of;  ///< formulas of one or two scalars
    std::vector<double> first, second;
    std::vector<double> values;  ///< of each of `first`, for each of `second`, which is the faster one
    numerics::Outside outside = numerics::Outside::refuse;
    SourceLocation where = {};

    static Rows<DeclaredTable> rows();
};

/// Everything as written, with its places.
struct DeclaredModel {
    std::string name, file;  ///< file: empty, once it is read
    bool chiral = false;     ///< the equations may distinguish left and right
    Calculus calculus = Calculus::ito;
    /// Of stratonovich: that of model::Model, which follows from the grid of the scene.
    std::function<double(int x, int y)> noise_moment;
    std::vector<DeclaredField> fields;
    std::vector<DeclaredNoise> noises;
    std::vector<DeclaredTable> tables;
    std::map<std::string, model::Text> equations, definitions;
    std::map<std::string, double> coefficients;

    static Rows<DeclaredModel> rows();  ///< of [model]
};

/// The model with its numbers.  Throws an input Error, at its place, for a rank, formula or equation that does not fit.
/// model::Equations checks the equations.
model::Model model_of(const DeclaredModel& declared);

/// Whether one of these names occurs in a formula.
bool mentions(const std::string& formula, const std::vector<std::string>& names);

/// Where a model declares what none of its equations has, directly or by another name: "coefficients.a", "define.mu",
/// "[[tabulated]] b".
std::vector<std::string> without_effect(const DeclaredModel& model);

}  // namespace drover::io
