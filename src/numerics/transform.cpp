// numerics/transform.cpp: real transforms in two dimensions, by FFTW along rows (two real rows as one complex) and
// columns.
#include "drover/numerics/transform.hpp"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
constexpr std::size_t strip_columns = 8;       // 128 bytes of each row: two cache lines; a strip of 1024 rows is 128 kB
constexpr std::size_t points_in_strip = 1024;  // of rows: fifteen arrays of it are in the second-level cache

struct PlanDeleter {
    void operator()(fftw_plan plan) const { fftw_destroy_plan(plan); }
};
using Plan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, PlanDeleter>;

fftw_complex* raw(Complex* values) { return reinterpret_cast<fftw_complex*>(values); }

/// The FFTW planner is global and not thread-safe; the execution of plans is.
std::mutex& planner_mutex() {
    static std::mutex mutex;
    return mutex;
}

/// Memory aligned for the vector instructions of FFTW; every array in it starts on a cache line.
template <class Number>
class Aligned {
public:
    Number* room(std::size_t count) {
        if (count > size_) {
            values_.reset(static_cast<Number*>(fftw_malloc(count * sizeof(Number) + line)));
            if (!values_) throw std::bad_alloc();
            size_ = count;
        }
        const auto address = reinterpret_cast<std::uintptr_t>(values_.get());
        return reinterpret_cast<Number*>((address + line - 1) / line * line);
    }

private:
    static constexpr std::uintptr_t line = 64;
    struct Free {
        void operator()(void* values) const { fftw_free(values); }
    };
    std::unique_ptr<Number, Free> values_;
    std::size_t size_ = 0;
};

/// A few consecutive numbers: usually a complete strip, whose size is then a compile-time constant.
void copy_strip(const Complex* from, std::size_t count, Complex* to) {
    if (count == strip_columns)
        for (std::size_t i = 0; i < strip_columns; ++i) to[i] = from[i];
    else std::copy_n(from, count, to);
}

/// Work arrays of one thread.
struct Workspace {
    Aligned<Complex> columns, packed, transformed;
    Aligned<double> points;
    std::vector<const double*> in;
    std::vector<double*> out;
};
Workspace& workspace() {
    thread_local Workspace mine;
    return mine;
}

/// Transforms of `length` numbers: of a complete strip, and of a shorter strip at the end if there is one.
struct StripPlans {
    std::size_t lines = 1, strip = 1;
    Plan whole, rest;
    std::size_t count() const { return (lines + strip - 1) / strip; }
    std::size_t begin(std::size_t number) const { return number * strip; }
    std::size_t size(std::size_t number) const { return std::min(strip, lines - begin(number)); }
    void execute(std::size_t number, Complex* from, Complex* to) const {
        fftw_execute_dft(size(number) == strip ? whole.get() : rest.get(), raw(from), raw(to));
    }
};

template <class Make>
StripPlans make_strips(std::size_t lines, std::size_t strip, Make make) {
    StripPlans plans{.lines = lines, .strip = std::min(strip, lines), .whole = {}, .rest = {}};
    plans.whole.reset(make(static_cast<int>(plans.strip)));
    if (const std::size_t rest = lines % plans.strip; rest != 0) plans.rest.reset(make(static_cast<int>(rest)));
    return plans;
}
}  // namespace

struct Transform::Plans {
    Grid grid;
    Threads& threads;
    std::size_t nx, ny, width;        // points, and stored modes of a row
    std::size_t kept = 0, pitch = 0;  // kept columns, and their size in scratch: complete cache lines
    std::vector<std::size_t> kept_rows;
    std::size_t first_cut_row = 0;  // the rows that are not kept are contiguous
    StripPlans rows_forward, rows_backward, columns_forward, columns_backward;
    Aligned<Complex> scratch_in, scratch_out;  // [array][row][kept column], between rows and columns

    Plans(const Grid& the_grid, int degree, Threads& the_threads);
    void backward_columns(std::span<const Complex* const> from, Complex* scratch);
    void forward_columns(const Complex* scratch, std::span<Complex* const> to);
    void unpack_rows(const Complex* scratch, std::size_t strip, std::span<double* const> arrays);
    void pack_rows(std::span<const double* const> arrays, std::size_t strip, Complex* scratch);
    std::size_t scratch_size(std::size_t arrays) const { return arrays * ny * pitch; }

    /// body(array, strip) for every strip of columns of every array.
    template <class Body>
    void for_columns(std::size_t arrays, const StripPlans& strips, Body body) {
        threads.for_chunks(arrays * strips.count(), 1,
                           [&](std::size_t task, std::size_t) { body(task / strips.count(), task % strips.count()); });
    }
};

