// numerics/transform.cpp: real transforms in two dimensions, by FFTW along rows and along strips of columns.
#include "drover/numerics/transform.hpp"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
constexpr int strip_rows = 8;  // transformed by one call; a strip of 1024 columns is 128 kB, in the second-level cache
constexpr int strip_columns = 8;  // 128 bytes of each row: two cache lines; a strip of 1024 rows is 128 kB

struct PlanDeleter {
    void operator()(fftw_plan plan) const { fftw_destroy_plan(plan); }
};
using Plan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, PlanDeleter>;

fftw_complex* raw(Complex* values) { return reinterpret_cast<fftw_complex*>(values); }

/// FFTW's planner is one for the whole process and not safe for threads; executing plans is.
std::mutex& planner_mutex() {
    static std::mutex mutex;
    return mutex;
}

/// Room for a strip of columns, one for each thread: a column of a large grid by itself strides over more lines than a cache holds.
Complex* strip_buffer(std::size_t rows) {
    thread_local std::vector<Complex> buffer;
    buffer.resize(std::max(buffer.size(), rows * strip_columns));
    return buffer.data();
}

/// Lines of one strip length, and of the shorter strip at the end if there is one.
struct StripPlans {
    int length = 1;
    Plan whole, rest;
    fftw_plan of(std::size_t begin, std::size_t end) const {
        return static_cast<int>(end - begin) == length ? whole.get() : rest.get();
    }
};

template <class Make>
StripPlans make_strips(int lines, int length, Make make) {
    StripPlans plans{.length = std::min(length, lines), .whole = {}, .rest = {}};
    plans.whole.reset(make(plans.length));
    if (const int rest = lines % plans.length; rest != 0) plans.rest.reset(make(rest));
    return plans;
}
}  // namespace

struct Transform::Plans {
    Grid grid;
    int degree;
    Threads& threads;
    int kept_columns = 0;
    StripPlans rows_forward, rows_backward, columns_forward, columns_backward;
    std::vector<Complex> scratch;
    std::vector<double> row_scale;  // 1 for rows of kept modes, else 0

    Plans(const Grid& the_grid, int the_degree, Threads& the_threads);
    void forward_rows(const Fields& from, Spectra& to, int first, int count);
    void forward_columns(Spectra& to, int first, int count);
    void backward_columns(const Spectra& from, int first, int count);
    void backward_rows(Fields& to, int first, int count);

    /// body(component, begin, end) for every strip of `lines` lines of `count` components.
    template <class Body>
    void for_strips(int count, int lines, int length, Body body) {
        const auto total = static_cast<std::size_t>(lines), size = static_cast<std::size_t>(length);
        const std::size_t strips = (total + size - 1) / size;
        threads.for_chunks(strips * static_cast<std::size_t>(count), 1, [&](std::size_t task, std::size_t) {
            const std::size_t begin = (task % strips) * size;
            body(static_cast<int>(task / strips), begin, std::min(begin + size, total));
        });
    }
};

