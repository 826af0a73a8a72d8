// numerics/layout.hpp: fields of spins, and the parts of them that isotropic operators couple.
#pragma once
#include <vector>

namespace drover::numerics {

/// How a field turns with space.  Spin 0: one component.  Spin m >= 1: two, F_1 and F_2, and turning the system by an
/// angle multiplies F_1 + i F_2 by exp(i m angle): a vector (x and y) has spin 1, a nematic (Q_xx and Q_xy) spin 2.
struct FieldKind {
    int spin = 0;
    bool odd = false;          ///< a reflection changes its sign as well: a pseudoscalar, a pseudovector
    bool across_only = false;  ///< its part along q is 0 but in the mean: a field without divergence
    bool operator==(const FieldKind&) const = default;
};
inline constexpr int max_spin = 12;

/// The fields of a system.
struct Layout {
    std::vector<FieldKind> fields;  ///< in the order of their components
    bool chiral = false;            ///< operators may couple the even and the odd parts, which a reflection tells apart
    bool operator==(const Layout&) const = default;
};

/// True scalars, then true vectors.
Layout scalars_and_vectors(int scalars, int vectors);

inline int components(const FieldKind& kind) { return kind.spin == 0 ? 1 : 2; }
int components(const Layout& layout);
/// Those of the fields of spin 0.
std::vector<int> scalar_components(const Layout& layout);

/// A variable of the blocks of a layout (see IsotropicBlocks).
struct Part {
    int component = 0;  ///< that it is where q points along x, but for the factor
    int spin = 0;       ///< m of its factor i^m
};

/// Even: true scalars, parts along of true spins, parts across of odd spins.  Odd: the others.  Each in the order of
/// the fields.  A chiral layout has one block: `even` has all of them, the even ones first.
struct BlockParts {
    std::vector<Part> even, odd;
};

/// Throws an input Error for a layout without fields, for spins beyond 0 to max_spin, and for blocks of more than
/// max_block rows.
BlockParts block_parts(const Layout& layout);

}  // namespace drover::numerics
