// numerics/transform.hpp: Fourier transforms between Fields and Spectra.
#pragma once
#include <memory>
#include <string>

#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// Real transforms on one grid.  Rows and columns are transformed in strips that depend on the grid alone, so any
/// number of threads gives the same bytes.  Columns of modes that are not kept are skipped, not transformed.
class Transform {
public:
    /// degree: of the products formed in real space; modes with |k| >= N/(degree + 1) on an axis are zero in every Spectra
    /// that forward() writes and are taken as zero by backward().
    Transform(const Grid& grid, int degree, Threads& threads);
    ~Transform();
    Transform(const Transform&) = delete;
    Transform& operator=(const Transform&) = delete;

    const Grid& grid() const;

    /// Fourier coefficients of each component.  `from` is not changed.
    void forward(const Fields& from, Spectra& to) const;

    /// Values on the grid of each component.  `from` is not changed.
    void backward(const Spectra& from, Fields& to) const;

private:
    struct Plans;
    std::unique_ptr<Plans> plans_;
};

/// The library that does it, with its version.
std::string transform_library();

}  // namespace drover::numerics
