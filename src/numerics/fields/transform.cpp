// numerics/fields/transform.cpp: real transforms in two dimensions, two real fields as one complex one, by FFTW along
// rows and kept columns.
#include "drover/numerics/transform.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "drover/base/error.hpp"
#include "numerics/fields/line_transform.hpp"
#include "numerics/fields/per_thread.hpp"

namespace drover::numerics {

namespace {
constexpr std::size_t columns_in_strip = 8;    // 128 bytes of each row of modes: two cache lines
constexpr std::size_t rows_ahead = 8;          // of modes: to prefetch
constexpr std::size_t points_in_strip = 1024;  // of rows: fifteen arrays of it are in the second-level cache

/// Work arrays of one thread.
struct Workspace {
    Aligned<Complex> columns, rows, line;
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
/// Adds the squares of both to `squares`.
void join_parts(const double* real, const double* imaginary, std::size_t count, Complex* to, Quad (&squares)[2]) {
    std::size_t i = 0;
    for (; i + 4 <= count; i += 4) {
        const Quad a = load_quad(real + i), b = imaginary ? load_quad(imaginary + i) : Quad{};
        squares[0] += a * a;
        squares[1] += b * b;
        store_quad(__builtin_shuffle(a, b, Order{0, 4, 1, 5}), to + i);
        store_quad(__builtin_shuffle(a, b, Order{2, 6, 3, 7}), to + i + 2);
    }
    for (; i < count; ++i) {
        to[i] = {real[i], imaginary ? imaginary[i] : 0.0};
        squares[0][0] += to[i].real() * to[i].real();
        squares[1][0] += to[i].imag() * to[i].imag();
    }
}
/// Parts that are swapped have the same: an array has it as the first and as the second of a pair.
double total(const Quad& parts) { return (parts[0] + parts[1]) + (parts[2] + parts[3]); }

constexpr std::size_t none = static_cast<std::size_t>(-1);
/// Two arrays that are transformed as one complex array, or one alone.
struct Pairing {
    std::size_t first = 0, second = none;
    bool operator==(const Pairing&) const = default;
};
template <class Array>
Array second_of(const Pairing& pair, std::span<const Array> arrays) {
    return pair.second == none ? nullptr : arrays[pair.second];
}

/// Of the smaller of two arrays, rounding leaves the digits that it shares with the larger.  So neighbours make a pair
/// where they are of about one size, and then any two that are; the others are transformed alone.
std::vector<Pairing> pairs_of(std::span<const double> squares) {
    constexpr double max_ratio = 0x1p32;  // of squares: 2^-37 of the smaller array is lost
    const auto agree = [&](std::size_t i, std::size_t j) {
        const auto [small, large] = std::minmax(squares[i], squares[j]);
        return !(small > 0.0 && large / small > max_ratio);  // of zero there is nothing to lose
    };
    std::vector<Pairing> pairs, alone;
    for (std::size_t i = 0; i < squares.size(); i += 2)
        if (i + 1 < squares.size() && agree(i, i + 1)) pairs.push_back({i, i + 1});
        else
            for (std::size_t j = i; j < std::min(i + 2, squares.size()); ++j) {
                const auto open = std::ranges::find_if(alone, [&](const Pairing& pair) {
                    return pair.second == none && agree(pair.first, j);
                });
                if (open == alone.end()) alone.push_back({j});
                else open->second = j;
            }
    pairs.insert(pairs.end(), alone.begin(), alone.end());
    return pairs;
}

/// Of each array, from [strip][array]: the sum does not depend on the threads.
std::vector<double> sum_of_strips(std::span<const double> strips, std::size_t arrays) {
    std::vector<double> sum(arrays);
    for (std::size_t i = 0; i < strips.size(); ++i) sum[i % arrays] += strips[i];
    return sum;
}

/// Calls transform(pairs), which returns the sum of the squares of each array, and once more where they belong in other
/// pairs than these before: the result is that of the pairs that the arrays tell.
template <class Body>
void transform_in_pairs(std::vector<Pairing>& pairs, std::size_t arrays, Body transform) {
    std::size_t paired = 0;
    for (const Pairing& pair : pairs) paired += pair.second == none ? 1 : 2;
    if (paired != arrays) pairs = pairs_of(std::vector<double>(arrays, 1.0));
    std::vector<Pairing> better = pairs_of(transform(pairs));
    if (better == pairs) return;
    pairs = std::move(better);
    transform(pairs);
}
}  // namespace

/// Two real fields a, b are the parts of a complex one, Z = A + i B.  Of each pair, all columns k >= 0 of Z that are
/// kept, then, at `kept` + k, column -k, which is conj(A - i B) of the rows in reverse order.  A field without a
/// partner has no columns -k.  Between rows and columns, a column is contiguous, and a few rows of it are a cache line.
/// What reads arrays first gives the sum of the squares of each.
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
    std::vector<Pairing> pairs_in, pairs_out;  // of the last call: the next one begins with them

