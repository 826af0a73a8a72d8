// numerics/algebra/bisection_mesh.cpp: building and bisecting the mesh of right-angled isosceles triangles.
#include "numerics/algebra/bisection_mesh.hpp"

#include <algorithm>

namespace drover::numerics {

namespace {

std::uint64_t pair_key(std::uint64_t high, std::uint64_t low) { return high << 32 | low; }

std::uint64_t lattice_key(std::int64_t i, std::int64_t j) {
    return pair_key(static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j));
}

MeshIndex vertex(BisectionMesh& mesh, std::int64_t i, std::int64_t j) {
    const auto next = static_cast<MeshIndex>(mesh.vertices.size());
    const auto [place, made] = mesh.vertex_at.try_emplace(lattice_key(i, j), next);
    if (made) mesh.vertices.push_back({.i = i, .j = j});
    return place->second;
}

void replace_triangle(MeshEdge& edge, MeshIndex old_one, MeshIndex new_one) {
    edge.triangle[edge.triangle[0] == old_one ? 0 : 1] = new_one;
}

void add_triangle(BisectionMesh& mesh, const std::array<MeshIndex, 3>& corner) {
    const auto index = static_cast<MeshIndex>(mesh.triangles.size());
    mesh.triangles.push_back({.corner = corner});
    mesh.changed.push_back(index);
    for (std::size_t n = 0; n < 3; ++n)
        replace_triangle(edge_between(mesh, corner[n], corner[(n + 1) % 3]), mesh_none, index);
}

/// The two halves of one triangle; updates the edges shared with other triangles.
void split_triangle(BisectionMesh& mesh, MeshIndex triangle, MeshIndex middle) {
    const auto other = static_cast<MeshIndex>(mesh.triangles.size());
    const auto [a, b, c] = mesh.triangles[triangle].corner;
    const int level = mesh.triangles[triangle].level + 1;
    mesh.triangles[triangle] = {.corner = {middle, a, b}, .level = level};
    mesh.triangles.push_back({.corner = {middle, c, a}, .level = level});
    mesh.changed.insert(mesh.changed.end(), {triangle, other});
    replace_triangle(edge_between(mesh, c, a), triangle, other);
    edge_between(mesh, a, middle).triangle = {triangle, other};
    replace_triangle(edge_between(mesh, b, middle), mesh_none, triangle);
    replace_triangle(edge_between(mesh, c, middle), mesh_none, other);
}

}  // namespace

BisectionMesh bisection_mesh(int cells, double finest) {
    std::int64_t cell = 4;  // the middle of every edge of the first mesh is on the lattice
    while (2.0 > finest * static_cast<double>(cell * cells)) cell *= 2;
    BisectionMesh mesh{.cells = cells, .side = cell * cells};
    for (std::int64_t j = 0; j < mesh.side; j += cell)
        for (std::int64_t i = 0; i < mesh.side; i += cell) {
            const MeshIndex centre = vertex(mesh, i + cell / 2, j + cell / 2);
            const std::array<MeshIndex, 4> around{vertex(mesh, i, j), vertex(mesh, i + cell, j),
                                                  vertex(mesh, i + cell, j + cell), vertex(mesh, i, j + cell)};
            for (std::size_t n = 0; n < 4; ++n) add_triangle(mesh, {centre, around[n], around[(n + 1) % 4]});
        }
    return mesh;
}

MeshEdge& edge_between(BisectionMesh& mesh, MeshIndex a, MeshIndex b) {
    const auto [older, newer] = std::minmax(a, b);
    const auto [place, made] = mesh.edges.try_emplace(pair_key(older, newer));
    if (made) place->second.end = {older, newer};
    return place->second;
}

MeshIndex middle_between(BisectionMesh& mesh, MeshIndex a, MeshIndex b) {
    const MeshVertex &from = mesh.vertices[a], &to = mesh.vertices[b];
    return vertex(mesh, (from.i + to.i) / 2, (from.j + to.j) / 2);
}

MeshIndex known_middle_between(const BisectionMesh& mesh, MeshIndex a, MeshIndex b) {
    const MeshVertex &from = mesh.vertices[a], &to = mesh.vertices[b];
    const auto found = mesh.vertex_at.find(lattice_key((from.i + to.i) / 2, (from.j + to.j) / 2));
    return found == mesh.vertex_at.end() ? mesh_none : found->second;
}

MeshIndex triangle_across(const MeshEdge& edge, MeshIndex triangle) {
    return edge.triangle[edge.triangle[0] == triangle ? 1 : 0];
}

void bisect(BisectionMesh& mesh, MeshIndex triangle) {
    const auto [apex, b, c] = mesh.triangles[triangle].corner;
    const MeshEdge& hypotenuse = edge_between(mesh, b, c);
    MeshIndex beyond = triangle_across(hypotenuse, triangle);
    if (beyond != mesh_none && mesh.triangles[beyond].level < mesh.triangles[triangle].level) {
        bisect(mesh, beyond);  // the neighbour is larger: this hypotenuse is one of its legs
        beyond = triangle_across(hypotenuse, triangle);
    }
    const MeshIndex middle = middle_between(mesh, b, c);
    mesh.splits.push_back({.a = b, .b = c, .middle = middle});
    split_triangle(mesh, triangle, middle);
    if (beyond != mesh_none) split_triangle(mesh, beyond, middle);
}

}  // namespace drover::numerics
