// physics/density_extremes.cpp: extremes of the densities, and errors for those that end a run.
#include "drover/physics/density_extremes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace drover::physics {

Extremes extremes_of(const double* bead_density, const double* rod_density, std::size_t size) {
    Extremes result;
    const auto range = [size](const double* values, double& min, double& max) {
        if (!values) return;
        constexpr std::size_t lanes = 8;  // for the vector instructions of the processor
        std::array<double, lanes> low, high;
        low.fill(min);
        high.fill(max);
        std::size_t i = 0;
        for (; i + lanes <= size; i += lanes)
            for (std::size_t k = 0; k < lanes; ++k) {
                low[k] = values[i + k] < low[k] ? values[i + k] : low[k];
                high[k] = values[i + k] > high[k] ? values[i + k] : high[k];
            }
        for (; i < size; ++i) {
            low[0] = std::min(low[0], values[i]);
            high[0] = std::max(high[0], values[i]);
        }
        min = *std::min_element(low.begin(), low.end());
        max = *std::max_element(high.begin(), high.end());
    };
    range(bead_density, result.min_bead, result.max_bead);
    range(rod_density, result.min_rod, result.max_rod);
    return result;
}

Extremes of_both(const Extremes& a, const Extremes& b) {
    return {.min_bead = std::min(a.min_bead, b.min_bead),
            .max_bead = std::max(a.max_bead, b.max_bead),
            .min_rod = std::min(a.min_rod, b.min_rod),
            .max_rod = std::max(a.max_rod, b.max_rod)};
}

namespace {
template <class... Values>
[[noreturn]] void fail_density(std::string_view pattern, const Values&... values) {
    throw DensityFailure(Fault::run, {}, text(pattern, values...));
}

void check_drag(const CompiledModel& model, const Extremes& extremes) {
    for (const double beads : {extremes.min_bead, extremes.max_bead})
        for (const double rods : {extremes.min_rod, extremes.max_rod})
            if (std::isfinite(beads) && std::isfinite(rods) && model.drag.at(beads, rods).value <= 0.0)
                fail_density(
                    "drag.coefficient is {:.4g} where the bead density is {:.4g} and the rod density {:.4g}; expected "
                    "> 0: a slaved velocity divides by it",
                    model.drag.at(beads, rods).value, beads, rods);
}
}  // namespace

void check_extremes(const CompiledModel& model, const Extremes& extremes, const Divisors& divisors) {
    if (divisors.by_bead_density && extremes.min_bead <= 0.0)
        fail_density(
            "the bead density reached {:.4g} mm-2 on the grid, and the inertia of beads divides by it; a vacuum needs "
            "fields.bead_velocity = \"slaved\"; else expected a density > 0: take a finer grid, a smaller dt or less "
            "noise",
            extremes.min_bead);
    if (divisors.by_drag && !model.drag.table()) check_drag(model, extremes);
    for (const auto& [name, c] : named(model)) {
        if (!c->table()) continue;
        // No term of this right-hand side reads the coefficient: its densities are not on the grid.
        if ((c->depends_on_beads() && !std::isfinite(extremes.min_bead)) ||
            (c->depends_on_rods() && !std::isfinite(extremes.min_rod)))
            continue;
        const auto finite = [](double value) { return std::isfinite(value) ? value : 0.0; };
        for (const auto& [beads, rods] :
             {std::pair{extremes.min_bead, extremes.min_rod}, std::pair{extremes.max_bead, extremes.max_rod}})
            if (std::isnan(c->at(finite(beads), finite(rods)).value))
                fail_density(
                    "the densities reached {:.4g} (beads) and {:.4g} (rods) mm-2, outside the table of {}: {}; "
                    "expected "
                    "them inside: give a wider table, or table.outside = \"hold\"",
                    beads, rods, name, range_text(*c->table()));
    }
}

}  // namespace drover::physics