    Plans(const Grid& the_grid, int degree, Threads& the_threads);
    std::vector<double> backward_columns(std::span<const Complex* const> from, std::span<const Pairing> pairs,
                                         Complex* scratch);
    void forward_columns(const Complex* scratch, std::span<const Pairing> pairs, std::span<Complex* const> to);
    void backward_rows(const Complex* scratch, std::span<const Pairing> pairs, std::size_t strip,
                       std::span<double* const> arrays);
    void forward_rows(std::span<const double* const> arrays, std::span<const Pairing> pairs, std::size_t strip,
                      Complex* scratch, std::span<double> squares);
    Complex* scratch(Aligned<Complex>& memory, std::span<const Pairing> pairs) const {
        return memory.buffer(pairs.size() * pair_size());
    }
    std::size_t pair_size() const { return 2 * kept * pitch; }
    std::size_t column_strips() const { return (kept + strip_columns - 1) / strip_columns; }
    std::size_t strips() const { return (ny + rows - 1) / rows; }
    std::size_t strip_size(std::size_t strip) const { return std::min(rows, ny - strip * rows); }

    /// body(pair, strip, first column, number of columns) for every strip of columns of every pair.
    template <class Body>
    void for_columns(std::size_t pairs, Body body) {
        threads.for_chunks(pairs * column_strips(), 1, [&](std::size_t task, std::size_t) {
            const std::size_t strip = task % column_strips(), first = strip * strip_columns;
            body(task / column_strips(), strip, first, std::min(strip_columns, kept - first));
        });
    }

