// numerics/transform.hpp: Fourier transforms between Fields and Spectra, and products formed in between.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// Consecutive points of the grid: values there of the arrays that came and of those that go.
struct Strip {
    std::size_t first = 0, size = 0;    ///< points first, ..., first + size - 1
    std::span<const double* const> in;  ///< [array][point]
    std::span<double* const> out;       ///< [array][point], to be written whole
};

/// Real transforms on one grid, of two real arrays at a time as the parts of a complex one.  Rows and columns are transformed
/// in strips that depend on the grid alone, so any number of threads gives the same bytes.  Columns of modes that are not
/// kept are skipped, not transformed.
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

    /// Brings `from` to the grid, a few rows at a time; calls work for each such strip while it is in the cache, on any
    /// thread; and takes what it made to `to`.  Writes the kept modes of `to` alone: the others must be zero already.
    void products(std::span<const Complex* const> from, std::span<Complex* const> to,
                  const std::function<void(const Strip&)>& work) const;

private:
    struct Plans;
    std::unique_ptr<Plans> plans_;
};

/// The library that does it, with its version.
std::string transform_library();

}  // namespace drover::numerics
