// model/summands.hpp: the summands of the equations of a model, as values of the algebra, and what is checked of them.
#pragma once
#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "drover/model/symbol.hpp"
#include "model/algebra.hpp"
#include "model/lowering.hpp"

namespace drover::model {

/// One summand of a right-hand side as read.
struct Summand {
    TermSummary summary;
    std::size_t number = 0;              ///< in its equation
    Value value;                         ///< without white noise, or the whole where it multiplies noise
    std::vector<LinearForm> noise = {};  ///< white noise with constant coefficients, by components
    bool is_acceleration = false;        ///< the mass is one of its factors, and left out
    bool multiplies_noise = false;       ///< white noise times functions of fields, position or time
    std::set<std::size_t> noises = {};   ///< that it has
    bool has_noise() const { return !noises.empty(); }
};

inline int components(const WhiteNoise& noise) { return noise.spin == 0 ? 1 : 2; }

/// White noises as fields of the formulas, which are numbered after those of the model.
Model with_noises_as_fields(const Model& model);

/// The equations of one field with given fields in place of its noises, and the others as they are.
Model driven_model(const Model& model, std::size_t driven, const std::set<std::size_t>& noises);

class SummandReader {
public:
    /// `with_noises`: the model of the lowering, with its noises as fields.
    SummandReader(const Model& with_noises, Lowering& lowering, Algebra& algebra);

    /// The summands of an equation, without the mass where it is one of their factors; those alone whose number is
    /// taken.  Throws an input Error at its place for what does not fit.
    std::vector<Summand> read(std::size_t field, const std::optional<Formula>& mass,
                              const std::function<bool(std::size_t number)>& takes);

    /// A mass has no noise.
    void check_mass(const Field& field, const Value& mass) const;

private:
    Summand written(std::size_t field, const WrittenTerm& term);
    Summand summand(std::size_t field, const FormulaText& text, Formula formula, std::size_t begin, std::size_t end,
                    const std::optional<Formula>& mass);
    void find_noise(Summand& summand) const;
    void check_product(const Summand& summand) const;
    bool reads_noise(int node) const;
    bool is_noise(const Derivative& derivative) const { return derivative.component >= components_; }
    bool has_noise(const LinearForm& form) const {
        return std::ranges::any_of(form, [this](const auto& entry) { return is_noise(entry.first); });
    }

    const Model& model_;
    Lowering& lowering_;
    Algebra& algebra_;
    int components_ = 0;                 ///< of the fields, without noises
    std::vector<std::size_t> noise_of_;  ///< of each component after them
};

/// Throws an input Error at the place of a field or number that cannot be, whatever the equations.
void check_fields(const Model& model);

/// Throws an input Error where a field that is declared as conserved is no scalar with a rate, or where its summands
/// and their noise are not divergences together.  solenoidal: the first components of divergence-free vectors.
void check_conserved(Algebra& algebra, const Field& field, const std::vector<Summand>& parts,
                     const std::vector<int>& solenoidal);

/// Whether a right side has more than linear terms with constant coefficients and constants.
bool has_products(const Algebra& algebra, const std::vector<Component>& total);

/// The components that a right side reads.
std::set<int> components_of(const Algebra& algebra, const std::vector<Component>& total);

/// The field as an expression of the others, from 0 = total = force - drag * field at every point.  Throws an input
/// Error for a total of another form.  first: the first component of the field.
Value solved_balance(Algebra& algebra, const Field& field, int first, const std::vector<Component>& total);

/// Throws an input Error where a balance leaves a mean of its field free, and products in it have a mean themselves.
/// total: the right side.  solenoidal: as above.
void check_free_mean(Algebra& algebra, const Field& field, const std::vector<Component>& total,
                     const std::function<bool(int component)>& is_in_balance, const std::vector<int>& solenoidal);

}  // namespace drover::model
