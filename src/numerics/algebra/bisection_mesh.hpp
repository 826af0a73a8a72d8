// numerics/algebra/bisection_mesh.hpp: a conforming mesh of right-angled isosceles triangles, refined by bisection.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "base/constants.hpp"

namespace drover::numerics {

using MeshIndex = std::uint32_t;
constexpr MeshIndex mesh_none = std::numeric_limits<MeshIndex>::max();

/// A point of the lattice on which all vertices lie: (i, j)/BisectionMesh::side in the unit square.
struct MeshVertex {
    std::int64_t i = 0, j = 0;
    double value = nan;
};

/// Corners anticlockwise, the right angle first.  The hypotenuse is 1/cells long at level 0 and falls by sqrt(2) a
/// level.
struct MeshTriangle {
    std::array<MeshIndex, 3> corner{};
    int level = 0;
};

struct MeshEdge {
    std::array<MeshIndex, 2> end{};  ///< the older vertex first
    std::array<MeshIndex, 2> triangle{mesh_none, mesh_none};
    double crossing = nan;  ///< where the line crosses, from 0 to 1 between the ends
    bool searched = false;  ///< the crossing is known, or does not exist
};

struct MeshSplit {
    MeshIndex a, b, middle;
};

/// Vertices may also be points that are not yet corners of a triangle.  The first half of a bisected triangle replaces
/// it; its edges stay in the table.
struct BisectionMesh {
    int cells = 0;
    std::int64_t side = 0;  ///< of the unit square, in lattice units
    std::vector<MeshVertex> vertices;
    std::vector<MeshTriangle> triangles;
    std::unordered_map<std::uint64_t, MeshIndex> vertex_at;
    std::unordered_map<std::uint64_t, MeshEdge> edges;
    std::vector<MeshSplit> splits;   ///< edges bisected, in this order, since it was last emptied
    std::vector<MeshIndex> changed;  ///< triangles created since it was last emptied, possibly repeated
};

/// cells by cells squares, each cut along both diagonals; edges down to `finest` have a middle on the lattice.
BisectionMesh bisection_mesh(int cells, double finest);

MeshEdge& edge_between(BisectionMesh& mesh, MeshIndex a, MeshIndex b);

/// The vertex half-way between two; creates it if necessary.
MeshIndex middle_between(BisectionMesh& mesh, MeshIndex a, MeshIndex b);

/// The same, or mesh_none.
MeshIndex known_middle_between(const BisectionMesh& mesh, MeshIndex a, MeshIndex b);

/// The triangle on the other side of an edge, or mesh_none.
MeshIndex triangle_across(const MeshEdge& edge, MeshIndex triangle);

/// Bisects a triangle at its hypotenuse, and others as needed to leave no vertex inside an edge.
void bisect(BisectionMesh& mesh, MeshIndex triangle);

}  // namespace drover::numerics