Transform::Plans::Plans(const Grid& the_grid, int degree, Threads& the_threads) : grid(the_grid), threads(the_threads) {
    check(grid);
    require(degree >= 1, {}, "transform: degree = {}; expected >= 1", degree);
    nx = static_cast<std::size_t>(grid.nx);
    ny = static_cast<std::size_t>(grid.ny);
    width = columns(grid);
    for (std::size_t i = 0; i < width; ++i)
        if (is_kept(grid, degree, i, 0)) kept = i + 1;
    for (std::size_t j = 0; j < ny; ++j)
        if (is_kept(grid, degree, 0, j)) kept_rows.push_back(j);
        else if (first_cut_row == 0) first_cut_row = j;
    pitch = (kept + 3) / 4 * 4;
    const std::size_t rows = std::clamp<std::size_t>(points_in_strip / nx, 1, ny);
    Aligned<Complex> from, to;
    Complex *a = from.room(rows * nx), *b = to.room(rows * nx);
    const std::lock_guard lock(planner_mutex());
    const auto rows_plan = [&](int direction) {
        return make_strips(ny, rows, [&, direction](int n) {
            return fftw_plan_many_dft(1, &grid.nx, n, raw(a), nullptr, 1, grid.nx, raw(b), nullptr, 1, grid.nx,
                                      direction, FFTW_ESTIMATE);
        });
    };
    rows_forward = rows_plan(FFTW_FORWARD);
    rows_backward = rows_plan(FFTW_BACKWARD);
    // In the strip's own array, [ny][strip_columns]: a single column touches more cache lines than fit in the cache.
    constexpr int stride = static_cast<int>(strip_columns);
    Complex* strip = to.room(ny * strip_columns);
    const auto columns_plan = [&](int direction) {
        return make_strips(kept, strip_columns, [&, direction](int n) {
            return fftw_plan_many_dft(1, &grid.ny, n, raw(strip), nullptr, stride, 1, raw(strip), nullptr, stride, 1,
                                      direction, FFTW_ESTIMATE);
        });
    };
    columns_forward = columns_plan(FFTW_FORWARD);
    columns_backward = columns_plan(FFTW_BACKWARD);
}

void Transform::Plans::backward_columns(std::span<const Complex* const> from, Complex* scratch) {
    for_columns(from.size(), columns_backward, [&](std::size_t c, std::size_t number) {
        const std::size_t first = columns_backward.begin(number), count = columns_backward.size(number);
        Complex* strip = workspace().columns.room(ny * strip_columns);
        std::fill(strip + first_cut_row * strip_columns,
                  strip + (first_cut_row + ny - kept_rows.size()) * strip_columns, Complex(0.0));
        for (const std::size_t j : kept_rows) copy_strip(from[c] + j * width + first, count, strip + j * strip_columns);
        columns_backward.execute(number, strip, strip);
        Complex* out = scratch + c * ny * pitch + first;
        for (std::size_t j = 0; j < ny; ++j) copy_strip(strip + j * strip_columns, count, out + j * pitch);
    });
}

void Transform::Plans::forward_columns(const Complex* scratch, std::span<Complex* const> to) {
    const double scale = 1.0 / static_cast<double>(points(grid));
    for_columns(to.size(), columns_forward, [&](std::size_t c, std::size_t number) {
        const std::size_t first = columns_forward.begin(number), count = columns_forward.size(number);
        Complex* strip = workspace().columns.room(ny * strip_columns);
        const Complex* in = scratch + c * ny * pitch + first;
        for (std::size_t j = 0; j < ny; ++j) copy_strip(in + j * pitch, count, strip + j * strip_columns);
        columns_forward.execute(number, strip, strip);
        for (const std::size_t j : kept_rows)
            for (std::size_t i = 0; i < count; ++i) to[c][j * width + first + i] = scale * strip[j * strip_columns + i];
    });
}

/// Two real arrays a, b are the parts of the complex one whose modes are A_k + i B_k, and at -k conj(A_k) + i
/// conj(B_k).
void Transform::Plans::unpack_rows(const Complex* scratch, std::size_t strip, std::span<double* const> arrays) {
    const std::size_t first = rows_backward.begin(strip), count = rows_backward.size(strip);
    Complex *packed = workspace().packed.room(rows_backward.strip * nx),
            *values = workspace().transformed.room(rows_backward.strip * nx);
    for (std::size_t c = 0; c < arrays.size(); c += 2) {
        const bool is_pair = c + 1 < arrays.size();
        for (std::size_t j = 0; j < count; ++j) {
            const Complex* a = scratch + (c * ny + first + j) * pitch;
            const Complex* b = a + ny * pitch;
            Complex* z = packed + j * nx;
            std::fill(z + kept, z + nx - kept + 1, Complex(0.0));
            if (is_pair) {
                z[0] = {a[0].real(), b[0].real()};
                for (std::size_t k = 1; k < kept; ++k) {
                    z[k] = {a[k].real() - b[k].imag(), a[k].imag() + b[k].real()};
                    z[nx - k] = {a[k].real() + b[k].imag(), b[k].real() - a[k].imag()};
                }
            } else {
                z[0] = a[0].real();
                for (std::size_t k = 1; k < kept; ++k) {
                    z[k] = a[k];
                    z[nx - k] = std::conj(a[k]);
                }
            }
        }
        rows_backward.execute(strip, packed, values);
        for (std::size_t i = 0; i < count * nx; ++i) arrays[c][i] = values[i].real();
        if (!is_pair) continue;
        for (std::size_t i = 0; i < count * nx; ++i) arrays[c + 1][i] = values[i].imag();
    }
}

