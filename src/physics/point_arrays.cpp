// physics/point_arrays.cpp: positions of arrays, from what the terms read and write.
#include "point_arrays.hpp"

#include <algorithm>

#include "term_shapes.hpp"

namespace drover::physics {

namespace {
/// The mass that forces move depends on the density: m rho d_t v.
bool mass_varies(const Equations& e) { return e.form.velocity == Velocity::dynamic && e.form.bead_density >= 0; }

bool is_force(const Term& term) { return term.of == Equation::bead_velocity; }

struct Wanted {
    std::uint64_t read = 0;
    unsigned written = 0;
    bool linear_force = false;
};

Wanted wanted_by(const Equations& e) {
    const bool slaved = e.form.velocity == Velocity::slaved;
    Wanted wanted;
    PointCost forces;
    for (const Term& term : e.active) {
        const PointCost cost = point_cost(e, term);
        if (slaved && is_force(term)) {
            forces.reads |= cost.reads;
            continue;
        }
        wanted.read |= cost.reads;
        wanted.written |= cost.writes;
    }
    wanted.linear_force = mass_varies(e) && std::any_of(e.active.begin(), e.active.end(), is_force);
    if (wanted.linear_force) {
        wanted.read |= reads(Input::bead_density);
        wanted.written |= writes(Output::velocity);
    }
    if (wanted.written & writes(Output::force)) wanted.written |= writes(Output::velocity);
    if (has_pointwise_velocity(e) && (wanted.read & reads_velocity)) wanted.read |= forces.reads | reads_of(e.drag);
    return wanted;
}
}  // namespace

Arrays arrays_of(const Equations& e) {
    const Wanted wanted = wanted_by(e);
    Arrays a;
    a.in.fill(-1);
    a.out.fill(-1);
    const auto place = [](bool is_wanted, int width, int* at, int& next) {
        for (int i = 0; is_wanted && i < width; ++i) at[i] = next++;
    };
    const auto read = [&](int input, int width) {
        place(wanted.read & reads(input), width, &a.in[static_cast<std::size_t>(input)], a.inverse);
    };
    // Vectors first: two arrays are transformed as one.
    read(Input::bead_velocity_x, 2);
    read(Input::polar_order_x, 2);
    if (wanted.linear_force) {
        a.linear_force = a.inverse;
        a.inverse += 2;
    }
    read(Input::bead_density, 1);
    read(Input::rod_density, 1);
    read(Input::velocity_curl, 1);
    read(Input::order_curl, 1);
    for (int input = Input::d_x; input < Input::x; ++input)
        if (input != Input::velocity_curl && input != Input::order_curl) read(input, 1);
    for (const int output : {Output::bead_flux, Output::rod_flux, Output::velocity, Output::order})
        place(wanted.written & writes(output), 2, &a.out[static_cast<std::size_t>(output)], a.forward);
    for (const int output : {Output::velocity_potential, Output::order_potential, Output::bead_rate, Output::rod_rate})
        place(wanted.written & writes(output), 1, &a.out[static_cast<std::size_t>(output)], a.forward);
    return a;
}

}  // namespace drover::physics
