// numerics/fields/transform.cpp: real transforms in two dimensions, two real fields as one complex one, by FFTW along
// rows and kept columns.
#include "drover/numerics/transform.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <numbers>
#include <vector>

#include "drover/base/error.hpp"
#include "numerics/fields/complex_registers.hpp"
#include "numerics/fields/per_thread.hpp"

namespace drover::numerics {

namespace {
constexpr std::size_t columns_in_strip = 8;    // 128 bytes of each row of modes: two cache lines
constexpr std::size_t rows_ahead = 8;          // of modes: to prefetch
constexpr std::size_t line_rows = 4;           // of one column: a cache line
constexpr std::size_t points_in_strip = 1024;  // of rows: fifteen arrays of it are in the second-level cache

fftw_complex* raw(Complex* values) { return reinterpret_cast<fftw_complex*>(values); }

/// The FFTW planner is global and not thread-safe, nor is the destruction of plans; their execution is.
std::mutex& planner_mutex() {
    static std::mutex& mutex = new_mutex_over_forks();
    return mutex;
}

struct PlanDeleter {
    void operator()(fftw_plan plan) const {
        const std::lock_guard lock(planner_mutex());
        fftw_destroy_plan(plan);
    }
};
using Plan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, PlanDeleter>;

/// Memory aligned for the vector instructions of FFTW; every array in it starts on a cache line.
template <class Number>
class Aligned {
public:
    Number* buffer(std::size_t count) {
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

/// Work arrays of one thread.
struct Workspace {
    Aligned<Complex> columns, rows, line, between, lines;
    Aligned<double> points;
    std::vector<const double*> in;
    std::vector<double*> out;
};
Workspace& workspace() {
    static PerThread<Workspace> workspaces;
    return workspaces.get();
}

using Order [[gnu::vector_size(32)]] = std::int64_t;
template <class Value>
Quad load_quad(const Value* from) {
    return load_as<Quad>(from);
}
void store_quad(const Quad& quad, double* to) { std::memcpy(to, &quad, sizeof(quad)); }
void store_quad(const Quad& quad, Complex* to) { store_quad(quad, reinterpret_cast<double*>(to)); }
Quad swap_parts(const Quad& a) { return __builtin_shuffle(a, Order{1, 0, 3, 2}); }
constexpr Quad sign_of_real{-1.0, 1.0, -1.0, 1.0}, sign_of_imaginary{1.0, -1.0, 1.0, -1.0};

/// A strip of a row of modes of two arrays; the second may be absent.
template <int ToWrite>
void prefetch_modes(std::size_t at, const Complex* a, const Complex* b) {
    for (const Complex* array : {a, b})
        for (std::size_t i = 0; array && i < columns_in_strip; i += 4) __builtin_prefetch(array + at + i, ToWrite);
}

/// Four rows of one column, a cache line, to consecutive rows, and back.
void spread_line(const Complex* from, Complex* to, std::size_t row) {
    for (std::size_t j = 0; j < line_rows; ++j) store(load(from + j), to + j * row);
}
void collect_line(const Complex* from, std::size_t row, Complex* to) {
    for (std::size_t j = 0; j < line_rows; ++j) store(load(from + j * row), to + j);
}

void split_parts(const Complex* from, std::size_t count, double* real, double* imaginary) {
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4) {
        const Quad a = load_quad(from + i), b = load_quad(from + i + 2);
        store_quad(__builtin_shuffle(a, b, Order{0, 2, 4, 6}), real + i);
        if (imaginary) store_quad(__builtin_shuffle(a, b, Order{1, 3, 5, 7}), imaginary + i);
    }
    for (; i < count; ++i) {
        real[i] = from[i].real();
        if (imaginary) imaginary[i] = from[i].imag();
    }
}
void join_parts(const double* real, const double* imaginary, std::size_t count, Complex* to) {
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4) {
        const Quad a = load_quad(real + i), b = imaginary ? load_quad(imaginary + i) : Quad{};
        store_quad(__builtin_shuffle(a, b, Order{0, 4, 1, 5}), to + i);
        store_quad(__builtin_shuffle(a, b, Order{2, 6, 3, 7}), to + i + 2);
    }
    for (; i < count; ++i) to[i] = {real[i], imaginary ? imaginary[i] : 0.0};
}
/// Of lines of complex numbers at a distance that is a multiple of 32 bytes, or of single numbers.  The plans are
/// estimated, not measured: which plan is fastest varies between runs, and with it the last bits of the results.
class LineTransform {
public:
    LineTransform() = default;
    LineTransform(std::size_t length, std::size_t distance, int direction);
    void operator()(std::size_t lines, const Complex* from, Complex* to) const;

private:
    void in_two_passes(const Complex* from, Complex* to) const;

