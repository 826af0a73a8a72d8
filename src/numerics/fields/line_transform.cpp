// numerics/fields/line_transform.cpp: plans of FFTW for lines, and long lines in two passes.
#include "numerics/fields/line_transform.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "drover/base/threads.hpp"
#include "numerics/fields/per_thread.hpp"

namespace drover::numerics {

namespace {
fftw_complex* raw(Complex* values) { return reinterpret_cast<fftw_complex*>(values); }

/// The FFTW planner is global and not thread-safe, nor is the destruction of plans; their execution is.
std::mutex& planner_mutex() {
    static std::mutex& mutex = new_mutex_over_forks();
    return mutex;
}

/// Work arrays of one thread.
struct LineBuffers {
    Aligned<Complex> between, lines;
};
LineBuffers& line_buffers() {
    static PerThread<LineBuffers> buffers;
    return buffers.get();
}

Plan line_plan(std::size_t lines, std::size_t length, std::size_t distance, int sign_of_exponent) {
    Aligned<Complex> from, to;
    fftw_complex *const in = raw(from.buffer(lines * distance)), *const out = raw(to.buffer(lines * distance));
    const auto n = static_cast<int>(length), between = static_cast<int>(distance);
    const std::lock_guard lock(planner_mutex());
    return Plan(fftw_plan_many_dft(1, &n, static_cast<int>(lines), in, nullptr, 1, between, out, nullptr, 1, between,
                                   sign_of_exponent, FFTW_ESTIMATE));
}

/// The larger factor of a length, the smaller being near its square root; 0: none is a multiple of 4.
std::size_t larger_factor(std::size_t length) {
    std::size_t factor = static_cast<std::size_t>(std::sqrt(static_cast<double>(length))) / 4 * 4;
    constexpr std::size_t smallest = 32;
    while (factor >= smallest && (length % factor != 0 || length / factor % 4 != 0)) factor -= 4;
    return factor < smallest ? 0 : length / factor;
}

}  // namespace

void* allocate_line(std::size_t bytes) { return fftw_malloc(bytes); }
void free_line(void* values) { fftw_free(values); }

void PlanDeleter::operator()(fftw_plan_s* plan) const {
    const std::lock_guard lock(planner_mutex());
    fftw_destroy_plan(plan);
}

LineTransform::LineTransform(std::size_t length, std::size_t distance, int sign_of_exponent)
    : length_(length), distance_(distance) {
    constexpr std::size_t long_line = 8192;  // longer ones do not fit in the second-level cache
    if (length == 1) return;
    second_ = length >= long_line ? larger_factor(length) : 0;
    if (second_ == 0) {
        four_ = line_plan(4, length, distance, sign_of_exponent);
        one_ = line_plan(1, length, distance, sign_of_exponent);
        return;
    }
    first_ = length / second_;
    of_first_ = line_plan(4, first_, first_ + 4, sign_of_exponent);
    of_second_ = line_plan(4, second_, second_ + 4, sign_of_exponent);
    const double turn = sign_of_exponent * 2.0 * std::numbers::pi / static_cast<double>(length);
    factors_.reserve(length);
    for (std::size_t i = 0; i < second_; i += 4)
        for (std::size_t k = 0; k < first_; ++k)
            for (std::size_t l = 0; l < 4; ++l)
                factors_.push_back(std::polar(1.0, turn * static_cast<double>((i + l) * k % length)));
}

void LineTransform::operator()(std::size_t lines, const Complex* from, Complex* to) const {
    if (length_ == 1) {
        std::copy_n(from, lines, to);
        return;
    }
    for (std::size_t i = 0; i < lines;) {
        const bool is_four = four_ && i + 4 <= lines;
        const Complex* line = from + i * distance_;
        if (second_ != 0) in_two_passes(line, to + i * distance_);
        else
            fftw_execute_dft(is_four ? four_.get() : one_.get(), raw(const_cast<Complex*>(line)),
                             raw(to + i * distance_));
        i += is_four ? 4 : 1;
    }
}

/// The four-step transform: Bailey, J. Supercomput. 4, 23 (1990).
void LineTransform::in_two_passes(const Complex* from, Complex* to) const {
    const std::size_t first = first_ + 4, second = second_ + 4;  // a power of two would conflict in the cache
    Complex* between = line_buffers().between.buffer(first_ * second);
    Complex *in = line_buffers().lines.buffer(8 * second), *out = in + 4 * second;
    const Complex* factor = factors_.data();
    for (std::size_t i = 0; i < second_; i += 4) {
        for (std::size_t r = 0; r < first_; ++r) {
            __builtin_prefetch(from + r * second_ + i + 4);
            spread_line(from + r * second_ + i, in + r, first);
        }
        fftw_execute_dft(of_first_.get(), raw(in), raw(out));
        for (std::size_t k = 0; k < first_; ++k)
            for (std::size_t l = 0; l < 4; ++l, ++factor) {
                const Pair z = load(out + l * first + k), w = load(factor);
                store(z * Pair{w[0], w[0]} + times_i(z) * Pair{w[1], w[1]}, between + k * second + i + l);
            }
    }
    for (std::size_t k = 0; k < first_; k += 4) {
        fftw_execute_dft(of_second_.get(), raw(between + k * second), raw(out));
        for (std::size_t r = 0; r < second_; ++r) collect_line(out + r, second, to + r * first_ + k);
    }
}

const char* line_library() { return fftw_version; }

}  // namespace drover::numerics
