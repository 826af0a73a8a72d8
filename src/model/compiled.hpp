// model/compiled.hpp: what the equations of a model are made of.
#pragma once
#include <array>
#include <complex>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/model/symbol.hpp"
#include "drover/numerics/system.hpp"
#include "model/algebra.hpp"

namespace drover::model {

struct PointDegree {
    int degree = 1;
    bool is_finite = true;  ///< false: some part is no polynomial of the fields, or depends on the position
};

/// The degree in the atoms, by the largest summand.  The position counts as a factor.  A divisor counts as one with its
/// own degree, and a function that is no polynomial as a product of at least two.  of_result: of a result of a call,
/// nothing for other slots.
PointDegree point_degree(const Expression& expression, const std::function<std::optional<PointDegree>(int)>& of_result);

/// A function at points, with its slopes by atoms.
struct PointFunction {
    struct Slope {
        int slot;
        Expression value;
    };
    Order order = {};  ///< the derivative that is taken of it
    Expression value;
    std::vector<Slope> slopes;
};

/// One row of one term: a linear form plus derivatives of functions at points.
struct Row {
    LinearForm linear;
    std::vector<PointFunction> functions;
};

struct Term {
    TermSummary summary;
    std::vector<Row> rows;  ///< of the components of its field
};

/// A call with its arguments as expressions.
struct Call : FunctionCall {
    std::vector<Expression> values;  ///< of the arguments
};

/// What moves a field: its inverse is the result of a call.
struct Mass {
    std::size_t field = 0;
    std::size_t call = 0;
    SourceLocation where;
};

/// A function at points that the solver evaluates: without its linear part about the reference.
struct RateFunction {
    Expression value;
    struct Use {
        int component;
        Order order;
        double factor;
    };
    std::vector<Use> uses;  ///< factor * derivative of it is added to the rates of components
};

struct CompiledEquations;

/// The summands of one equation that multiply noise.
struct NoiseProducts {
    std::size_t field = 0;
    std::vector<std::size_t> noises;                     ///< that they have
    std::shared_ptr<const CompiledEquations> equations;  ///< these summands alone; the noises are given fields
};

struct CompiledEquations {
    Model model;
    std::vector<int> first_component;  ///< of each field
    int components = 0;
    std::vector<int> state;            ///< component of each array of a state
    std::vector<int> array_of;         ///< array of a state of each component; -1: in balance
    std::vector<int> field_of;         ///< of each component
    std::vector<bool> is_substituted;  ///< of each field: in balance at every point, an expression of the others
    std::vector<int> free;             ///< components that determine all others: of the state, and given ones
    std::vector<Term> terms;
    std::vector<Term> substitutes;  ///< the values of fields in balance at every point
    std::vector<Term> evaluated;    ///< what the solver evaluates: forces that a mass divides are one term
    std::vector<TermSummary> summaries;
    std::vector<LinearForm> noise_rows;  ///< of each component: of the components of all white noises
    int noise_components = 0;
    std::vector<TermSummary> noise_terms;
    std::vector<NoiseProducts> products;  ///< noise whose strength depends on fields, position or time
    std::vector<LinearForm> atoms;        ///< by slot less first_atom; empty for results of calls
    std::vector<Call> calls;
    std::vector<Mass> masses;
    std::map<std::size_t, double> constant_masses;  ///< by field; others have none, or one that varies

    // What follows from the state about which the linear part is taken.
    UniformState about;
    std::vector<int> held;           ///< components in balance
    std::vector<LinearForm> linear;  ///< rows: the linear parts about it
    Eigen::MatrixXd uniform_linear;  ///< these at q = 0
    bool is_isotropic = true;        ///< of these; otherwise the propagator has their average over directions
    std::vector<double> constants;   ///< rows: uniform sources
    std::vector<RateFunction> outputs;
    std::vector<RateFunction> forces;  ///< the same in balances that are solved wave by wave
    int degree = 1;
    bool has_finite_degree = true;

