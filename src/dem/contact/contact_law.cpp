// dem/contact/contact_law.cpp: the choice of the contact law, and the time step that a soft law needs.
#include "dem/contact/contact_law.hpp"

namespace drover::dem {

namespace {
constexpr double min_steps = 20.0;  // of dt within the shortest contact

/// Smallest reduced mass of a contact of two bodies [mg].
double min_reduced_mass(const std::vector<Shape>& shapes) {
    double response = 0.0;  // largest change of the normal velocity at a contact of a body per normal impulse [1/mg]
    for (const Shape& shape : shapes)
        for (const double at : shape.at)
            response = std::max(response, 1.0 / shape.mass + at * at / shape.inertia_across);
    return 0.5 / response;
}

void check_restitution(const Setup& setup, const Locate& locate) {
    for (const auto& [name, value] : values_of(setup.restitution)) {
        const std::string key = "restitution." + name;
        require(std::get<double>(value) > 0.0, locate(key),
                "{} = 0 with contacts.model = \"{}\": such a contact never ends; expected a value above 0, or "
                "contacts.model = \"impulse\"",
                key, setup.contacts.model);
    }
}
}  // namespace

ImpactLaw ImpactLaw::from(const ContactControl& control) {
    return {.group = control.law,
            .restitution = control.restitution,
            .track_slip = control.track_slip,
            .increments = control.increments,
            .inelastic_threshold = control.inelastic_threshold};
}

PairwiseLaw PairwiseLaw::from(const ContactControl& control) {
    PairwiseLaw law{.friction = StopOrSlide{}, .order = control.order, .rod_step = control.rod_step};
    if (control.friction == PairwiseFriction::decoupled) law.friction = Decoupled{};
    return law;
}

ContactLaw contact_law(const ContactControl& control) {
    switch (control.model) {
        case ContactModel::spring_dashpot: return SpringDashpot::from(control);
        case ContactModel::repulsive_spring: return RepulsiveSpring::from(control);
        case ContactModel::impulse: break;
    }
    if (PairwiseLaw::is_chosen(control)) return PairwiseLaw::from(control);
    return ImpactLaw::from(control);
}

void check_contact_law(const Setup& setup, const std::vector<Shape>& shapes, double dt, const Locate& locate) {
    require(dt > 0.0 && std::isfinite(dt), locate("time.dt"), "time.dt = {} s; expected a finite number > 0", dt);
    const auto check = [&]<class Law>(const Law& law) {
        if constexpr (std::is_same_v<Law, PairwiseLaw>) {
            constexpr double periods = 0.05;
            require(
                dt * setup.plates.frequency <= periods, locate("time.dt"),
                "time.dt = {} s with plates.frequency = {} 1/s and contacts.law = \"pairwise\"; expected at most {} "
                "of a period: otherwise beads penetrate the plates",
                dt, setup.plates.frequency, periods);
        }
        if constexpr (SoftLaw<Law>) {
            check_restitution(setup, locate);
            if (shapes.empty()) return;
            constexpr double below = 0.995;  // the limit, when it is printed with three digits
            const double shortest = law.contact_time(min_reduced_mass(shapes)), steps = shortest / dt;
            require(steps >= min_steps * (1.0 - 1e-9), locate("time.dt"),
                    "time.dt = {} s is {:.3g} steps of the shortest contact, {:.3g} s; expected at least {} with "
                    "contacts.model = \"{}\": choose time.dt <= {:.3g}, or softer contacts",
                    dt, steps, shortest, min_steps, setup.contacts.model, below * shortest / min_steps);
        }
    };
    std::visit(check, contact_law(setup.contacts));
    // The motion of the plates within a step is a series in dt times the frequency.
    constexpr double min_steps_of_period = 20.0;
    const Plates& plates = setup.plates;
    const double steps = 1.0 / (dt * plates.frequency);
    require(plates.amplitude == 0.0 || steps >= min_steps_of_period, locate("time.dt"),
            "time.dt = {} s is {:.3g} steps a period of plates.frequency = {} 1/s; expected at least {}: choose a "
            "smaller time.dt",
            dt, steps, plates.frequency, min_steps_of_period);
}

}  // namespace drover::dem
