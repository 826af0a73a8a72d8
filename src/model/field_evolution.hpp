// model/field_evolution.hpp: time integration of the fields of a model, with a linear part that follows the state.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/constants.hpp"
#include "model/explicit_part.hpp"
#include "numerics/steppers/watched_stepper.hpp"

namespace drover::model {

/// A scalar whose reference, in the exact linear part, follows its values in a run: it is that of the model times
/// sqrt(2)^level.  The explicit part is stable if the reference is at most twice the smallest value of a density that
/// makes a mass, and at least half the largest value of one with which a damping grows.
struct Followed {
    int component = 0;
    bool by_largest = false;
    std::size_t mass_field = 0;  ///< the field of the mass, unless by_largest
};

/// The level for values of `part` times the reference of the model.  A hysteresis of half a level prevents switching
/// back and forth.
int followed_level(bool by_largest, double part, int reference_level);

/// The first true scalar of positive reference to which a mass is proportional, or nearly so; else the last with which
/// a damping of short waves is.  shortest: the largest wavenumber of the grid.
std::optional<Followed> followed_scalar(const Equations& equations, double shortest);

/// The run Error of Integrated::check: what went wrong is often another field, which a caller can look for.
struct DomainFailure : Error {
    DomainFailure(const std::string& message, int of) : Error(Fault::run, {}, message), component(of) {}
    int component;  ///< whose values are not allowed: in a state; -1: several
};

/// What a run of fields integrates.
struct Integrated {
    Equations equations;
    int kept_degree = 0;            ///< as that of Equations::system
    std::vector<int> watched = {};  ///< components whose extremes each evaluation finds
    /// Called after each evaluation of N with these extremes; throws a DomainFailure for what is not allowed.
    std::function<void(std::span<const Range>)> check = {};
    /// Generalised quasi-linear approximation: shorter waves interact with longer ones only [1/mm].
    double long_waves = infinite;
    bool is_quiet = false;  ///< without noise
    double shortest = 0.0;  ///< numerics::ErrorEquations::shortest
};

/// L, N and Q about one reference.
struct Split {
    numerics::System system;
    std::shared_ptr<ExplicitPart> part;     ///< nullptr: N is 0
    std::shared_ptr<const Range> followed;  ///< the values of the followed scalar
};

/// L, N and Q.
numerics::System system_of(const Integrated& what, const numerics::Grid& grid, Threads& threads);
/// The same with other modes kept than those of what.kept_degree; 1: all, whatever the products need.
numerics::System system_of(const Integrated& what, const numerics::Grid& grid, int degree, Threads& threads);

/// Transforms of one evaluation of N; none where it is 0.
TransformCount transforms_of(const Integrated& what);

/// What a step of a run does, without observables.
numerics::StepWork step_work(const Integrated& what, const numerics::Grid& grid);

/// Memory that N holds [bytes], without the fields.
double explicit_bytes(const Integrated& what, const numerics::Grid& grid, int degree);

/// Its internal state, besides the fields: the level of the reference, the division of dt and the error so far.
class FieldEvolution {
public:
    FieldEvolution(Integrated what, const numerics::Grid& grid, const numerics::StepControl& control,
                   std::uint64_t seed, Threads& threads);

    /// Chooses the reference for an initial state.
    void start(const numerics::Spectra& state);

    /// Advances the state from step to step + 1.  Throws a run Error that names the cause, also where a single step
    /// makes an error as large as half of a field.
    void advance(std::int64_t step, numerics::Spectra& state);

    const Integrated& what() const { return what_; }
    /// L and Q about the references of the model.
    const numerics::System& linear() const { return linear_; }
    const numerics::AdaptiveStepper& stepper() const { return stepper_.stepper(); }
    std::int64_t reference_changes() const { return changes_; }
    /// All components in balance on the grid, in their order.  Not by two threads at once.
    numerics::Fields balanced(double t, const numerics::Spectra& state) const;

    /// The estimated error of the time steps so far; none of a linear model, which is exact.
    numerics::StepError::Relative step_error() const { return stepper_.step_error(); }
    double work_done() const { return stepper_.work_done(); }
    /// The error of the fields where it is known with its phases: see StepError::known().
    std::optional<numerics::Spectra> known_error() const { return stepper_.known_error(); }

    /// Begins anew with the reference of another evolution of the same equations.
    void follow(const FieldEvolution& other);

    /// The values that a checkpoint stores besides the fields.
    std::vector<double> save() const;
    void restore(std::span<const double> values);

private:
    Integrated at_level(int reference_level) const;
    numerics::ErrorEquations watched() const;
    numerics::ErrorEquations::OnGrid equations_on_grid(int reference_level) const;
    void set_reference(int reference_level);
    double part_of_reference() const;
    void follow_values(double part);

    Integrated what_;
    std::optional<Followed> followed_;
    numerics::Grid grid_;
    Threads& threads_;
    numerics::System linear_;
    Split split_;
    numerics::WatchedStepper stepper_;
    mutable std::unique_ptr<ExplicitPart> balances_;  // where N is 0
    int reference_level_ = 0;
    std::int64_t changes_ = 0;
};

}  // namespace drover::model
