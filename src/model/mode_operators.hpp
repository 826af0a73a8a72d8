// model/mode_operators.hpp: linear operators on the kept modes of a grid, row by row: sums of derivatives, and small
// real matrices in the frame of q.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"
#include "model/compiled.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::model {

/// Consecutive kept modes of one row.
struct ModeRow {
    std::size_t first = 0, size = 0;       ///< modes first, ..., first + size - 1 of an array
    const double* x = nullptr;             ///< q_x of each, given twice: the real and the imaginary part have it
    double y = 0.0;                        ///< q_y
    const std::int32_t* length = nullptr;  ///< the index of its |q|
};

/// The kept modes of a grid in rows that are short enough for the first-level cache.
class ModeRows {
public:
    static constexpr std::size_t max_size = 128;

    ModeRows(const numerics::Grid& grid, const numerics::DistinctWavenumbers& wavenumbers);

    /// body(row) for every row, on any thread.  Rows depend on the grid alone.
    template <class Body>
    void for_each(Threads& threads, Body body) const {
        constexpr std::size_t rows_of_task = 8;
        threads.for_chunks(rows_.size(), rows_of_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(rows_[i]);
        });
    }

private:
    std::vector<double> x_;
    std::vector<ModeRow> rows_;
};

/// A sum of derivatives of arrays of modes: each array times real polynomials in q, even(q) + i odd(q).
class DerivativeSum {
public:
    void add(std::size_t array, const Order& order, double factor);
    bool is_empty() const { return parts_.empty(); }
    /// Writes the sum at the modes of a row or, `adds`, adds it; `to` is none of the arrays.
    void write(const ModeRow& row, std::span<const numerics::Complex* const> arrays, numerics::Complex* to,
               bool adds) const;

private:
    /// The even or the odd orders of one array.
    struct Part {
        std::size_t array = 0;
        bool is_odd = false;
        int power = 0;  ///< the largest of q_x
        std::vector<std::pair<Order, double>> monomials = {};
    };
    std::vector<Part> parts_;  // the even ones first
};

/// What some fields are of others by a matrix of |q| in the frame of q.  Its entries are imaginary where spins differ
/// by an odd number, and real elsewhere (numerics::IsotropicBlocks).
class FrameOperator {
public:
    FrameOperator() = default;
    /// `matrices` by components, at q along x, of each |q|.  The results are the components with an entry, and
    /// `results` even without one.
    FrameOperator(const CompiledEquations& equations, const std::vector<Symbol>& matrices,
                  const numerics::DistinctWavenumbers& wavenumbers, const std::vector<bool>& results);

    /// to = operator * from, or to -= it, at the modes of a row.  Arrays by components; those not in use may be null.
    void apply(const ModeRow& row, std::span<const numerics::Complex* const> from,
               std::span<numerics::Complex* const> to, bool subtracts) const;

private:
    /// A component of the fields, and the one that turns with it.
    struct Part {
        int component = 0;
        std::size_t spin = 0;
    };
    struct Entry {
        std::size_t to = 0, from = 0;  ///< parts
        bool is_imaginary = false;
    };
    /// Complex numbers of a row of modes, or real numbers given twice.
    using Row = std::array<double, 2 * ModeRows::max_size>;
    struct Turn {
        Row cosine, sine;  ///< of a spin times the angle of q
    };
    void add_parts(const CompiledEquations& equations, const std::vector<bool>& takes_part, std::vector<Part>& parts);
    void find_turns(const ModeRow& row, Turn* turns) const;
    static void turn(const std::vector<Part>& parts, std::size_t size, const Turn* turns, double sign,
                     const double** values, Row* rows);
    std::vector<Part> from_, to_;
    std::vector<Entry> entries_;
    std::vector<double> values_;   // [|q|][entry]
    std::vector<double> inverse_;  // 1/|q|, and 0 for 0
    std::size_t max_spin_ = 0;
};

}  // namespace drover::model
