// dem/contact/contact_law.hpp: the contact laws. A law is a parameter struct; a soft law is also a pure function from
// the state of a contact to its force. To add a soft law: here its struct and one alternative of ContactLaw, which
// contact_law() makes, its name in ContactModel (setup.hpp), and its own keys, if it has any, in [contacts] (setup.hpp,
// setup_schema.cpp).
#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <variant>
#include <vector>

#include "dem/impact/impact.hpp"
#include "drover/dem/bodies.hpp"
#include "drover/dem/setup.hpp"

namespace drover::dem {

/// A contact of soft bodies at the end of a step.
struct SoftContact {
    double overlap = 0.0;        ///< delta > 0 [mm]
    double opening_speed = 0.0;  ///< u_n, normal velocity of first past second [mm/s]
    double mass = 0.0;           ///< reduced mass of a normal impulse at the point of contact [mg]
    double restitution = 0.0, friction = 0.0;
    Vector stretch;  ///< of the tangential spring before this step, in the tangent plane [mm]
    Vector slip;     ///< tangential displacement of first past second in this step [mm]
    /// Quadrature weight of a force that does not vanish where the contact begins or ends; 1 except in the first and
    /// last step.
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
concept SoftLaw = std::constructible_from<Law, ContactControl> && requires(const Law& law, const SoftContact& contact) {
    { law.contact_time(1.0) } -> std::same_as<double>;  // of an elastic collision of this reduced mass [mg], in s
    { law(contact) } -> std::same_as<SoftForce>;
};

/// The springs of a soft contact.
struct Springs {
    double stiffness = 0.0;             ///< k [mg/s^2]
    double tangential_stiffness = 0.0;  ///< k_t [mg/s^2]

    explicit Springs(const ContactControl& control)
        : stiffness(control.stiffness), tangential_stiffness(control.tangential_stiffness_ratio * control.stiffness) {}
    double contact_time(double mass) const { return std::numbers::pi * std::sqrt(mass / stiffness); }

    /// A linear normal spring with this damping force, and a tangential spring that slips where its force would exceed
    /// friction times `pressing`.
    SoftForce force(const SoftContact& contact, double damping, double pressing) const {
        const double elastic = stiffness * contact.overlap;
        const Vector trial = contact.stretch + contact.slip;
        const double size = length(trial), limit = contact.friction * pressing / tangential_stiffness;
        const Vector stretch = size > limit ? limit / size * trial : trial;
        return {.elastic = elastic,
                .damping = damping,
                .tangential = -tangential_stiffness * stretch,
                .stretch = stretch,
                .stored = 0.5 * (elastic * contact.overlap + tangential_stiffness * dot(stretch, stretch)),
                .slipped = 0.5 * tangential_stiffness * dot(contact.stretch + stretch, trial - stretch)};
    }
};

/// The linear spring-dashpot of Cundall & Strack, Geotechnique 29, 47 (1979).
///
/// Normal force k delta - gamma u_n, with gamma = -2 ln e sqrt(m k/(pi^2 + ln^2 e)): a binary collision has the
/// restitution e at any speed.  The formula assumes that the dashpot may pull before the contact ends (Schwager &
/// Poeschel, Granul. Matter 9, 465 (2007)).
/// Tangential force -k_t s of a spring s that slips where the force would exceed mu k delta.  The limit uses the
/// elastic part of the normal force, whose impulse over a collision equals that of the total: a collision that slides
/// throughout has the tangential impulse mu (1 + e) m |u_n| of the impulse law.
struct SpringDashpot : Springs {
    using Springs::Springs;

    SoftForce operator()(const SoftContact& contact) const {
        const double ln_e = std::log(contact.restitution);
        const double gamma =
            -2.0 * ln_e * std::sqrt(contact.mass * stiffness / (std::numbers::pi * std::numbers::pi + ln_e * ln_e));
        return force(contact, -gamma * contact.opening_speed * contact.edge_weight, stiffness * contact.overlap);
    }
};

/// A linear spring-dashpot that never pulls (Schwager & Poeschel, Granul. Matter 9, 465 (2007)).
///
/// As SpringDashpot, with the normal force max(k delta - gamma u_n, 0), so that bodies part before their spring has
/// relaxed, and with this force in the limit of friction.  A binary collision has the restitution e, with
/// gamma = 2 zeta sqrt(m k) and
///     ln e = -2 zeta arccos(zeta)/sqrt(1 - zeta^2)
/// (beyond zeta = 1, where e = exp(-2), arcosh(zeta)/sqrt(zeta^2 - 1)).
struct RepulsiveSpring : Springs {
    using Springs::Springs;

