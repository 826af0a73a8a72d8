// numerics/steppers/coarse_error.hpp: the error of the time steps on a coarse grid: its equations, its modes, the sizes
// of fields, and the errors of single steps.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/grid.hpp"
#include "drover/numerics/system.hpp"
#include "numerics/steppers/kept_modes.hpp"

namespace drover::numerics {

/// The equations of a run, as the estimate needs them.
struct ErrorEquations {
    struct Field {
        int first = 0, components = 1;  ///< in a state
        std::string name;
    };
    /// L and N on a grid, without noise; degree: which of its modes are kept, 1: all, whatever the products need.
    using OnGrid = std::function<System(const Grid& grid, int degree, Threads& threads)>;

    std::vector<Field> fields;
    OnGrid on_grid;
    int degree = 1;  ///< as System::degree of the run
    bool noisy = false;
    double shortest = 0.0;  ///< wavenumber [1/mm] up to which the error needs modes of its own: those that are unstable
    /// First components of vectors that noise turns together without limit, in the direction of the mean of the first:
    /// errors of that direction change no mean, and are left out.
    std::vector<int> turning = {};
};

/// The grid on which the error evolves: with modes up to the wavenumber `shortest` [1/mm] on both axes where the fine
/// grid has them.  With noise all modes are kept: see sampled_modes().  A grid that is larger for its shortest waves
/// keeps two thirds at least: of products of more than two only those of the shortest waves are wrong there.
KeptGrid coarse_grid(const Grid& fine, int degree, bool noisy, double shortest);

struct ModePair {
    std::size_t coarse, fine;
    bool conjugate = false;
};

/// The modes of the coarse grid, but those that the fine grid does not keep.
std::vector<ModePair> shared_modes(const KeptGrid& coarse, const KeptGrid& fine);

/// The sum of all modes of the fine grid that look like one of the coarse grid at its points: the values of the fields
/// there.  Without the fluctuations that noise gives to short waves the error would relax otherwise: b |p|^2 would be
/// too small.
std::vector<ModePair> sampled_modes(const Grid& coarse, const KeptGrid& fine);

/// A mode of the coarse grid whose phase turns within a step: errors of a constant drive would cancel, while those of
/// its own steps turn with it and add up.
struct FastWave {
    std::size_t mode;
    double kept;         ///< of its amplitude after a step, at most 1
    bool is_unresolved;  ///< its phase turns by more than a radian even in half a step
};

/// The fast waves of a linear system on a grid.
std::vector<FastWave> fast_waves(const System& system, double dt);

/// Fields on the coarse grid along which the error evolves.
struct Reference {
    Spectra fields, rate;  // and their explicit terms, N(a)
    Spectra motion;        // L a + N(a), at the ends of a step without noise
    double t = 0.0;
    double step = 0.0;  // of the error, for which `rate` is; 0 for none: N may depend on it
};

/// The sum of a function of the kept modes over all modes of real fields.
template <class OfMode>
double sum_over_modes(const KeptGrid& on, OfMode of_mode) {
    double once = 0.0, twice = 0.0;
    for_kept_rows(on, [&](std::size_t first, std::size_t count) {
        once += of_mode(first);  // of their own conjugates; a kept mode is never the shortest
        for (std::size_t mode = first + 1; mode < first + count; ++mode) twice += of_mode(mode);
    });
    return once + 2.0 * twice;
}

/// One field: a scalar, or both components of a vector.
struct FieldSize {
    int first, count;
    std::string name;
    double size = 0.0;     ///< root mean square now
    double largest = 0.0;  ///< the largest so far: a field that has all but vanished has no size of its own
    double start = 0.0;    ///< at the start of the run
    double before = 0.0;   ///< before the step of the last local error; no checkpoint has it
    double local = 0.0, local_low = 0.0;   ///< the last local error, and its part on the coarse grid
    double low_sum = 0.0, high_sum = 0.0;  ///< of all steps so far: of that part, and of the other
    double short_waves = 0.0;              ///< root mean square beyond the coarse grid, lately
    double memory = INFINITY;              ///< steps for which an error beyond the coarse grid persists
    // Of the moments so far: the steps they stand for, the sums of the mean squares and of the means over the cell.
    double moments = 0.0, squares = 0.0;
    std::array<double, 2> means{};
    double variance = 0.0;  ///< over the cell, now

    /// The root mean square of the field, or of its error.
    double size_of(const Spectra& spectra, const KeptGrid& on) const;
    /// Takes the fields as they are now, for `weight` steps.
    void add_moment(const Spectra& fields, const KeptGrid& on, bool noisy, double weight);

    /// Deviation from the mean over the cell and over time.  An error of the mean is compared with it, too.
    double fluctuation() const {
        const double mean = std::hypot(means[0], means[1]) / moments;
        const double square = moments > 0.0 ? squares / moments - mean * mean : 0.0;
        constexpr double negligible = 1e-5;  // of the largest: the rest of what has relaxed
        return std::max(std::sqrt(std::max(square, variance)), negligible * largest);
    }
    /// With its fluctuation: an oscillation that passes through 0 has errors as large as before.
    double scale() const { return std::max({size, moments > 0.0 ? fluctuation() : 0.0, 1e-3 * largest}); }
    double local_high() const { return std::sqrt(std::max(0.0, local * local - local_low * local_low)); }
};
inline double ratio(double error, double scale) { return error == 0.0 ? 0.0 : scale > 0.0 ? error / scale : INFINITY; }

/// The last two errors of a single step on the coarse grid, and, with what the steps changed in the fields, the last
/// and an earlier one whose change was another.
struct LocalErrors {
    Spectra last, before, other;
    Spectra motion, other_motion;  ///< the change in the step of `last`, of `other`
    double trend = 1.0;            ///< the factor between their sizes, within limits
    double angle = 0.0;            ///< between them [radians]

    /// Takes the error of a step.  sizes: of all errors now and before, in the units of `fields`.
    void add(const Spectra& local, const Spectra& change, double size_now, double size_before,
             const std::vector<FieldSize>& fields, const KeptGrid& coarse);

    /// The mean error of a step up to the next that is measured, `intervals` times as many steps as between the last
    /// two.  Errors fall or rise as they have done, in the geometric mean, and turn as they have done, in the plane of
    /// the last two.
    void predict(double intervals, Spectra& mean) const;

    /// The error of a step that changes the fields by `change`: a sum of `last` and `other`, as the change is one of
    /// theirs.  That holds for oscillations, waves and decays.  False, and nothing, where the change is no such sum.
    bool follow(const Spectra& change, const std::vector<FieldSize>& fields, const KeptGrid& coarse,
                Spectra& error) const;
};

/// The angle between two states [radians], and the sum of products of their modes, in the units of `fields`.
double angle_between(const Spectra& a, const Spectra& b, const std::vector<FieldSize>& fields, const KeptGrid& on);
double product_of(const Spectra& a, const Spectra& b, const std::vector<FieldSize>& fields, const KeptGrid& on);

}  // namespace drover::numerics