Transform::Plans::Plans(const Grid& the_grid, int the_degree, Threads& the_threads)
    : grid(the_grid), degree(the_degree), threads(the_threads) {
    check(grid);
    require(degree >= 1, {}, "transform: degree = {}; expected >= 1", degree);
    for (std::size_t i = 0; i < columns(grid); ++i)
        if (is_kept(grid, degree, i, 0)) kept_columns = static_cast<int>(i) + 1;
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        row_scale.push_back(is_kept(grid, degree, 0, j) ? 1.0 : 0.0);
    scratch.resize(modes(grid));
    const int width = static_cast<int>(columns(grid));
    Fields real(grid, 1);
    const std::lock_guard lock(planner_mutex());
    rows_forward = make_strips(grid.ny, strip_rows, [&](int n) {
        return fftw_plan_many_dft_r2c(1, &grid.nx, n, real.values.data(), nullptr, 1, grid.nx, raw(scratch.data()),
                                      nullptr, 1, width, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
    });
    rows_backward = make_strips(grid.ny, strip_rows, [&](int n) {
        return fftw_plan_many_dft_c2r(1, &grid.nx, n, raw(scratch.data()), nullptr, 1, width, real.values.data(),
                                      nullptr, 1, grid.nx, FFTW_ESTIMATE | FFTW_DESTROY_INPUT);
    });
    // In place in a strip's own buffer, [ny][strip_columns].
    std::vector<Complex> strip(static_cast<std::size_t>(grid.ny) * strip_columns);
    const auto columns_plan = [&](int direction) {
        return make_strips(kept_columns, strip_columns, [&, direction](int n) {
            return fftw_plan_many_dft(1, &grid.ny, n, raw(strip.data()), nullptr, strip_columns, 1, raw(strip.data()),
                                      nullptr, strip_columns, 1, direction, FFTW_ESTIMATE);
        });
    };
    columns_forward = columns_plan(FFTW_FORWARD);
    columns_backward = columns_plan(FFTW_BACKWARD);
}

void Transform::Plans::forward_rows(const Fields& from, Spectra& to, int first, int count) {
    const std::size_t width = columns(grid), nx = static_cast<std::size_t>(grid.nx);
    for_strips(count, grid.ny, rows_forward.length, [&](int c, std::size_t begin, std::size_t end) {
        // PRESERVE_INPUT: FFTW's interface has no const, but the plan does not write its input.
        auto* values = const_cast<double*>(from[first + c].data());
        fftw_execute_dft_r2c(rows_forward.of(begin, end), values + begin * nx,
                             raw(to[first + c].data() + begin * width));
    });
}

void Transform::Plans::forward_columns(Spectra& to, int first, int count) {
    const std::size_t width = columns(grid), rows = static_cast<std::size_t>(grid.ny),
                      kept = static_cast<std::size_t>(kept_columns);
    const double scale = 1.0 / static_cast<double>(points(grid));
    for_strips(count, kept_columns, columns_forward.length, [&](int c, std::size_t begin, std::size_t end) {
        Complex* values = to[first + c].data() + begin;
        Complex* strip = strip_buffer(rows);
        const std::size_t length = end - begin;
        for (std::size_t j = 0; j < rows; ++j) std::copy_n(values + j * width, length, strip + j * strip_columns);
        fftw_execute_dft(columns_forward.of(begin, end), raw(strip), raw(strip));
        for (std::size_t j = 0; j < rows; ++j)
            for (std::size_t i = 0; i < length; ++i)
                values[j * width + i] = row_scale[j] * scale * strip[j * strip_columns + i];
    });
    for (int c = 0; c < count; ++c)
        for (std::size_t j = 0; j < rows; ++j)
            std::fill_n(to[first + c].data() + j * width + kept, width - kept, Complex(0.0));
}

void Transform::Plans::backward_columns(const Spectra& from, int first, int count) {
    const std::size_t width = columns(grid), rows = static_cast<std::size_t>(grid.ny), size = modes(grid);
    for_strips(count, kept_columns, columns_backward.length, [&](int c, std::size_t begin, std::size_t end) {
        const Complex* values = from[first + c].data() + begin;
        Complex* out = scratch.data() + static_cast<std::size_t>(c) * size + begin;
        Complex* strip = strip_buffer(rows);
        const std::size_t length = end - begin;
        for (std::size_t j = 0; j < rows; ++j)
            for (std::size_t i = 0; i < length; ++i)
                strip[j * strip_columns + i] = row_scale[j] == 0.0 ? Complex(0.0) : values[j * width + i];
        fftw_execute_dft(columns_backward.of(begin, end), raw(strip), raw(strip));
        for (std::size_t j = 0; j < rows; ++j) std::copy_n(strip + j * strip_columns, length, out + j * width);
    });
}

void Transform::Plans::backward_rows(Fields& to, int first, int count) {
    const std::size_t width = columns(grid), nx = static_cast<std::size_t>(grid.nx), size = modes(grid);
    const std::size_t kept = static_cast<std::size_t>(kept_columns);
    for_strips(count, grid.ny, rows_backward.length, [&](int c, std::size_t begin, std::size_t end) {
        Complex* values = scratch.data() + static_cast<std::size_t>(c) * size;
        for (std::size_t j = begin; j < end; ++j)
            std::fill(values + j * width + kept, values + (j + 1) * width, Complex(0.0));
        fftw_execute_dft_c2r(rows_backward.of(begin, end), raw(values + begin * width),
                             to[first + c].data() + begin * nx);
    });
}

Transform::Transform(const Grid& grid, int degree, Threads& threads)
    : plans_(std::make_unique<Plans>(grid, degree, threads)) {}
Transform::~Transform() = default;

const Grid& Transform::grid() const { return plans_->grid; }

// One thread takes a component at a time, which stays in its cache; several take the strips of all components.
void Transform::forward(const Fields& from, Spectra& to) const {
    const int together = plans_->threads.count() == 1 ? 1 : from.count();
    for (int c = 0; c < from.count(); c += together) {
        plans_->forward_rows(from, to, c, together);
        plans_->forward_columns(to, c, together);
    }
}

void Transform::backward(const Spectra& from, Fields& to) const {
    const int together = plans_->threads.count() == 1 ? 1 : from.count();
    plans_->scratch.resize(std::max(plans_->scratch.size(), static_cast<std::size_t>(together) * modes(plans_->grid)));
    for (int c = 0; c < from.count(); c += together) {
        plans_->backward_columns(from, c, together);
        plans_->backward_rows(to, c, together);
    }
}

std::string transform_library() { return fftw_version; }

}  // namespace drover::numerics
