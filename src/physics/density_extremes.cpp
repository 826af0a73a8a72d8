// physics/density_extremes.cpp: errors for densities that end a run.
#include "drover/physics/density_extremes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace drover::physics {

namespace {
template <class... Values>
[[noreturn]] void fail_density(int component, std::string_view pattern, const Values&... values) {
    throw model::DomainFailure(text(pattern, values...), component);
}

void check_drag(const CompiledModel& model, const Extremes& extremes) {
    for (const double beads : {extremes.min_bead, extremes.max_bead})
        for (const double rods : {extremes.min_rod, extremes.max_rod})
            if (std::isfinite(beads) && std::isfinite(rods) && model.drag.at(beads, rods).value <= 0.0)
                fail_density(
                    -1,
                    "drag.coefficient is {:.4g} where the bead density is {:.4g} and the rod density {:.4g}; expected "
                    "> 0: a slaved velocity divides by it",
                    model.drag.at(beads, rods).value, beads, rods);
}
}  // namespace

void check_extremes(const CompiledModel& model, const Extremes& extremes, const Divisors& divisors) {
    if (divisors.by_bead_density && extremes.min_bead <= 0.0)
        fail_density(
            model.form.bead_density,
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
                    model.form.bead_density,
                    "the densities reached {:.4g} (beads) and {:.4g} (rods) mm-2, outside the table of {}: {}; "
                    "expected "
                    "them inside: give a wider table, or table.outside = \"hold\"",
                    beads, rods, name, range_text(*c->table()));
    }
}

}  // namespace drover::physics