    /// zeta of a restitution 0 < e <= 1.
    static double damping_ratio(double restitution) {
        // z h(z) = -ln(e)/2 with h = arccos(z)/sqrt(1 - z^2) and h' = (z h - 1)/(1 - z^2), by Newton's method; the
        // start is that of small z, and of large ones.
        const double wanted = -0.5 * std::log(restitution);
        double z = wanted < 1.0 ? wanted * 2.0 / std::numbers::pi : 0.5 * std::exp(wanted);
        for (int step = 0; step < 5; ++step) {
            const double square = 1.0 - z * z;
            double h = 1.0 - (z - 1.0) / 3.0, slope = -1.0 / 3.0 + 4.0 / 15.0 * (z - 1.0);
            if (std::abs(square) > 1e-4) {
                h = square > 0.0 ? std::acos(z) / std::sqrt(square) : std::acosh(z) / std::sqrt(-square);
                slope = (z * h - 1.0) / square;
            }
            z = std::max(z - (z * h - wanted) / (h + z * slope), 0.0);
        }
        return z;
    }

    SoftForce operator()(const SoftContact& contact) const {
        const double elastic = stiffness * contact.overlap,
                     gamma = 2.0 * damping_ratio(contact.restitution) * std::sqrt(contact.mass * stiffness),
                     damping = std::max(-gamma * contact.opening_speed * contact.edge_weight, -elastic);
        return force(contact, damping, elastic + damping);
    }
};

/// Impulses along and across the slip before a contact, in its frame.
struct PairwiseImpulse {
    double n = 0.0, x = 0.0, y = 0.0;  ///< [mg mm/s]
    bool limited = false;              ///< friction was reduced, since the impulse would have created energy
};

/// A contact that approaches: its velocity u and its response K to impulses, see dem/impact/impact_increment.hpp.
struct Response;
struct Slip;

/// Friction that stops the slip if mu allows, and otherwise opposes the slip before with mu times the normal impulse.
/// The normal velocity after is -e u_n in both cases.
///
/// J solves K J = (-e u_n - u_n, -u_t); if |J_t| > mu J_n or J_n <= 0: J = J_n (n - mu t) with t along the slip before
/// and J_n = -(1 + e) u_n/(n.K(n - mu t)).
PairwiseImpulse stop_or_slide(const Response& response, double restitution, double friction, const Slip& slip);

/// The textbook's decoupled impulses: J_n = -(1 + e) u_n/K_nn as without friction, and J_t = min(mu J_n, |u_t|/K_tt)
/// opposite to the slip before.
PairwiseImpulse decoupled(const Response& response, double restitution, double friction, const Slip& slip);

/// Time steps without groups: after each step, every contact that overlaps and approaches gets one impulse, on its own
/// and with the velocities that those before it have left.  Positions are never corrected: an overlap lasts until the
/// bodies have parted; without rebound (e = 0) those of bodies at rest grow.  Overlaps with the plates count as those
/// of pairs do, and a run fails where one is larger than contacts.max_overlap.
///
/// A step changes the velocity by gravity and then the position by the new velocity.  Beads move by a time step and
/// then have their contacts with base and lid.  Rods move in equal steps of at most rod_step; after each, their
/// contacts with the plates follow in `order` (tail_first: from tail to head, of each sphere the base before the lid;
/// fastest_first: each time the fastest approach of those that have not had their impulse). Pairs and side walls follow
/// in the order of the neighbour list, forwards and backwards in turn.  A sequence has a direction, so a rod whose ends
/// are alike may drift with any order but random.
///
/// Friction along the slip before the impulse can do positive work where the slip turns: for decoupled(), an impulse
/// changes the energy by its loss along the normal and by friction, less J_n J_t K_nt.  No impulse creates energy:
/// where it would, friction is reduced to the largest value that does not (Counts::limited).
struct PairwiseLaw {
    static PairwiseLaw from(const ContactControl& control);
    static bool is_chosen(const ContactControl& control) {
        return control.model == ContactModel::impulse && control.law == GroupLaw::pairwise;
    }

    PairwiseImpulse (*friction)(const Response&, double, double, const Slip&) = stop_or_slide;
    ContactOrder order = ContactOrder::tail_first;
    double rod_step = 2e-6;  ///< [s]

    /// Number of equal steps of rods within a time step, and their length.
    int rod_steps(double dt) const { return std::max(1, static_cast<int>(std::ceil(dt / rod_step - 1e-9))); }
    double rod_step_within(double dt) const { return dt / rod_steps(dt); }
};

using ContactLaw = std::variant<ImpactLaw, PairwiseLaw, SpringDashpot, RepulsiveSpring>;

/// The law that contacts.model and contacts.law name, with its parameters.
ContactLaw contact_law(const ContactControl& control);

/// Throws an input Error unless dt is above 0 and resolves the vibration; of a soft law, unless all coefficients of
/// restitution are above 0 and dt resolves the shortest contact of two of these shapes.
void check_contact_law(const Setup& setup, const std::vector<Shape>& shapes, double dt, const Locate& locate);

}  // namespace drover::dem
