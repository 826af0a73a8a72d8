// model/frame_operator.hpp: isotropic operators at the modes of a grid, by small real matrices in the frame of q.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "model/compiled.hpp"
#include "model/mode_rows.hpp"

namespace drover::model {

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
