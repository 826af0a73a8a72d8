// dem/contact/pair_impacts.cpp: groups overlapping spheres and resolves the impacts of each group.
#include "dem/contact/pair_impacts.hpp"

#include <algorithm>
#include <cmath>

#include "dem/contact/contact_report.hpp"

namespace drover::dem {

namespace {
std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t t) {
    while (parent[t] != t) {
        parent[t] = parent[parent[t]];
        t = parent[t];
    }
    return t;
}

/// The smaller index becomes the root, so groups are ordered by their first overlap.
void join(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b) parent[b] = a;
    else parent[a] = b;
}

/// Velocity of the centre of a sphere.
Vector velocity_of(const Spheres& spheres, std::uint32_t sphere, const ImpactBody& body) {
    if (spheres.is_bead(sphere)) return body.velocity;
    return body.velocity + cross(body.spin, from_centre(spheres, sphere));
}

/// Sets the time since first contact, at most dt, and the normal at that time, by the relative velocity now.
void trace_back_to_contact(Overlap& overlap, const Vector& velocity, double dt) {
    const double across = dot(overlap.apart, velocity), square = dot(velocity, velocity);
    const double inside = overlap.reach * overlap.reach - dot(overlap.apart, overlap.apart);
    overlap.since = 0.0;
    if (across < 0.0) {
        // Solves |d - v t| = reach without cancellation.
        const double root = std::sqrt(across * across + square * inside);
        overlap.since = std::min(dt, inside / (root - across));
    }
    const Vector then = overlap.apart - overlap.since * velocity;
    overlap.normal = 1.0 / length(then) * then;
}

/// The same for a sphere at a wall, whose normal changes along the way of the sphere where it is curved.
void trace_back_to_wall(Overlap& overlap, const Vec4d& place, const Vector& velocity, double dt, const Walls& walls) {
    overlap.since = 0.0;
    double distance = dot(overlap.apart, overlap.normal);
    constexpr int steps = 4;  // Newton's, for a distance that is all but linear in time
    constexpr double rounding = 1e-14;
    for (int n = 0; n < steps && std::abs(overlap.reach - distance) > rounding * overlap.reach; ++n) {
        const double closing = -dot(overlap.normal, velocity);
        if (closing <= 0.0) return;
        overlap.since = std::clamp(overlap.since + (overlap.reach - distance) / closing, 0.0, dt);
        WallPoint points[4];
        const double x = place[0] - overlap.since * velocity.x, y = place[1] - overlap.since * velocity.y;
        const int count = walls.near(x, y, overlap.reach + dt * length(velocity), points);
        const auto along = [&](const WallPoint& wall) {
            return wall.nx * overlap.normal.x + wall.ny * overlap.normal.y;
        };
        const WallPoint* const same =
            std::max_element(points, points + count, [&](const auto& a, const auto& b) { return along(a) < along(b); });
        if (same == points + count) return;
        distance = same->distance;
        overlap.normal = {same->nx, same->ny, 0.0};
    }
}

/// Normals with a larger vertical component press a body that rests on a plate into it.
constexpr double steep = 0.05;

/// Whether a sphere at this position that is pushed up (side +1) or down (-1) is held by the lid or the base.
bool is_held(const Vec4d& position, double side, const StepRules& rules) {
    const double gap =
        side > 0.0 ? rules.lid - position[2] - position[3] : position[2] - position[3] - rules.base.height;
    return gap < rules.simultaneity_gap;
}

/// Whether one of two beads presses the other onto a plate.
bool presses_on_plate(const Overlap& overlap, const Spheres& spheres, const StepRules& rules) {
    if (std::abs(overlap.apart.z) < steep * overlap.reach) return false;
    const double up = overlap.apart.z > 0.0 ? 1.0 : -1.0;
    return is_held(spheres.position[overlap.first], up, rules) || is_held(spheres.position[overlap.second], -up, rules);
}

void resolve_beads(Overlap& overlap, Spheres& spheres, const StepRules& rules, ContactReport& report) {
    const Vec4d &va = spheres.beads.velocity[overlap.first], &vb = spheres.beads.velocity[overlap.second];
    const Vector apart = vector_of(va) - vector_of(vb);
    if (dot(apart, overlap.apart) >= 0.0) return;
    trace_back_to_contact(overlap, apart, rules.dt);
    Vec4d &pa = spheres.position[overlap.first], &pb = spheres.position[overlap.second];
    const auto impulse = bounce_beads(overlap, apart, overlap.normal, pa[3], pb[3], spheres, rules, report);
    if (!impulse) return;
    const Vector da = va[3] * *impulse, db = -vb[3] * *impulse;
    set_vector(pa, vector_of(pa) + overlap.since * da);
    set_vector(pb, vector_of(pb) + overlap.since * db);
    // The weights cancel in the position correction; the work of other forces on it is of no impulse.
    report.balance.plates -= overlap.since * dot(rules.bead_force, da + db);
}

/// Resolves any group.
class GroupSolver {
public:
    GroupSolver(const Walls& walls, Spheres& spheres, const StepRules& rules)
        : walls_(walls), spheres_(spheres), rules_(rules) {}

