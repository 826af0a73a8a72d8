// model/point_functions.hpp: the functions of a plan at the points of strips, calls and bounded masses included.
#pragma once
#include "drover/numerics/transform.hpp"
#include "model/transform_plan.hpp"

namespace drover::model {

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
