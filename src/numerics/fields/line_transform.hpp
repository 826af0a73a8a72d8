// numerics/fields/line_transform.hpp: complex transforms of lines, by FFTW, and aligned memory for them.
#pragma once
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "numerics/fields/complex_registers.hpp"

struct fftw_plan_s;  // what fftw_plan points to

namespace drover::numerics {

inline constexpr std::size_t line_rows = 4;  // of one column: a cache line

void* allocate_line(std::size_t bytes);  // null where memory is short
void free_line(void* values);

const char* line_library();  // name and version of FFTW

/// Memory aligned for the vector instructions of FFTW; every array in it starts on a cache line.
template <class Number>
class Aligned {
public:
    Number* buffer(std::size_t count) {
        if (count > size_) {
            values_.reset(static_cast<Number*>(allocate_line(count * sizeof(Number) + line)));
            if (!values_) throw std::bad_alloc();
            size_ = count;
        }
        const auto address = reinterpret_cast<std::uintptr_t>(values_.get());
        return reinterpret_cast<Number*>((address + line - 1) / line * line);
    }

private:
    static constexpr std::uintptr_t line = 64;
    struct Free {
        void operator()(void* values) const { free_line(values); }
    };
    std::unique_ptr<Number, Free> values_;
    std::size_t size_ = 0;
};

/// Four rows of one column, a cache line, to consecutive rows, and back.
inline void spread_line(const Complex* from, Complex* to, std::size_t row) {
    for (std::size_t j = 0; j < line_rows; ++j) store(load(from + j), to + j * row);
}
inline void collect_line(const Complex* from, std::size_t row, Complex* to) {
    for (std::size_t j = 0; j < line_rows; ++j) store(load(from + j * row), to + j);
}

struct PlanDeleter {
    void operator()(fftw_plan_s* plan) const;
};
using Plan = std::unique_ptr<fftw_plan_s, PlanDeleter>;

/// Of lines of complex numbers at a distance that is a multiple of 32 bytes, or of single numbers.  The plans are
/// estimated, not measured: which plan is fastest varies between runs, and with it the last bits of the results.
class LineTransform {
public:
    LineTransform() = default;
    LineTransform(std::size_t length, std::size_t distance, int sign_of_exponent);
    void operator()(std::size_t lines, const Complex* from, Complex* to) const;

private:
    void in_two_passes(const Complex* from, Complex* to) const;

    std::size_t length_ = 1, distance_ = 1;
    std::size_t first_ = 0, second_ = 0;  // a long line is a matrix of first_ rows of second_ numbers
    Plan four_, one_, of_first_, of_second_;
    std::vector<Complex> factors_;  // [second / 4][first][4]
};

}  // namespace drover::numerics
