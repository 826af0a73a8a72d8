// numerics/steppers/local_errors.hpp: the errors of single steps, and what those of the steps to come are likely to be.
#pragma once
#include <vector>

#include "drover/numerics/grid.hpp"
#include "numerics/steppers/coarse_error.hpp"

namespace drover::numerics {

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