    /// body(strip, squares of its arrays) for every strip of rows.
    template <class Body>
    std::vector<double> for_rows(std::size_t arrays, Body body) {
        std::vector<double> squares(strips() * arrays);
        threads.for_chunks(strips(), 1, [&](std::size_t strip, std::size_t) {
            body(strip, std::span(squares).subspan(strip * arrays, arrays));
        });
        return sum_of_strips(squares, arrays);
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
    row_forward = LineTransform(nx, nx, -1);
    row_backward = LineTransform(nx, nx, +1);
    column_forward = LineTransform(ny, pitch, -1);
    column_backward = LineTransform(ny, pitch, +1);
}

std::vector<double> Transform::Plans::backward_columns(std::span<const Complex* const> from,
                                                       std::span<const Pairing> pairs, Complex* scratch) {
    std::vector<double> squares(column_strips() * from.size());
    for_columns(pairs.size(), [&](std::size_t pair, std::size_t strip, std::size_t first, std::size_t count) {
        const Complex *a = from[pairs[pair].first] + first, *b = second_of(pairs[pair], from);
        if (b) b += first;
        Quad square_a{}, square_b{};
        Complex* plus = workspace().columns.buffer(2 * strip_columns * pitch);
        Complex* minus = plus + strip_columns * pitch;
        for (std::size_t i = 0; i < count; ++i)
            for (Complex* column : {plus, minus})
                std::fill_n(column + i * pitch + first_cut_row, ny - kept_rows.size(), Complex(0.0));
        for (std::size_t r = 0; r < kept_rows.size(); ++r) {
            const std::size_t j = kept_rows[r], reverse = j == 0 ? 0 : ny - j;
            if (r + rows_ahead < kept_rows.size()) prefetch_modes<0>(kept_rows[r + rows_ahead] * width, a, b);
            // Two columns at a time: behind the last there is a column, which is not kept, and room for it.
            if (!b) {
                for (std::size_t i = 0; i < count; i += 2) {
                    const Quad of_a = load_quad(a + j * width + i);
                    square_a += of_a * of_a;
                    store(Pair{of_a[0], of_a[1]}, plus + i * pitch + j);
                    store(Pair{of_a[2], of_a[3]}, plus + (i + 1) * pitch + j);
                }
                continue;
            }
            for (std::size_t i = 0; i < count; i += 2) {
                const Quad of_a = load_quad(a + j * width + i),
                           of_b = sign_of_real * swap_parts(load_quad(b + j * width + i)), sum = of_a + of_b,
                           difference = sign_of_imaginary * (of_a - of_b);
                square_a += of_a * of_a;
                square_b += of_b * of_b;
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
        squares[strip * from.size() + pairs[pair].first] = total(square_a);
        if (b) squares[strip * from.size() + pairs[pair].second] = total(square_b);
    });
    return sum_of_strips(squares, from.size());
}

void Transform::Plans::forward_columns(const Complex* scratch, std::span<const Pairing> pairs,
                                       std::span<Complex* const> to) {
    const double scale = 1.0 / static_cast<double>(points(grid)), half = 0.5 * scale;
    for_columns(pairs.size(), [&](std::size_t pair, std::size_t, std::size_t first, std::size_t count) {
        Complex *a = to[pairs[pair].first] + first, *b = second_of(pairs[pair], to);
        if (b) b += first;
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

void Transform::Plans::backward_rows(const Complex* scratch, std::span<const Pairing> pairs, std::size_t strip,
                                     std::span<double* const> arrays) {
    const std::size_t first = strip * rows, count = strip_size(strip);
    Complex *block = workspace().rows.buffer(line_rows * nx), *line = workspace().line.buffer(line_rows * nx);
    for (std::size_t j = 0; j < std::min(count, line_rows); ++j)
        std::fill(block + j * nx + kept, block + (j + 1) * nx - kept + 1, Complex(0.0));
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
        double *const a = arrays[pairs[pair].first], *const b = second_of(pairs[pair], arrays);
        const bool is_pair = b != nullptr;
        for (std::size_t row = 0; row < count; row += line_rows) {
            const Complex* plus = scratch + pair * pair_size() + first + row;
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
                row + line_rows < count ? plus + line_rows : scratch + (pair + 1) * pair_size() + first;
            if (row + line_rows < count || pair + 1 < pairs.size())
                for (std::size_t k = 0; k < 2 * kept; ++k) __builtin_prefetch(next + k * pitch);
            row_backward(lines, block, line);
            const std::size_t at = row * nx;
            split_parts(line, lines * nx, a + at, b ? b + at : nullptr);
        }
    }
}

void Transform::Plans::forward_rows(std::span<const double* const> arrays, std::span<const Pairing> pairs,
                                    std::size_t strip, Complex* scratch, std::span<double> squares) {
    const std::size_t first = strip * rows, count = strip_size(strip);
    Complex *block = workspace().rows.buffer(line_rows * nx), *line = workspace().line.buffer(line_rows * nx);
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
        const double *const a = arrays[pairs[pair].first], *const b = second_of(pairs[pair], arrays);
        Quad sums[2] = {};
        const bool is_pair = b != nullptr;
        for (std::size_t row = 0; row < count; row += line_rows) {
            Complex* plus = scratch + pair * pair_size() + first + row;
            Complex* minus = plus + kept * pitch;
            const std::size_t lines = std::min(line_rows, count - row);
            for (std::size_t k = 0; k < 2 * kept; ++k) __builtin_prefetch(plus + k * pitch, 1);
            const std::size_t at = row * nx;
            join_parts(a + at, b ? b + at : nullptr, lines * nx, line, sums);
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
        squares[pairs[pair].first] = total(sums[0]);
        if (b) squares[pairs[pair].second] = total(sums[1]);
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
        std::vector<const double*> arrays;
        std::vector<Complex*> spectra;
        for (int i = c; i < c + count; ++i) {
            arrays.push_back(from[i].data());
            spectra.push_back(to[i].data());
            std::ranges::fill(to[i], Complex(0.0));
        }
        std::vector<Pairing> pairs;
        Complex* scratch = nullptr;
        transform_in_pairs(pairs, arrays.size(), [&](std::span<const Pairing> paired) {
            scratch = p.scratch(p.scratch_out, paired);
            return p.for_rows(arrays.size(), [&](std::size_t strip, std::span<double> squares) {
                std::vector<const double*> rows;
                for (const double* array : arrays) rows.push_back(array + strip * p.rows * p.nx);
                p.forward_rows(rows, paired, strip, scratch, squares);
            });
        });
        p.forward_columns(scratch, pairs, spectra);
    }
}

void Transform::backward(const Spectra& from, Fields& to) const {
    Plans& p = *plans_;
    check(from, p.grid, from.count());
    check(to, p.grid, from.count());
    for (int c = 0; c < from.count(); c += 2) {
        const int count = std::min(2, from.count() - c);
        std::vector<const Complex*> spectra;
        std::vector<double*> arrays;
        for (int i = c; i < c + count; ++i) {
            spectra.push_back(from[i].data());
            arrays.push_back(to[i].data());
        }
        std::vector<Pairing> pairs;
        Complex* scratch = nullptr;
        transform_in_pairs(pairs, spectra.size(), [&](std::span<const Pairing> paired) {
            scratch = p.scratch(p.scratch_in, paired);
            return p.backward_columns(spectra, paired, scratch);
        });
        p.threads.for_chunks(p.strips(), 1, [&](std::size_t strip, std::size_t) {
            std::vector<double*> rows;
            for (double* array : arrays) rows.push_back(array + strip * p.rows * p.nx);
            p.backward_rows(scratch, pairs, strip, rows);
        });
    }
}

void Transform::products(std::span<const Complex* const> from, std::span<Complex* const> to,
                         const std::function<void(const Strip&)>& work) const {
    Plans& p = *plans_;
    Complex *in = nullptr, *out = nullptr;
    transform_in_pairs(p.pairs_in, from.size(), [&](std::span<const Pairing> pairs) {
        in = p.scratch(p.scratch_in, pairs);
        return p.backward_columns(from, pairs, in);
    });
    transform_in_pairs(p.pairs_out, to.size(), [&](std::span<const Pairing> pairs) {
        out = p.scratch(p.scratch_out, pairs);
        return p.for_rows(to.size(), [&](std::size_t strip, std::span<double> squares) {
            Workspace& mine = workspace();
            const std::size_t buffer = p.rows * p.nx;
            double* points = mine.points.buffer((from.size() + to.size()) * buffer);
            mine.out.clear();
            for (std::size_t c = 0; c < from.size() + to.size(); ++c) mine.out.push_back(points + c * buffer);
            mine.in.assign(mine.out.begin(), mine.out.end());
            const std::span<double* const> arrays(mine.out);
            p.backward_rows(in, p.pairs_in, strip, arrays.first(from.size()));
            const std::span<const double* const> read(mine.in);
            work({.first = strip * p.rows * p.nx,
                  .size = p.strip_size(strip) * p.nx,
                  .in = read.first(from.size()),
                  .out = arrays.last(to.size())});
            p.forward_rows(read.last(to.size()), pairs, strip, out, squares);
        });
    });
    p.forward_columns(out, p.pairs_out, to);
}

std::string transform_library() { return line_library(); }

}  // namespace drover::numerics
