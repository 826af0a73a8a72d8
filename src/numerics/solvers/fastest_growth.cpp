// numerics/solvers/fastest_growth.cpp: a search over the wavenumbers of a grid.
#include "numerics/solvers/fastest_growth.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/isotropic.hpp"

namespace drover::numerics {

namespace {
/// Without the parts along q of fields that have none.
Block without_absent(const Block& m, const std::vector<Part>& parts, const std::vector<int>& absent) {
    std::vector<int> kept;
    for (int i = 0; i < m.size; ++i)
        if (std::ranges::find(absent, parts[static_cast<std::size_t>(i)].component) == absent.end()) kept.push_back(i);
    return of_rows(m, kept);
}

/// Calls see(s) for the rates of both blocks.
template <class See>
void rates_at(const System& system, double q, See see) {
    const IsotropicBlocks blocks = system.linear(q);
    const BlockParts parts = block_parts(system.layout);
    std::vector<int> absent;
    int first = 0;
    for (const FieldKind& field : system.layout.fields) {
        if (field.across_only && q > 0.0) absent.push_back(first);
        first += components(field);
    }
    for (const auto& [block, members] : {std::pair{&blocks.even, &parts.even}, std::pair{&blocks.odd, &parts.odd}})
        for (const Complex s : eigenvalues(without_absent(*block, *members, absent))) see(s);
}

/// The kept mode whose value(q, s) is largest.  Of more than `max_modes` wavenumbers it looks at every k-th, then at
/// all near the best one: rates are roots of polynomials of low degree in q, far smoother than that.
template <class Value>
FastestGrowth largest(const System& system, Value value) {
    constexpr std::size_t max_modes = std::size_t{1} << 17;
    const std::vector<double> q = distinct_wavenumbers(system.grid, system.degree).q;
    FastestGrowth result{.rate = -infinite};
    std::size_t at = 0;
    const auto look = [&](std::size_t i) {
        rates_at(system, q[i], [&](Complex s) {
            const double found = value(q[i], s);
            if (found > result.rate) result = {.rate = found, .q = q[i]}, at = i;
        });
    };
    const std::size_t every = (q.size() + max_modes - 1) / max_modes;
    for (std::size_t i = 0; i < q.size(); i += every) look(i);
    if (every == 1) return result;
    look(q.size() - 1);
    const std::size_t begin = at - std::min(at, every), end = std::min(q.size(), at + every);
    for (std::size_t i = begin; i < end; ++i) look(i);
    return result;
}
}  // namespace

FastestGrowth fastest_growth(const System& system) {
    return largest(system, [](double q, Complex s) {
        const bool is_conserved = q == 0.0 && s == 0.0;
        return is_conserved ? -infinite : s.real();
    });
}

double fastest_rate(const System& system) {
    return largest(system, [](double, Complex s) { return std::abs(s); }).rate;
}

}  // namespace drover::numerics
