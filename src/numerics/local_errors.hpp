// numerics/local_errors.hpp: the errors of single steps, and what those of the steps to come are likely to be.
#pragma once
#include <vector>

#include "drover/numerics/grid.hpp"
#include "numerics/coarse_error.hpp"

namespace drover::numerics {

/// The last two errors of a single step on the coarse grid.
struct LocalErrors {
    Spectra last, before;
    double trend = 1.0;  ///< the factor between their sizes, within limits
    double angle = 0.0;  ///< between them [radians]

    /// Takes the error of a step.  sizes: of all errors now and before, in the units of `fields`.
    void add(const Spectra& local, double size_now, double size_before, const std::vector<FieldSize>& fields,
             const Grid& coarse);

    /// The mean error of a step up to the next that is measured, `intervals` times as many steps as between the last
    /// two.  Errors fall or rise as they have done, in the geometric mean, and turn as they have done, in the plane of
    /// the last two.
    void predict(double intervals, Spectra& mean) const;
};

}  // namespace drover::numerics