    std::size_t length_ = 1, distance_ = 1;
    std::size_t first_ = 0, second_ = 0;  // a long line is a matrix of first_ rows of second_ numbers
    Plan four_, one_, of_first_, of_second_;
    std::vector<Complex> factors_;  // [second / 4][first][4]
};

Plan line_plan(std::size_t lines, std::size_t length, std::size_t distance, int direction) {
    Aligned<Complex> from, to;
    fftw_complex *const in = raw(from.buffer(lines * distance)), *const out = raw(to.buffer(lines * distance));
    const auto n = static_cast<int>(length), between = static_cast<int>(distance);
    const std::lock_guard lock(planner_mutex());
    return Plan(fftw_plan_many_dft(1, &n, static_cast<int>(lines), in, nullptr, 1, between, out, nullptr, 1, between,
                                   direction, FFTW_ESTIMATE));
}

/// The larger factor of a length, the smaller being near its square root; 0: none is a multiple of 4.
std::size_t larger_factor(std::size_t length) {
    std::size_t factor = static_cast<std::size_t>(std::sqrt(static_cast<double>(length))) / 4 * 4;
    constexpr std::size_t smallest = 32;
    while (factor >= smallest && (length % factor != 0 || length / factor % 4 != 0)) factor -= 4;
    return factor < smallest ? 0 : length / factor;
}

LineTransform::LineTransform(std::size_t length, std::size_t distance, int direction)
    : length_(length), distance_(distance) {
    constexpr std::size_t long_line = 8192;  // longer ones do not fit in the second-level cache
    if (length == 1) return;
    second_ = length >= long_line ? larger_factor(length) : 0;
    if (second_ == 0) {
        four_ = line_plan(4, length, distance, direction);
        one_ = line_plan(1, length, distance, direction);
        return;
    }
    first_ = length / second_;
    of_first_ = line_plan(4, first_, first_ + 4, direction);
    of_second_ = line_plan(4, second_, second_ + 4, direction);
    const double turn = direction * 2.0 * std::numbers::pi / static_cast<double>(length);
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
    Complex* between = workspace().between.buffer(first_ * second);
    Complex *in = workspace().lines.buffer(8 * second), *out = in + 4 * second;
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
}  // namespace

/// Two real fields a, b are the parts of a complex one, Z = A + i B.  Of each pair, all columns k >= 0 of Z that are
/// kept, then, at `kept` + k, column -k, which is conj(A - i B) of the rows in reverse order.  A field without a
/// partner has no columns -k.  Between rows and columns, a column is contiguous, and a few rows of it are a cache line.
struct Transform::Plans {
    Grid grid;
    Threads& threads;
    std::size_t nx, ny, width;                // points, and stored modes of a row
    std::size_t kept = 0, pitch = 0;          // kept columns; size of a column in scratch: complete cache lines
    std::size_t rows = 1, strip_columns = 1;  // rows of a strip of rows, columns of a strip of columns
    std::vector<std::size_t> kept_rows;
    std::size_t first_cut_row = 0;  // the rows that are not kept are contiguous
    LineTransform row_forward, row_backward, column_forward, column_backward;
    Aligned<Complex> scratch_in, scratch_out;  // [pair][column][row], between rows and columns

    Plans(const Grid& the_grid, int degree, Threads& the_threads);
    void backward_columns(std::span<const Complex* const> from, Complex* scratch);
    void forward_columns(const Complex* scratch, std::span<Complex* const> to);
    void backward_rows(const Complex* scratch, std::size_t strip, std::span<double* const> arrays);
    void forward_rows(std::span<const double* const> arrays, std::size_t strip, Complex* scratch);
    std::size_t pair_size() const { return 2 * kept * pitch; }
    std::size_t scratch_size(std::size_t arrays) const { return (arrays + 1) / 2 * pair_size(); }
    std::size_t strips() const { return (ny + rows - 1) / rows; }
    std::size_t strip_size(std::size_t strip) const { return std::min(rows, ny - strip * rows); }