    void resolve_group(std::span<Overlap*> overlaps, ContactReport& report) {
        bodies_.clear();
        indices_.clear();
        contacts_.clear();
        for (const Overlap* overlap : overlaps) {
            add_body(overlap->first_body);
            if (!overlap->is_with_surface()) add_body(overlap->second_body);
        }
        for (Overlap* overlap : overlaps) contacts_.push_back(contact_of(*overlap));
        const std::size_t pairs = overlaps.size();
        for (const Overlap* overlap : overlaps) add_plates(*overlap);
        for (std::size_t c = 0; c < pairs; ++c)
            if (dot(relative_velocity(contacts_[c], bodies_), contacts_[c].normal) < -counted_speed)
                count_impact(*overlaps[c], spheres_, report.counts);
        const ImpactOutcome outcome = resolve(bodies_, contacts_, rules_.law);
        if (outcome.approach == 0.0) return;
        if (!std::isfinite(outcome.normal + outcome.friction + outcome.walls + outcome.residual))
            return record_failure(overlaps, report);
        record(outcome, report);
        for (std::size_t b = 0; b < bodies_.size(); ++b) store(bodies_[b], spheres_, indices_[b]);
        // One time for the whole group: its bodies move as if they had had their new velocities since then, so none
        // moves into another.
        double since = 0.0;
        for (const Overlap* overlap : overlaps) since = std::max(since, overlap->since);
        for (std::size_t c = 0; c < pairs; ++c) {
            const Vector shift = since * contacts_[c].impulse;
            move(overlaps[c]->first_body, shift, report);
            if (!overlaps[c]->is_with_surface()) move(overlaps[c]->second_body, -1.0 * shift, report);
        }
    }

private:
    /// The first impulse that is not finite; the bodies keep their state before the impact.
    void record_failure(std::span<Overlap*> overlaps, ContactReport& report) const {
        if (!report.failure.empty()) return;
        std::size_t c = 0;
        while (c + 1 < overlaps.size() && std::isfinite(length(contacts_[c].impulse))) ++c;
        report.failure =
            describe_impact(*overlaps[c], spheres_, contacts_[c].restitution, contacts_[c].friction, contacts_.size());
    }
    int index_of(std::uint32_t body) const {
        return static_cast<int>(std::ranges::find(indices_, body) - indices_.begin());
    }
    void add_body(std::uint32_t body) {
        if (index_of(body) < static_cast<int>(indices_.size())) return;
        indices_.push_back(body);
        bodies_.push_back(impact_body_of(spheres_, body));
    }
    Contact contact_of(Overlap& overlap) const {
        Contact contact{.first = index_of(overlap.first_body), .second = -1};
        const bool surface = overlap.is_with_surface();
        Vector velocity = velocity_of(spheres_, overlap.first, bodies_[static_cast<std::size_t>(contact.first)]);
        if (!surface) {
            contact.second = index_of(overlap.second_body);
            velocity =
                velocity - velocity_of(spheres_, overlap.second, bodies_[static_cast<std::size_t>(contact.second)]);
        }
        if (surface) trace_back_to_wall(overlap, spheres_.position[overlap.first], velocity, rules_.dt, walls_);
        else trace_back_to_contact(overlap, velocity, rules_.dt);
        contact.normal = overlap.normal;
        contact.arm_first = arm_of(spheres_, overlap.first, 1.0, overlap.normal, 0.0);
        if (!surface) contact.arm_second = arm_of(spheres_, overlap.second, -1.0, overlap.normal, 0.0);
        const Coefficients c = coefficients_of(overlap, spheres_, rules_.restitution, rules_.friction);
        contact.restitution = c.restitution;
        contact.friction = c.friction;
        return contact;
    }
    /// Adds the contacts with the plates that hold the bodies pressed onto them.
    void add_plates(const Overlap& overlap) {
        if (overlap.is_with_surface() || std::abs(overlap.normal.z) < steep) return;
        const double up = overlap.normal.z > 0.0 ? 1.0 : -1.0;
        add_plate(overlap.first_body, overlap.first, up);
        add_plate(overlap.second_body, overlap.second, -up);
    }
    void add_plate(std::uint32_t body, std::uint32_t sphere, double side) {
        const int index = index_of(body);
        const auto is_known = [&](const Contact& c) {
            return c.second < 0 && c.first == index && c.wall_velocity.z == rules_.base.velocity && c.normal.z == -side;
        };
        if (std::ranges::any_of(contacts_, is_known)) return;
        const bool bead = spheres_.is_bead(sphere);
        const Coefficients c = plate_coefficients(rules_.restitution, rules_.friction, bead);
        Contact contact{.first = index, .second = -1, .normal = {0.0, 0.0, -side}};
        contact.wall_velocity = {0.0, 0.0, rules_.base.velocity};
        contact.restitution = c.restitution;
        contact.friction = c.friction;
        const auto add = [&](std::uint32_t s) {
            if (!is_held(spheres_.position[s], side, rules_)) return;
            contact.arm_first = from_centre(spheres_, s) + side * spheres_.position[s][3] * Vector{0.0, 0.0, 1.0};
            contacts_.push_back(contact);
        };
        if (bead) return add(sphere);
        const RodArrays& rods = spheres_.rods;
        const std::uint32_t r = spheres_.rod(sphere);
        for (const std::uint32_t k : rods.kinds[rods.kind[r]].bearing) add(rods.first[r] + k);
    }
    void record(const ImpactOutcome& outcome, ContactReport& report) const {
        report.balance.impact += outcome.normal;
        report.balance.friction += outcome.friction;
        report.balance.plates += outcome.walls;
        if (contacts_.size() <= 1) return;
        ++report.counts.groups;
        report.counts.largest_group =
            std::max(report.counts.largest_group, static_cast<std::int64_t>(contacts_.size()));
        report.counts.residual = std::max(report.counts.residual, outcome.residual / outcome.approach);
        if (outcome.left > rules_.law.tolerance * outcome.approach) ++report.counts.unresolved;
    }
    /// Moves a body by a vector over its mass: the work of gravity and forces on it is of no impulse.
    void move(std::uint32_t body, const Vector& mass_shift, ContactReport& report) {
        const auto beads = static_cast<std::uint32_t>(spheres_.beads.size());
        if (body < beads) {
            Vec4d& position = spheres_.position[body];
            const double inverse = spheres_.beads.velocity[body][3];
            set_vector(position, vector_of(position) + inverse * mass_shift);
            report.balance.plates -= dot(rules_.acceleration + inverse * rules_.bead_force, mass_shift);
        } else {
            const std::uint32_t r = body - beads;
            Rod& rod = spheres_.rods.rod[r];
            const double mass = spheres_.shape_of_rod(r).mass, work = dot(rules_.rod_acceleration(mass), mass_shift);
            rod.position = rod.position + 1.0 / mass * mass_shift;
            report.balance.gravity += work;
            report.balance.plates -= work;
        }
    }

