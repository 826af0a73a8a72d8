// model/frame_operator.hpp: isotropic operators at the modes of a grid, by small real matrices in the frame of q.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "compiled.hpp"
#include "mode_rows.hpp"

namespace drover::model {

/// What some fields are of others by a matrix of |q| in the frame of q.  Where spins differ by an odd number the entries
/// are imaginary, elsewhere real (numerics::IsotropicBlocks).
class FrameOperator {
public:
    FrameOperator() = default;
    /// `matrices` by components, at q along x, of each |q|.  Components without an entry take no part.
    FrameOperator(const CompiledEquations& equations, const std::vector<Symbol>& matrices,
                  const numerics::DistinctWavenumbers& wavenumbers);

    /// Whether a component is among the results.
    bool writes(int component) const;
    /// to = operator * from, or to -= it, at the modes of a row.  Arrays by components; what is not written may be null.
    void apply(const ModeRow& row, std::span<const numerics::Complex* const> from,
               std::span<numerics::Complex* const> to, bool subtracts) const;

private:
    /// A component of the fields, and the one that turns with it.
    struct Part {
        int component = 0;
        std::size_t spin = 0;
        bool is_second = false;
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
    static void turn(const std::vector<Part>& parts, std::size_t size, const Turn* turns, double sign, Row* rows);
    static void turn_pair(std::size_t size, const Turn& turn, double sign, double* first, double* second);
    std::vector<Part> from_, to_;
    std::vector<Entry> entries_;
    std::vector<double> values_;   // [|q|][entry]
    std::vector<double> inverse_;  // 1/|q|, and 0 for 0
    std::size_t max_spin_ = 0;
};

}  // namespace drover::model
