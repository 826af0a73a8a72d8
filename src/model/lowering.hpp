// model/lowering.hpp: formulas of a model as values of the algebra, with checks of rank and parity.
#pragma once
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/formula.hpp"
#include "drover/model/model.hpp"
#include "model/algebra.hpp"

namespace drover::model {

/// A summand "explicit(...)" of an equation is evaluated as a whole: nothing of it is in the exact linear part.
inline constexpr const char* explicit_name = "explicit";

/// The notation of equations: the functions of expressions, outer, explicit, and the prefix operators grad, div, lap,
/// curl, perp, sym, d_x and d_y.
const Notation& equation_notation();
/// The same with functions that are no formulas.
Notation notation_with(const std::map<std::string, GivenFunction>& functions);

/// What is expected in the place of an unknown name, for errors: a name like it, and the list of those known.
std::string expected_name(const std::string& name, const std::vector<std::string>& known);

/// The meanings of all names of a model.
class Names {
public:
    /// Throws an input Error for names that are no names, are reserved, or are used twice, at the second place.
    explicit Names(const Model& model);

    enum class Kind { field, component, definition, coefficient, position };
    struct Meaning {
        Kind kind = Kind::field;
        std::size_t index = 0;  ///< of the field or definition; slot of a position
        int component = 0;      ///< the first of the field, or that named, numbered through all fields
    };
    /// nullptr if unknown.
    const Meaning* find(const std::string& name) const;
    /// A name like it and the list of names, for errors.
    std::string expected(const std::string& name) const;
    int first_component(std::size_t field) const { return first_components_[field]; }

private:
    void add(const std::string& name, const Meaning& meaning, const SourceLocation& where);
    std::map<std::string, Meaning> meanings_;
    std::set<std::string> reserved_;  // functions of the model, and the imaginary unit
    std::map<std::string, SourceLocation> places_;
    std::vector<int> first_components_;
};

class Lowering {
public:
    Lowering(const Model& model, const Names& names, Algebra& algebra);

    /// Throws an input Error, at the column, for unknown names, ranks and parities that do not fit, and whatever the
    /// algebra rejects.
    Value value_of(const FormulaText& text, const Formula& formula);
    /// The value of a definition.
    Value value_of_definition(std::size_t index);
    /// A value of a text, with its rank and parity as declared.
    Value value_of(const Text& text, const Rank& rank, Parity parity);
    void check(const FormulaText& text, const Formula& formula, const Value& found, const Rank& rank,
               Parity parity) const;

    /// The value of a term that is written apart.
    Value value_of(const WrittenTerm& term);

    /// From now on a field stands for this value.
    void substitute(std::size_t field, const Value& value) {
        substitutes_.insert_or_assign(field, value);
        definitions_.clear();  // they may contain the field
    }

    /// Combines parities; an input Error where they differ and the model is not chiral.
    Parity common_parity(const FormulaText& text, const Formula& at, const Value& a, const Value& b) const;

private:
    Value named(const FormulaText& text, const Formula& f);
    Value added(const FormulaText& text, const Formula& f);
    Value multiplied(const FormulaText& text, const Formula& f);
    Value power(const FormulaText& text, const Formula& f);
    /// A product of two values that is linear in both, of complex ones by their parts.
    template <class Product>
    Value by_parts(const Value& a, const Value& b, Product product);
    Value dot(const FormulaText& text, const Formula& f);
    Value dot(const FormulaText& text, const Formula& f, const Value& left, const Value& right);
    Value double_dot(const FormulaText& text, const Formula& f);
    Value double_dot(const FormulaText& text, const Formula& f, const Value& left, const Value& right);
    Value times(const FormulaText& text, const Formula& f, const Value& left, const Value& right);
    Value divided(const FormulaText& text, const Formula& f, const Value& above, const Value& below);
    Value complex_power(const FormulaText& text, const Formula& f, const Value& base, double n);
    Value part_of_complex(const FormulaText& text, const Formula& f);
    Value norm(const FormulaText& text, const Formula& f);
    Value call(const FormulaText& text, const Formula& f);
    Value given_call(const FormulaText& text, const Formula& f, const GivenFunction& function);
    /// The function of a name that is no formula; nullptr if there is none.
    const GivenFunction* given_function(const std::string& name) const;
    Value named_in_scope(const FormulaText& text, const Formula& f);
    Formula parsed(const FormulaText& text) const;
    Value outer(const FormulaText& text, const Formula& f);
    Value outer(const FormulaText& text, const Formula& f, const Value& a, const Value& b);
    Value operation(const FormulaText& text, const Formula& f);
    Value applied(const FormulaText& text, const Formula& f, Value a);
    Value applied_to_real(const FormulaText& text, const Formula& f, Value a);
    Value value_of_kind(const FormulaText& text, const Formula& f);
    Value gradient(const Value& a);
    Value divergence(const Value& a);
    Value symmetric(const Value& a);
    Value self_advection(const Value& v);
    Component scalar_function(const FormulaText& text, const Formula& f, Operation operation,
                              const std::vector<Value>& arguments);
    void need_scalar(const FormulaText& text, const Formula& f, const Value& found, const char* what) const;

    const Model& model_;
    const Names& names_;
    Algebra& algebra_;
    std::map<std::size_t, Value> definitions_, substitutes_;
    std::vector<std::size_t> open_definitions_;
    const Scope* scope_ = nullptr;  // of the term that is read
    std::map<const GivenFunction*, std::shared_ptr<const GivenFunction>> functions_;
    int depth_ = 0;
};

}  // namespace drover::model