    const Walls& walls_;
    Spheres& spheres_;
    const StepRules& rules_;
    std::vector<std::uint32_t> indices_;  // of the bodies of the group
    std::vector<ImpactBody> bodies_;
    std::vector<Contact> contacts_;
};
}  // namespace

void PairImpacts::group(const std::vector<Overlap>& overlaps, std::size_t bodies) {
    constexpr std::uint32_t none = Overlap::side_wall;
    const auto count = static_cast<std::uint32_t>(overlaps.size());
    last_.resize(bodies, none);
    parent_.resize(count);
    order_.resize(count);
    start_.clear();
    for (std::uint32_t t = 0; t < count; ++t) {
        parent_[t] = t;
        for (const std::uint32_t body : {overlaps[t].first_body, overlaps[t].second_body}) {
            if (body == none) continue;
            if (last_[body] != none) join(parent_, t, last_[body]);
            last_[body] = t;
        }
    }
    for (const Overlap& overlap : overlaps) {
        last_[overlap.first_body] = none;
        if (overlap.second_body != none) last_[overlap.second_body] = none;
    }
    // Counting sort by root keeps the order within a group.
    size_.assign(count + 1, 0);
    for (std::uint32_t t = 0; t < count; ++t) ++size_[root_of(parent_, t) + 1];
    for (std::uint32_t t = 0; t < count; ++t) {
        if (size_[t + 1] > 0) start_.push_back(size_[t]);
        size_[t + 1] += size_[t];
    }
    start_.push_back(count);
    for (std::uint32_t t = 0; t < count; ++t) order_[size_[root_of(parent_, t)]++] = t;
}

ContactReport PairImpacts::step(const Walls& walls, Spheres& spheres, const Neighbours& neighbours,
                                const StepRules& rules, Threads& threads) {
    std::vector<Overlap>& overlaps = search_.find(walls, spheres, neighbours, threads);
    group(overlaps, spheres.beads.size() + spheres.rods.size());
    constexpr std::size_t groups_per_chunk = 32;
    const std::size_t groups = start_.size() - 1, chunks = groups / groups_per_chunk + 1;
    reports_.assign(chunks, {});
    threads.for_chunks(chunks, 1, [&](std::size_t first, std::size_t last) {
        GroupSolver solver(walls, spheres, rules);
        std::vector<Overlap*> members;
        for (std::size_t c = first; c < last; ++c) {
            ContactReport& report = reports_[c];
            for (std::size_t g = c * groups_per_chunk; g < std::min((c + 1) * groups_per_chunk, groups); ++g) {
                members.clear();
                for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) {
                    Overlap& overlap = overlaps[order_[i]];
                    members.push_back(&overlap);
                    record_depth(overlap, spheres, report);
                }
                Overlap& only = *members.front();
                if (members.size() == 1 && is_pair_of_beads(only, spheres) && !presses_on_plate(only, spheres, rules))
                    resolve_beads(only, spheres, rules, report);
                else solver.resolve_group(members, report);
            }
        }
    });
    ContactReport total;
    for (const ContactReport& report : reports_) add(report, total);
    return total;
}

}  // namespace drover::dem
