// model/mode_rows.hpp: sums of derivatives, row by row of the kept modes.
#pragma once
#include <span>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/field.hpp"
#include "model/algebra.hpp"
#include "numerics/fields/wavenumbers.hpp"

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

}  // namespace drover::model