    /// body(pair, first column, number of columns) for every strip of columns of every pair.
    template <class Body>
    void for_columns(std::size_t arrays, Body body) {
        const std::size_t count = (kept + strip_columns - 1) / strip_columns;
        threads.for_chunks((arrays + 1) / 2 * count, 1, [&](std::size_t task, std::size_t) {
            const std::size_t first = task % count * strip_columns;
            body(task / count, first, std::min(strip_columns, kept - first));
        });
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
    // Not a power of two: columns would fall in the same first-level cache set.
    strip_columns = ny == 1 ? points_in_strip : columns_in_strip;
    pitch = ny == 1 ? 1 : (ny / line_rows + 1) * line_rows;
    rows = std::min(ny, std::max(line_rows, points_in_strip / nx / line_rows * line_rows));
    row_forward = LineTransform(nx, nx, FFTW_FORWARD);
    row_backward = LineTransform(nx, nx, FFTW_BACKWARD);
    column_forward = LineTransform(ny, pitch, FFTW_FORWARD);
    column_backward = LineTransform(ny, pitch, FFTW_BACKWARD);
}

void Transform::Plans::backward_columns(std::span<const Complex* const> from, Complex* scratch) {
    for_columns(from.size(), [&](std::size_t pair, std::size_t first, std::size_t count) {
        const Complex *a = from[2 * pair] + first, *b = nullptr;
        if (2 * pair + 1 < from.size()) b = from[2 * pair + 1] + first;
        Complex* plus = workspace().columns.buffer(2 * strip_columns * pitch);
        Complex* minus = plus + strip_columns * pitch;
        for (std::size_t i = 0; i < count; ++i)
            for (Complex* column : {plus, minus})
                std::fill_n(column + i * pitch + first_cut_row, ny - kept_rows.size(), Complex(0.0));
        for (std::size_t r = 0; r < kept_rows.size(); ++r) {
            const std::size_t j = kept_rows[r], reverse = j == 0 ? 0 : ny - j;
            if (r + rows_ahead < kept_rows.size()) prefetch_modes<0>(kept_rows[r + rows_ahead] * width, a, b);
            if (!b) {
                for (std::size_t i = 0; i < count; ++i) plus[i * pitch + j] = a[j * width + i];
                continue;
            }
            // Two columns at a time: behind the last there is a column, which is not kept, and room for it.
            for (std::size_t i = 0; i < count; i += 2) {
                const Quad of_a = load_quad(a + j * width + i),
                           of_b = sign_of_real * swap_parts(load_quad(b + j * width + i)), sum = of_a + of_b,
                           difference = sign_of_imaginary * (of_a - of_b);
                store(Pair{sum[0], sum[1]}, plus + i * pitch + j);
                store(Pair{sum[2], sum[3]}, plus + (i + 1) * pitch + j);
                store(Pair{difference[0], difference[1]}, minus + i * pitch + reverse);
                store(Pair{difference[2], difference[3]}, minus + (i + 1) * pitch + reverse);
            }
        }
        // Of column 0, the part that belongs to real fields.
        if (first == 0)
            for (const std::size_t j : kept_rows) {
                const std::size_t reverse = j == 0 ? 0 : ny - j;
                plus[j] = b ? 0.5 * (plus[j] + minus[j]) : 0.5 * (a[j * width] + std::conj(a[reverse * width]));
            }
        Complex* out = scratch + pair * pair_size() + first * pitch;
        column_backward(count, plus, out);
        if (b) column_backward(count, minus, out + kept * pitch);
    });
}

void Transform::Plans::forward_columns(const Complex* scratch, std::span<Complex* const> to) {
    const double scale = 1.0 / static_cast<double>(points(grid)), half = 0.5 * scale;
    for_columns(to.size(), [&](std::size_t pair, std::size_t first, std::size_t count) {
        Complex *a = to[2 * pair] + first, *b = nullptr;
        if (2 * pair + 1 < to.size()) b = to[2 * pair + 1] + first;
        Complex* plus = workspace().columns.buffer(2 * strip_columns * pitch);
        Complex* minus = plus + strip_columns * pitch;
        const Complex* in = scratch + pair * pair_size() + first * pitch;
        column_forward(count, in, plus);
        const std::size_t skipped = first == 0 ? 1 : 0;  // -0
        if (b) column_forward(count - skipped, in + (kept + skipped) * pitch, minus + skipped * pitch);
        if (b && first == 0) std::copy_n(plus, ny, minus);
        for (std::size_t r = 0; r < kept_rows.size(); ++r) {
            const std::size_t j = kept_rows[r], reverse = j == 0 ? 0 : ny - j;
            if (r + rows_ahead < kept_rows.size()) prefetch_modes<1>(kept_rows[r + rows_ahead] * width, a, b);
            if (!b) {
                for (std::size_t i = 0; i < count; ++i) a[j * width + i] = scale * plus[i * pitch + j];
                continue;
            }
            std::size_t i = 0;
            for (; i + 2 <= count; i += 2) {
                const Quad z = joined(load(plus + i * pitch + j), load(plus + (i + 1) * pitch + j)),
                           other = sign_of_imaginary *
                                   joined(load(minus + i * pitch + reverse), load(minus + (i + 1) * pitch + reverse));
                store_quad(half * (z + other), a + j * width + i);
                store_quad(half * (sign_of_imaginary * swap_parts(z - other)), b + j * width + i);
            }
            if (i == count) continue;
            const Complex z = plus[i * pitch + j], other = std::conj(minus[i * pitch + reverse]);
            a[j * width + i] = half * (z + other);
            b[j * width + i] = half * Complex(0.0, -1.0) * (z - other);
        }
    });
}

void Transform::Plans::backward_rows(const Complex* scratch, std::size_t strip, std::span<double* const> arrays) {
    const std::size_t first = strip * rows, count = strip_size(strip);
    Complex *block = workspace().rows.buffer(line_rows * nx), *line = workspace().line.buffer(line_rows * nx);
    for (std::size_t j = 0; j < std::min(count, line_rows); ++j)
        std::fill(block + j * nx + kept, block + (j + 1) * nx - kept + 1, Complex(0.0));
    for (std::size_t c = 0; c < arrays.size(); c += 2) {
        const bool is_pair = c + 1 < arrays.size();
        for (std::size_t row = 0; row < count; row += line_rows) {
            const Complex* plus = scratch + c / 2 * pair_size() + first + row;
            const Complex* minus = plus + kept * pitch;
            const std::size_t lines = std::min(line_rows, count - row);
            if (lines == line_rows) {
                for (std::size_t k = 0; k < kept; ++k) spread_line(plus + k * pitch, block + k, nx);
                if (is_pair)
                    for (std::size_t k = 1; k < kept; ++k) spread_line(minus + k * pitch, block + nx - k, nx);
                else
                    for (std::size_t j = 0; j < lines; ++j)
                        for (std::size_t k = 1; k < kept; ++k) block[j * nx + nx - k] = std::conj(block[j * nx + k]);
            } else
                for (std::size_t j = 0; j < lines; ++j) {
                    for (std::size_t k = 0; k < kept; ++k) block[j * nx + k] = plus[k * pitch + j];
                    for (std::size_t k = 1; k < kept; ++k)
                        block[j * nx + nx - k] = is_pair ? minus[k * pitch + j] : std::conj(plus[k * pitch + j]);
                }
            // The next lines to the cache while these are transformed.
            const Complex* next =
                row + line_rows < count ? plus + line_rows : scratch + (c / 2 + 1) * pair_size() + first;
            if (row + line_rows < count || c + 2 < arrays.size())
                for (std::size_t k = 0; k < 2 * kept; ++k) __builtin_prefetch(next + k * pitch);
            row_backward(lines, block, line);
            const std::size_t at = row * nx;
            split_parts(line, lines * nx, arrays[c] + at, is_pair ? arrays[c + 1] + at : nullptr);
        }
    }
}

void Transform::Plans::forward_rows(std::span<const double* const> arrays, std::size_t strip, Complex* scratch) {
    const std::size_t first = strip * rows, count = strip_size(strip);
    Complex *block = workspace().rows.buffer(line_rows * nx), *line = workspace().line.buffer(line_rows * nx);
    for (std::size_t c = 0; c < arrays.size(); c += 2) {
        const bool is_pair = c + 1 < arrays.size();
        for (std::size_t row = 0; row < count; row += line_rows) {
            Complex* plus = scratch + c / 2 * pair_size() + first + row;
            Complex* minus = plus + kept * pitch;
            const std::size_t lines = std::min(line_rows, count - row);
            for (std::size_t k = 0; k < 2 * kept; ++k) __builtin_prefetch(plus + k * pitch, 1);
            const std::size_t at = row * nx;
            join_parts(arrays[c] + at, is_pair ? arrays[c + 1] + at : nullptr, lines * nx, line);
            row_forward(lines, line, block);
            if (lines == line_rows) {
                for (std::size_t k = 0; k < kept; ++k) collect_line(block + k, nx, plus + k * pitch);
                for (std::size_t k = 1; k < kept && is_pair; ++k) collect_line(block + nx - k, nx, minus + k * pitch);
            } else
                for (std::size_t j = 0; j < lines; ++j) {
                    for (std::size_t k = 0; k < kept; ++k) plus[k * pitch + j] = block[j * nx + k];
                    for (std::size_t k = 1; k < kept && is_pair; ++k) minus[k * pitch + j] = block[j * nx + nx - k];
                }
        }
    }
}

Transform::Transform(const Grid& grid, int degree, Threads& threads)
    : plans_(std::make_unique<Plans>(grid, degree, threads)) {}
Transform::~Transform() = default;

const Grid& Transform::grid() const { return plans_->grid; }

void Transform::forward(const Fields& from, Spectra& to) const {
    Plans& p = *plans_;
    check(from, p.grid, from.count());
    check(to, p.grid, from.count());
    // Two at a time, so that they stay in the cache.
    for (int c = 0; c < from.count(); c += 2) {
        const int count = std::min(2, from.count() - c);
        Complex* scratch = p.scratch_out.buffer(p.scratch_size(2));
        std::vector<const double*> arrays;
        std::vector<Complex*> spectra;
        for (int i = c; i < c + count; ++i) {
            arrays.push_back(from[i].data());
            spectra.push_back(to[i].data());
            std::ranges::fill(to[i], Complex(0.0));
        }
        p.threads.for_chunks(p.strips(), 1, [&](std::size_t strip, std::size_t) {
            std::vector<const double*> rows;
            for (const double* array : arrays) rows.push_back(array + strip * p.rows * p.nx);
            p.forward_rows(rows, strip, scratch);
        });
        p.forward_columns(scratch, spectra);
    }
}

void Transform::backward(const Spectra& from, Fields& to) const {
    Plans& p = *plans_;
    check(from, p.grid, from.count());
    check(to, p.grid, from.count());
    for (int c = 0; c < from.count(); c += 2) {
        const int count = std::min(2, from.count() - c);
        Complex* scratch = p.scratch_in.buffer(p.scratch_size(2));
        std::vector<const Complex*> spectra;
        std::vector<double*> arrays;
        for (int i = c; i < c + count; ++i) {
            spectra.push_back(from[i].data());
            arrays.push_back(to[i].data());
        }
        p.backward_columns(spectra, scratch);
        p.threads.for_chunks(p.strips(), 1, [&](std::size_t strip, std::size_t) {
            std::vector<double*> rows;
            for (double* array : arrays) rows.push_back(array + strip * p.rows * p.nx);
            p.backward_rows(scratch, strip, rows);
        });
    }
}

void Transform::products(std::span<const Complex* const> from, std::span<Complex* const> to,
                         const std::function<void(const Strip&)>& work) const {
    Plans& p = *plans_;
    Complex *in = p.scratch_in.buffer(p.scratch_size(from.size())),
            *out = p.scratch_out.buffer(p.scratch_size(to.size()));
    p.backward_columns(from, in);
    p.threads.for_chunks(p.strips(), 1, [&](std::size_t strip, std::size_t) {
        Workspace& mine = workspace();
        const std::size_t buffer = p.rows * p.nx;
        double* points = mine.points.buffer((from.size() + to.size()) * buffer);
        mine.out.clear();
        for (std::size_t c = 0; c < from.size() + to.size(); ++c) mine.out.push_back(points + c * buffer);
        mine.in.assign(mine.out.begin(), mine.out.end());
        const std::span<double* const> arrays(mine.out);
        p.backward_rows(in, strip, arrays.first(from.size()));
        const std::span<const double* const> read(mine.in);
        work({.first = strip * p.rows * p.nx,
              .size = p.strip_size(strip) * p.nx,
              .in = read.first(from.size()),
              .out = arrays.last(to.size())});
        p.forward_rows(read.last(to.size()), strip, out);
    });
    p.forward_columns(out, to);
}

std::string transform_library() { return fftw_version; }

}  // namespace drover::numerics
