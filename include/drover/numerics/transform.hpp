// numerics/transform.hpp: Fourier transforms between Fields and Spectra, and products formed in between.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// Consecutive points of the grid: values of the input and output arrays there.
struct Strip {
    std::size_t first = 0, size = 0;    ///< points first, ..., first + size - 1
    std::span<const double* const> in;  ///< [array][point]
    std::span<double* const> out;       ///< [array][point], to be written completely
};

/// Real transforms on one grid: two real arrays are packed into one complex array.  Rows and columns are transformed in
/// strips that depend only on the grid, so the bytes do not depend on the number of threads.  Columns of modes that are
/// not kept are skipped.
class Transform {
public:
    /// `threads` must outlive it.  degree: of the products formed in real space; modes with |k| >= N/(degree + 1) on an
    /// axis are zero in every Spectra that forward() writes, and backward() takes them as zero.
    Transform(const Grid& grid, int degree, Threads& threads);
    ~Transform();
    Transform(const Transform&) = delete;
    Transform& operator=(const Transform&) = delete;

    const Grid& grid() const;

    /// Fourier coefficients of each component.  `from` is not changed.  Throws an input Error for arrays of another
    /// grid, or of different numbers of components.
    void forward(const Fields& from, Spectra& to) const;

    /// Values on the grid of each component.  `from` is not changed.  Throws as forward().
    void backward(const Spectra& from, Fields& to) const;

    /// Transforms `from` to the grid, a few rows at a time, calls `work` for each such strip while it is in the cache,
    /// on any thread, and transforms its output to `to`.  Writes only the kept modes of `to`: the others must be zero
    /// already.
    void products(std::span<const Complex* const> from, std::span<Complex* const> to,
                  const std::function<void(const Strip&)>& work) const;

private:
    struct Plans;
    std::unique_ptr<Plans> plans_;
};

/// Name and version of the transform library.
std::string transform_library();

}  // namespace drover::numerics
