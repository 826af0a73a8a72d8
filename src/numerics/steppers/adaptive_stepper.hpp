// numerics/steppers/adaptive_stepper.hpp: steps of fixed length, divided so that each part meets a tolerance.
#pragma once
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "drover/numerics/stepper.hpp"
#include "numerics/steppers/effort.hpp"
#include "numerics/steppers/sundials_stepper.hpp"

namespace drover::numerics {

/// The step of the method, and how exactly each part of it must be taken.
struct StepControl {
    std::string method;         ///< name of a TimeMethod
    double dt = 0.0;            ///< [s]
    double tolerance = 0.0;     ///< largest relative error of a part; 0: dt is never divided
    bool watches_error = true;  ///< whether the run estimates the error that its steps make: numerics::StepError
    double effort = INFINITY;   ///< that this may take: numerics::Effort::part
    StepWork work = {};         ///< of which it is a part
    std::int64_t steps = std::numeric_limits<std::int64_t>::max();  ///< of the whole run
};

/// Divides dt into 1, 2, 3, 4, 6, 8, 12, ... equal parts: ratios near sqrt(2), and every sequence ends at dt.  With
/// noise the parts are 1, 2, 4, ...: intervals of the noise path, so that a part that is rejected and halved keeps its
/// noise, which rejecting would otherwise make smaller.  Where the embedded error estimate rejects a part, or the
/// right-hand side throws a run Error, their number doubles; where a whole dt leaves a margin, it falls to the next
/// smaller one.  A linear system is exact and is never divided.
///
/// A part of a system with terms in t and without noise is taken whole and in halves, which are kept, and its error is
/// their difference: embedded estimates of order four compare rates of one time, and see no term in t.  After a jump in
/// t the parts grow again within dt.  With noise the halves would differ by what it adds to them.
///
/// The methods of SUNDIALS choose their steps themselves: see SundialsStepper.
class AdaptiveStepper {
public:
    AdaptiveStepper(const StepControl& control, System system, std::uint64_t seed, Threads& threads);

    /// Replaces the system by one on the same grid: the same equations with another linear part.
    void set_system(System system);

    /// From step to step + 1 of dt.  Throws a run Error where no part meets the tolerance, but passes a jump in t of
    /// which only the shortest part does not.
    void advance(std::int64_t step, Spectra& state);

    /// Writes the error of the step that advance() has just taken from `before` to `after` over `before`.  A multistep
    /// method has an estimate, and parts that were taken in halves have theirs.  The step is taken again by others, and
    /// by that while it starts, in twice as many parts without control, or by methods of SUNDIALS that vary their step,
    /// with a hundredth of the tolerance. Returns whether the step was taken again.
    bool find_error(std::int64_t step, const Spectra& after, Spectra& before);
    /// The number of steps from the last one to the next whose error costs no right-hand side; 0: those of all do.
    std::int64_t steps_to_cheap_error();
    /// The work of the last step from advance(), and of taking it again.
    double work_of_step() const;
    double work_of_error() const;

    const System& system() const { return system_; }
    const std::string& method() const { return control_.method; }
    double dt() const { return control_.dt; }
    double tolerance() const { return control_.tolerance; }
    const StepCount& count() const { return count_; }

    /// Parts of dt now: part of the state of a run.
    int division() const { return division_; }
    void set_division(int division) { division_ = division; }
    static constexpr int max_division = 1 << 16;

    /// The history of a multistep method or of one of SUNDIALS, for checkpoints; restored for the present system.
    std::vector<double> save_history() const;
    void restore_history(std::span<const double> saved);
    /// The length of the last step [s].
    double last_step() const;

private:
    Stepper& stepper(int division);
    int coarser() const;
    bool takes_halves() const;
    double attempt(double t, std::uint64_t part, const Spectra& state);
    void attempt_in_halves(double t, std::uint64_t part, const Spectra& state);
    void advance_in_parts(std::int64_t step, Spectra& state);
    void advance_by_sundials(std::int64_t step, Spectra& state);
    void repeat_finer(std::int64_t step, Spectra& state);
    bool shares_first_rate() const;
    double finer_error() const;
    void make_sundials();
    double relative_error(const Spectra& before, const Spectra& after, const Spectra& error) const;

    StepControl control_;
    std::uint64_t seed_;
    Threads& threads_;
    System system_;
    std::shared_ptr<NoisePath> noise_;  // nullptr: none
    std::shared_ptr<StepperScratch> scratch_ = std::make_shared<StepperScratch>();
    std::map<int, Stepper> steppers_;  // by division, for the present system
    std::optional<SundialsStepper> sundials_, finer_sundials_;
    int division_ = 1, taken_ = 1;  // parts of the next dt, of the last one
    Spectra next_, error_;
    std::vector<Complex> of_parts_;   // in halves: the sum of their errors in the last dt
    std::string failure_;             // of the right-hand side in the last attempt; else ""
    StepCount count_, count_before_;  // before the last advance()
};

}  // namespace drover::numerics
