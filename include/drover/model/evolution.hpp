// model/evolution.hpp: a run of a model in memory: its fields on a grid, advanced in steps.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "drover/model/equations.hpp"
#include "drover/numerics/field.hpp"

namespace drover::model {

/// How a model is integrated.
struct EvolutionControl {
    numerics::Grid grid = {};
    double dt = 0.0;                         ///< step [time], above 0
    std::string method = "etdrk4-krogstad";  ///< a row of numerics::stepper_tables()
    std::uint64_t seed = 1;                  ///< of the noise; runs of dt and dt/2 share their noise
    int threads = 1;
    /// The number of the first step, which decides its noise and its time: that of the end of a run whose fields
    /// set_fields() takes, so that this run continues it.  Multistep methods start anew.
    std::int64_t first_step = 0;
};

class Evolution {
public:
    /// At the time of first_step with all fields at their reference.  Throws an input Error for an invalid grid, step
    /// or method.
    Evolution(const Equations& equations, const EvolutionControl& control);
    ~Evolution();
    Evolution(Evolution&&) noexcept;  ///< one that was moved from can only be assigned to or destroyed
    Evolution& operator=(Evolution&&) noexcept;

    /// The fields with a rate, by components in the order of Equations::state_components(), on the grid.
    numerics::Fields fields() const;
    /// Those in balance, in the order of the other components.
    numerics::Fields balanced() const;
    /// Throws an input Error, and keeps the fields, for values that are not finite, of another number or of another
    /// number of points.
    void set_fields(const numerics::Fields& fields);

    /// steps >= 0.  Throws a run Error that names the field and the step where a value is no longer finite; the run can
    /// then be advanced after set_fields() alone.
    void advance(std::int64_t steps);
    std::int64_t step() const;  ///< first_step and the steps taken
    double time() const;        ///< step() * dt

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace drover::model
