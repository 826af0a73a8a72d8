// dem/contact_law.hpp: the contact laws.  A law is a parameter struct; a soft law is also a pure function from the state of a contact to its
// force.  To add a soft law: its keys in [contacts] (setup.hpp, setup_schema.cpp), and here its struct and one alternative of ContactLaw.
#pragma once
#include <concepts>
#include <string>
#include <variant>
#include <vector>

#include "drover/dem/impact.hpp"
#include "drover/dem/setup.hpp"
#include "drover/dem/shape.hpp"

namespace drover::dem {

/// A contact of soft bodies at the end of a step.
struct SoftContact {
    double overlap = 0.0;        ///< delta > 0 [mm]
    double opening_speed = 0.0;  ///< u_n, normal velocity of first past second [mm/s]
    double mass = 0.0;           ///< reduced mass of a normal impulse at the point of contact [mg]
    double restitution = 0.0, friction = 0.0;
    Vector stretch;  ///< of the tangential spring before this step, in the tangent plane [mm]
    Vector slip;     ///< tangential displacement of first past second in this step [mm]
    /// Quadrature weight of a force that does not vanish where the contact begins or ends; 1 except in the first and last step.
    double edge_weight = 1.0;
};

struct SoftForce {
    double elastic = 0.0;  ///< normal, pushes apart [mg mm/s^2]
    double damping = 0.0;  ///< normal, the part that dissipates energy
    Vector tangential;     ///< on first
    Vector stretch;        ///< of the tangential spring now [mm]
    double stored = 0.0;   ///< elastic energy now [mg mm^2/s^2]
    double slipped = 0.0;  ///< energy lost to sliding in this step, >= 0
};

/// What a soft law provides.
template <class Law>
concept SoftLaw = requires(const Law& law, const SoftContact& contact, const ContactControl& control) {
    { Law::name } -> std::convertible_to<const char*>;
    { Law::from(control) } -> std::same_as<Law>;
    { law.contact_time(1.0) } -> std::same_as<double>;  // of an elastic collision of this reduced mass [mg], in s
    { law(contact) } -> std::same_as<SoftForce>;
};

using ContactLaw = std::variant<ImpactLaw>;

/// The values of contacts.model.
std::vector<std::string> contact_models();

/// The law that contacts.model names, with its parameters.
ContactLaw contact_law(const ContactControl& control);

/// Of a soft law, throws an input Error unless all coefficients of restitution are above 0 and dt resolves the shortest contact of two of
/// these shapes.
void check_contact_law(const Setup& setup, const std::vector<Shape>& shapes, double dt, const LocationOf& place);

}  // namespace drover::dem
