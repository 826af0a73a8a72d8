// physics/point_arrays.cpp: places of arrays, from what the terms read and write.
#include "point_arrays.hpp"

#include <algorithm>

#include "drover/physics/term.hpp"

namespace drover::physics {

namespace {
/// The mass that forces move depends on the density: m rho d_t v.
bool mass_varies(const Equations& e) { return e.form.velocity == Velocity::dynamic && e.form.bead_density >= 0; }
bool has_force(const Equations& e) {
    return std::any_of(e.active.begin(), e.active.end(), [](const Term* term) { return is_force_on_beads(*term); });
}
}  // namespace

unsigned reads_of(const Coefficient& c) {
    return (c.depends_on_beads() ? unsigned{reads_beads} : 0u) | (c.depends_on_rods() ? unsigned{reads_rods} : 0u);
}

bool slaved_varies(const Equations& e) {
    return e.form.velocity == Velocity::slaved && (e.drag.varies() || e.driving.varies());
}

Arrays arrays_of(const Equations& e) {
    unsigned reads = 0, writes = 0;
    for (const Term* term : e.active)
        if (term->cost) {
            const Action action = term->cost(e);
            reads |= action.reads;
            writes |= action.writes;
        }
    const bool divides = mass_varies(e) && has_force(e);
    if (divides) {
        reads |= reads_beads;
        writes |= writes_velocity;
    }
    if (writes & writes_force) writes |= writes_velocity;
    if (slaved_varies(e) && (reads & reads_velocity)) reads |= reads_order | reads_of(e.drag) | reads_of(e.driving);
    Arrays a;
    const auto place = [](bool wanted, int width, int& next, int& at) {
        if (!wanted) return;
        at = next;
        next += width;
    };
    // Vectors first: two arrays are transformed as one.
    place(reads & reads_velocity, 2, a.back, a.velocity);
    place(reads & reads_order, 2, a.back, a.order);
    place(divides, 2, a.back, a.force);
    place(reads & reads_beads, 1, a.back, a.beads);
    place(reads & reads_rods, 1, a.back, a.rods);
    place(reads & reads_velocity_curl, 1, a.back, a.velocity_curl);
    place(reads & reads_order_curl, 1, a.back, a.order_curl);
    place(writes & writes_bead_flux, 2, a.forth, a.bead_flux);
    place(writes & writes_rod_flux, 2, a.forth, a.rod_flux);
    place(writes & writes_velocity, 2, a.forth, a.velocity_rate);
    place(writes & writes_order, 2, a.forth, a.order_rate);
    place(writes & writes_velocity_head, 1, a.forth, a.velocity_head);
    place(writes & writes_order_head, 1, a.forth, a.order_head);
    return a;
}

}  // namespace drover::physics
