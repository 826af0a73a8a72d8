// run/session.hpp: a run in memory that its caller advances; it writes no files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/measure/statistics.hpp"

namespace drover::io {
struct Scene;
}

namespace drover::run {

struct SessionState;

/// An array of a frame.
struct FrameArray {
    std::string name;  ///< of a field, or "beads/velocity", "rods/axis" of bodies
    std::string unit, meaning;
    std::vector<std::size_t> shape;  ///< slowest first
    std::span<double> values;        ///< where they are until the session ends
};

/// An observable at all samples so far.
struct ObservedSeries {
    std::string name, unit, meaning;
    std::vector<std::size_t> shape;  ///< of one sample; empty: one number
    std::vector<double> values;      ///< sample after sample
};

/// A mean over the samples so far, beside linear theory.
struct SessionResult : measure::SummaryRow {
    std::vector<double> theory = {};  ///< one for each estimate; empty: there is none
};

/// A run with the same states, frames and observables, to the last bit, as `drover run` writes.  Use one from one
/// thread at a time.
class Session {
public:
    /// The scene in a file, or in a text that error messages call by `name`.  At t = 0; without time.dt the step is
    /// chosen first.  Throws an input Error for a scene that is not valid and where memory is insufficient.
    explicit Session(const std::filesystem::path& scene_file);
    Session(const std::string& scene, const std::string& name);
    explicit Session(const io::Scene& scene);  ///< for drover itself
    Session(Session&&) noexcept;               ///< one that was moved from can only be assigned to or destroyed
    Session& operator=(Session&&) noexcept;
    ~Session();

    double time() const;         ///< [s]
    double dt() const;           ///< [s]
    std::int64_t step() const;   ///< taken so far
    std::int64_t steps() const;  ///< to time.end

    /// steps >= 0.  Calls `poll` before every step; an exception from it leaves the run as it is then.  Throws run
    /// Errors, after which the run cannot be advanced any more.
    void advance(
        std::int64_t steps, const std::function<void()>& poll = [] {});

    /// The fields or bodies now.  They may be changed, and taken as the state by accept().
    std::vector<FrameArray> frame() const;
    /// Takes the arrays of the frame as the fields, or the bodies.  Throws an input Error, and keeps the state, for
    /// values that are not finite, and for bodies that overlap.
    void accept();

    std::span<const double> sample_times() const;  ///< [s]
    std::vector<ObservedSeries> series() const;    ///< of the observables
    /// Means with errors and linear theory of the samples so far, as of a run that ends now; of particles without what
    /// needs their paths, which are not kept.  Throws an input Error before the first step.
    std::vector<SessionResult> results() const;

private:
    std::unique_ptr<SessionState> state_;
};

}  // namespace drover::run