void Transform::Plans::pack_rows(std::span<const double* const> arrays, std::size_t strip, Complex* scratch) {
    const std::size_t first = rows_forward.begin(strip), count = rows_forward.size(strip);
    Complex *values = workspace().packed.room(rows_forward.strip * nx),
            *z_rows = workspace().transformed.room(rows_forward.strip * nx);
    for (std::size_t c = 0; c < arrays.size(); c += 2) {
        const bool is_pair = c + 1 < arrays.size();
        const double* second = is_pair ? arrays[c + 1] : nullptr;
        for (std::size_t i = 0; i < count * nx; ++i) values[i] = {arrays[c][i], second ? second[i] : 0.0};
        rows_forward.execute(strip, values, z_rows);
        for (std::size_t j = 0; j < count; ++j) {
            Complex* a = scratch + (c * ny + first + j) * pitch;
            const Complex* z = z_rows + j * nx;
            a[0] = z[0].real();
            for (std::size_t k = 1; k < kept; ++k)
                a[k] = {0.5 * (z[k].real() + z[nx - k].real()), 0.5 * (z[k].imag() - z[nx - k].imag())};
            if (!is_pair) continue;
            Complex* b = a + ny * pitch;
            b[0] = z[0].imag();
            for (std::size_t k = 1; k < kept; ++k)
                b[k] = {0.5 * (z[k].imag() + z[nx - k].imag()), 0.5 * (z[nx - k].real() - z[k].real())};
        }
    }
}

Transform::Transform(const Grid& grid, int degree, Threads& threads)
    : plans_(std::make_unique<Plans>(grid, degree, threads)) {}
Transform::~Transform() = default;

const Grid& Transform::grid() const { return plans_->grid; }

void Transform::forward(const Fields& from, Spectra& to) const {
    Plans& p = *plans_;
    // Two at a time, so that they stay in the cache.
    for (int c = 0; c < from.count(); c += 2) {
        const int count = std::min(2, from.count() - c);
        Complex* scratch = p.scratch_out.room(p.scratch_size(2));
        std::vector<const double*> arrays;
        std::vector<Complex*> spectra;
        for (int i = c; i < c + count; ++i) {
            arrays.push_back(from[i].data());
            spectra.push_back(to[i].data());
            std::fill(to[i].begin(), to[i].end(), Complex(0.0));
        }
        p.threads.for_chunks(p.rows_forward.count(), 1, [&](std::size_t strip, std::size_t) {
            std::vector<const double*> rows;
            for (const double* array : arrays) rows.push_back(array + p.rows_forward.begin(strip) * p.nx);
            p.pack_rows(rows, strip, scratch);
        });
        p.forward_columns(scratch, spectra);
    }
}

void Transform::backward(const Spectra& from, Fields& to) const {
    Plans& p = *plans_;
    for (int c = 0; c < from.count(); c += 2) {
        const int count = std::min(2, from.count() - c);
        Complex* scratch = p.scratch_in.room(p.scratch_size(2));
        std::vector<const Complex*> spectra;
        std::vector<double*> arrays;
        for (int i = c; i < c + count; ++i) {
            spectra.push_back(from[i].data());
            arrays.push_back(to[i].data());
        }
        p.backward_columns(spectra, scratch);
        p.threads.for_chunks(p.rows_backward.count(), 1, [&](std::size_t strip, std::size_t) {
            std::vector<double*> rows;
            for (double* array : arrays) rows.push_back(array + p.rows_backward.begin(strip) * p.nx);
            p.unpack_rows(scratch, strip, rows);
        });
    }
}

void Transform::products(std::span<const Complex* const> from, std::span<Complex* const> to,
                         const std::function<void(const Strip&)>& work) const {
    Plans& p = *plans_;
    Complex *in = p.scratch_in.room(p.scratch_size(from.size())), *out = p.scratch_out.room(p.scratch_size(to.size()));
    p.backward_columns(from, in);
    p.threads.for_chunks(p.rows_backward.count(), 1, [&](std::size_t strip, std::size_t) {
        Workspace& mine = workspace();
        const std::size_t room = p.rows_backward.strip * p.nx;
        double* points = mine.points.room((from.size() + to.size()) * room);
        mine.out.clear();
        for (std::size_t c = 0; c < from.size() + to.size(); ++c) mine.out.push_back(points + c * room);
        mine.in.assign(mine.out.begin(), mine.out.end());
        const std::span<double* const> arrays(mine.out);
        p.unpack_rows(in, strip, arrays.first(from.size()));
        const std::span<const double* const> read(mine.in);
        work({.first = p.rows_backward.begin(strip) * p.nx,
              .size = p.rows_backward.size(strip) * p.nx,
              .in = read.first(from.size()),
              .out = arrays.last(to.size())});
        p.pack_rows(read.last(to.size()), strip, out);
    });
    p.forward_columns(out, to);
}

std::string transform_library() { return fftw_version; }

}  // namespace drover::numerics
