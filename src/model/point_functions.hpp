// model/point_functions.hpp: what is transformed to the grid, and the functions at its points, calls and bounded masses
// included.
#pragma once
#include "drover/numerics/transform.hpp"
#include "model/compiled.hpp"

namespace drover::model {

/// The arrays that are transformed to the grid, and the functions of them.
struct TransformPlan {
    std::vector<LinearForm> inputs;
    /// A call whose results some function reads: of expressions, with results in the slots from `first`.
    struct Function {
        std::size_t call = 0;
        std::vector<Expression> arguments;
        std::vector<int> results;  ///< offsets from the first slot of the call: values and slopes that are read
        int first = 0;
    };
    std::vector<Function> functions;  ///< each after those that it reads
    std::vector<Expression> values;   ///< of the outputs; slots: position, time, inputs, results
    int slots = 0;
};
TransformPlan transform_plan(const CompiledEquations& equations);

/// Equations whose functions at points are the products in the balances of others.
std::shared_ptr<const CompiledEquations> with_forces_as_outputs(const CompiledEquations& equations);

/// Whether a form is one component of the fields.
bool is_plain(const LinearForm& form);

/// The functions of a plan at points.
class PointFunctions {
public:
    PointFunctions(const CompiledEquations& equations, const TransformPlan& plan, const numerics::Grid& grid);

    /// Writes the values of the plan at the points of a strip of its inputs.
    void write(double t, const numerics::Strip& strip) const;

    void set_step(double dt);                    ///< see ExplicitPart
    double mass_floor(std::size_t field) const;  ///< the same

private:
    struct Inverse {
        std::size_t field = 0;
        double reference = 0.0, drag = 0.0;  ///< of the mass and of its field, at the references
        double floor = 0.0;
    };
    /// A call at points.
    struct Evaluated {
        std::shared_ptr<const GivenFunction> function;
        std::vector<int> slots;  ///< of the arguments, where they are one; -1: an expression
        std::vector<std::shared_ptr<const StripProgram>> programs;  ///< of the others
        std::vector<double> numbers;                                ///< of arguments that are numbers
        std::vector<int> values, slopes;  ///< slot of each result, and of each slope by argument; -1: not read
        int inverse = -1;                 ///< number of the mass whose inverse it is
    };
    struct Rows;
    void add_call(const TransformPlan::Function& function, const Call& call);
    void call(const Evaluated& one, std::size_t size, Rows& rows) const;

    numerics::Grid grid_;
    std::size_t inputs_;
    int slots_;
    bool reads_position_ = false;
    StripProgram program_;
    std::vector<Evaluated> calls_;
    std::vector<Inverse> masses_;
};

}  // namespace drover::model