    /// What white noises with constant coefficients add to the rates at q: rows by component, columns by component of
    /// the noises.
    Symbol noise_symbol(const std::vector<LinearForm>& rows, const numerics::Wavevector& q) const;
    /// The same of those that fields multiply, in a uniform state.
    Symbol product_symbol(const UniformState& uniform, const numerics::Wavevector& q) const;
    /// Strengths of the noise with constant coefficients; has_sums: whether there is any.
    Symbol sum_noise(const numerics::Wavevector& q) const;
    bool has_sums() const;
    /// The first component of a white noise, among those of all.
    int first_of_noise(std::size_t noise) const;
    /// Throws an input Error unless they act alike in all directions, and do not distinguish left and right.
    void check_noise() const;
    int slots() const { return first_atom + static_cast<int>(atoms.size()); }
    const LinearForm& form_of(int slot) const { return model::form_of(atoms, slot); }
    /// Completes the summary of a term by what its rows are.
    void summarise(Term& term) const;
    [[noreturn]] void reject_cycle(std::size_t field) const;
    /// Takes the linear part about this state, and its remainder.
    void split(const UniformState& at);
    /// The slots that hold no result of a call and of which an expression depends, also through calls.
    std::set<int> slots_read(const Expression& expression) const;
    /// The slope of an expression by such a slot.
    Expression slope(const Expression& expression, int slot, const SourceLocation& where = {}) const;
    /// An expression where the slots have these values.  Where it is 0/0, as the slope of |p| p at p = 0, it is the
    /// limit from several sides; not finite where there is none, as of p/|p|.
    double limit_at(const Expression& expression, const std::vector<double>& values) const;
    /// The same of a slope; not finite either where it jumps, as that of |u| at u = 0.
    double slope_at(const Expression& slope, const std::vector<double>& values) const;
    /// Whether a function neither jumps there nor is 0/0 without a limit.
    bool is_continuous_at(const PointFunction& function, const std::vector<double>& values) const;
    /// Whether all slopes of a term are finite there.
    bool has_slopes(const Term& term, const std::vector<double>& values) const;
    PointDegree degree_of(const Expression& expression) const;
    const Call* call_at(int slot) const { return call_of(calls, slot); }
    bool is_given(int component) const { return model.fields[field(component)].left == LeftSide::given; }
    /// The inverse of the balances between `held`, of a symbol at |q| along x; 0 for a mean that they leave free, and
    /// between parts along q of divergence-free fields.
    Symbol inverse_of_balance(const Symbol& m, double q) const;
    bool reads_changing_mean() const;
    /// Throws an input Error unless the balances determine their fields at |q|; at 0 they may leave a mean free.
    void check_balance_at(double q) const;
    /// Whether a component follows the others by a linear balance, mode by mode.
    bool in_balance(int component) const {
        return array_of[static_cast<std::size_t>(component)] < 0 && !is_substituted[field(component)] &&
               !is_given(component);
    }
    bool has_balance() const { return !held.empty(); }
    /// Uniform sources of the rates, those through fields in balance included.
    std::vector<double> sources(std::vector<double>* of_held = nullptr) const;
    /// All fields at their reference.
    UniformState reference() const;
    /// A uniform state with the values of fields in balance that follow from the others.  Throws an input Error for a
    /// state of another size or with values that are not finite.
    UniformState balanced(const UniformState& at) const;
    /// What the functions of `forces` are in a uniform state, by component.
    Eigen::VectorXd uniform_products(const UniformState& at) const;
    /// The same with the values of fields in balance at every point.
    UniformState completed(const UniformState& at) const;
    /// As Equations::uniform_rates; sizes: the sums of the absolute values of the terms.
    Eigen::VectorXd uniform_rates(const UniformState& at, const std::vector<double>& factors = {},
                                  Eigen::VectorXd* sizes = nullptr) const;
    /// The entries of the linearisation of a term about a uniform state with these values of the slots.  Throws an
    /// input Error for a term that depends on position or time, and where a slope is not finite.
    void visit_slopes(
        const Term& term, const std::vector<double>& slots,
        const std::function<void(int row, const Derivative& derivative, double coefficient)>& visit) const;
    /// Writes the results of a call where the other slots have their values, and its slopes only if asked for.
    void call(const Call& call, bool with_slopes, std::vector<double>& slots) const;
    /// Values of the slots in a uniform state; those of slopes of calls only if asked for.
    std::vector<double> slots_at(const UniformState& state, bool with_slopes = true) const;
    /// A row of symbols: what a linear form is of the deviations at q.
    void add_form(const LinearForm& form, const Order& order, std::complex<double> factor,
                  const numerics::Wavevector& q, int row, Symbol& m) const;
    /// The symbol of linear forms; columns: their components, where these are not those of the fields alone.
    Symbol form_symbol(const std::vector<LinearForm>& rows, const numerics::Wavevector& q, int columns = 0) const;
    /// The sizes of their coefficients, of all components of the fields and the noises.
    Eigen::MatrixXd sizes_of(const std::vector<LinearForm>& rows) const;
    /// Eliminates the fields in balance; returns also what they are of the others.
    Symbol eliminated(const Symbol& m, Symbol* balance = nullptr) const;
    static Symbol eliminated(const Symbol& m, const std::vector<int>& held, const std::vector<int>& state,
                             const std::vector<int>& free, Symbol* balance);
    /// A symbol at q = |q| (cosine, sine) in the frame of q; back: the inverse.
    Symbol in_frame(const Symbol& m, double cosine, double sine, bool back = false) const;
    /// Leaves out the parts along q of divergence-free fields of a matrix at q.
    void leave_out_divergence(Symbol& m, const numerics::Wavevector& q) const;
    /// The same of a symbol, as pressures do; of a field in balance the part is held at 0.
    void add_pressure(Symbol& m, const numerics::Wavevector& q) const;
    void leave_out_along(Symbol& m, const numerics::Wavevector& q, bool holds_balances) const;
    bool is_solenoidal(int component) const { return model.fields[field(component)].solenoidal; }
    bool has_solenoidal() const;
    /// The average over the directions of q, without what couples the even and the odd block, at q along x.
    Symbol averaged(const std::vector<LinearForm>& rows, double q) const;
    /// Sums over the components of two fields, at each of these: turning mixes no others, and rounding is relative to
    /// them.
    Eigen::MatrixXd over_fields(const Eigen::MatrixXd& of_components) const;
    bool commutes_with_turns(const std::vector<LinearForm>& rows) const;
    /// Whether a matrix of one power of |q| is the same in the frame of q for all directions of q, tried at some;
    /// `sizes` of its entries at |q| = 1, to which rounding is relative.  unmixed: and whether it does not couple the
    /// even and the odd block.
    bool is_same_in_all_directions(const std::function<Symbol(const numerics::Wavevector& direction)>& matrix,
                                   const Eigen::MatrixXd& sizes, bool unmixed = false) const;
    int spin_of(int component) const { return model.fields[field(component)].spin; }
    std::size_t field(int component) const {
        return static_cast<std::size_t>(field_of[static_cast<std::size_t>(component)]);
    }
    /// 0 or 1: the first or second component of its field.
    int part_of(int component) const { return component - first_component[field(component)]; }
    /// The block to which a component belongs in the frame of q: true scalars and first parts are even.
    bool is_odd(int component) const { return model.fields[field(component)].odd != (part_of(component) == 1); }
};

/// (i q_x)^x (i q_y)^y.
inline std::complex<double> factor_of(const Order& order, const numerics::Wavevector& q) {
    std::complex<double> result = 1.0;
    for (int i = 0; i < order.x; ++i) result *= std::complex<double>(0.0, q.x);
    for (int i = 0; i < order.y; ++i) result *= std::complex<double>(0.0, q.y);
    return result;
}

/// At which directions are compared.
inline constexpr std::array some_angles{0.7, 2.1};

/// The parts of linear forms by their number of derivatives.  What holds of each holds at all wavenumbers: in a sum,
/// at some wavenumber, small parts are below the rounding of others.
std::map<int, std::vector<LinearForm>> by_order(const std::vector<LinearForm>& rows);

TransformCount transforms_of(const CompiledEquations& equations);

/// The noises that drive fields by products, without what they add.
numerics::ProductNoise product_noise(const std::shared_ptr<const CompiledEquations>& equations);

}  // namespace drover::model
