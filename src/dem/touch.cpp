// dem/touch.cpp: finding overlaps, grouping them, and resolving the groups.
#include "touch.hpp"

#include <algorithm>
#include <cmath>

namespace drover::dem {

namespace {
constexpr std::uint32_t none = Touch::no_sphere;

Touch touch_of(const Spheres& spheres, std::uint32_t a, std::uint32_t b, double x, double y) {
    const Lane &pa = spheres.place[a], &pb = spheres.place[b];
    return {.first = a,
            .second = b,
            .first_body = spheres.body(a),
            .second_body = spheres.body(b),
            .apart = {pa[0] - pb[0] - x, pa[1] - pb[1] - y, pa[2] - pb[2]},
            .reach = pa[3] + pb[3],
            .since = 0.0,
            .normal = {}};
}

/// Squared distances of four pairs minus the squares of their reaches: negative where they overlap.
Lane beyond(const Lane* place, const SpherePair* pairs) {
    Lane d[4], s[4];
    for (int k = 0; k < 4; ++k) {
        const Lane &a = place[pairs[k].first], &b = place[pairs[k].second];
        d[k] = a - b;
        s[k] = a + b;
        d[k] *= d[k];
    }
    // Columns of the four rows: x, y, z of the squares; the reach is the last of the sums.
    const Lane xy01 = __builtin_shufflevector(d[0], d[1], 0, 4, 1, 5),
               xy23 = __builtin_shufflevector(d[2], d[3], 0, 4, 1, 5);
    const Lane zw01 = __builtin_shufflevector(d[0], d[1], 2, 6, 3, 7),
               zw23 = __builtin_shufflevector(d[2], d[3], 2, 6, 3, 7);
    const Lane x = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5), y = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7);
    const Lane z = __builtin_shufflevector(zw01, zw23, 0, 1, 4, 5);
    const Lane r01 = __builtin_shufflevector(s[0], s[1], 3, 7, 3, 7),
               r23 = __builtin_shufflevector(s[2], s[3], 3, 7, 3, 7);
    const Lane reach = __builtin_shufflevector(r01, r23, 0, 1, 4, 5);
    return x + y + z - reach * reach;
}

void find_pairs(const Spheres& spheres, const std::vector<SpherePair>& pairs, std::vector<Touch>& found) {
    const Lane* place = spheres.place.data();
    const std::size_t end = pairs.size();
    std::size_t p = 0;
    const auto take = [&](std::size_t q) {
        found.push_back(touch_of(spheres, pairs[q].first, pairs[q].second, 0.0, 0.0));
    };
    for (; p + 4 <= end; p += 4) {
        const Lane value = beyond(place, &pairs[p]);
        const auto negative = value < 0.0;
        if (negative[0] | negative[1] | negative[2] | negative[3]) [[unlikely]]
            for (std::size_t k = 0; k < 4; ++k)
                if (value[k] < 0.0) take(p + k);
    }
    for (; p < end; ++p) {
        const Touch touch = touch_of(spheres, pairs[p].first, pairs[p].second, 0.0, 0.0);
        if (dot(touch.apart, touch.apart) < touch.reach * touch.reach) found.push_back(touch);
    }
}

void find_images(const Spheres& spheres, const std::vector<ImagePair>& pairs, std::vector<Touch>& found) {
    for (const ImagePair& pair : pairs) {
        const Touch touch = touch_of(spheres, pair.first, pair.second, pair.x, pair.y);
        if (dot(touch.apart, touch.apart) < touch.reach * touch.reach) found.push_back(touch);
    }
}

void find_walls(const Walls& side, const Spheres& spheres, const std::vector<std::uint32_t>& near,
                std::vector<Touch>& found) {
    WallPoint walls[4];
    for (const std::uint32_t s : near) {
        const Lane& place = spheres.place[s];
        const int count = side.near(place[0], place[1], place[3], walls);
        for (int w = 0; w < count; ++w) {
            if (walls[w].distance >= place[3]) continue;
            found.push_back({.first = s,
                             .second = none,
                             .first_body = spheres.body(s),
                             .second_body = none,
                             .apart = walls[w].distance * Vector{walls[w].nx, walls[w].ny, 0.0},
                             .reach = place[3],
                             .since = 0.0,
                             .normal = {walls[w].nx, walls[w].ny, 0.0}});
        }
    }
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t t) {
    while (parent[t] != t) {
        parent[t] = parent[parent[t]];
        t = parent[t];
    }
    return t;
}

/// The smaller is the root: groups come in the order of their first touch.
void join(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b) parent[b] = a;
    else parent[a] = b;
}

Mover mover_of_bead(const BeadArrays& beads, std::uint32_t s) {
    return {.velocity = vector_of(beads.velocity[s]),
            .spin = vector_of(beads.spin[s]),
            .axis = {1.0, 0.0, 0.0},
            .mass_inverse = beads.velocity[s][3],
            .across_inverse = beads.spin[s][3],
            .along_inverse = beads.spin[s][3]};
}

/// Velocity of the centre of a sphere.
Vector velocity_of(const Spheres& spheres, std::uint32_t sphere, const Mover& mover) {
    if (spheres.is_bead(sphere)) return mover.velocity;
    const std::uint32_t r = spheres.rod(sphere);
    return mover.velocity + cross(mover.spin, vector_of(spheres.place[sphere]) - spheres.rods.rod[r].position);
}

/// How long ago they touched, at their velocity now, and along which normal: both at most one step ago.
void go_back(Touch& touch, const Vector& velocity, double dt) {
    const double across = dot(touch.apart, velocity), square = dot(velocity, velocity);
    const double inside = touch.reach * touch.reach - dot(touch.apart, touch.apart);
    touch.since = 0.0;
    if (across < 0.0) {
        // |d - v t| = reach; v.d < 0: t = (-sqrt((v.d)^2 + v^2 inside) ... ) without cancellation.
        const double root = std::sqrt(across * across + square * inside);
        touch.since = std::min(dt, inside / (root - across));
    }
    const Vector then = touch.apart - touch.since * velocity;
    if (touch.second != none) touch.normal = 1.0 / length(then) * then;
}
double overlap_of(const Touch& touch, const Spheres& spheres) {
    // A sphere whose centre is behind a wall lies along -normal.
    const double distance = touch.second == none ? dot(touch.apart, touch.normal) : length(touch.apart);
    return (touch.reach - distance) / smaller_radius(touch, spheres);
}

void count_impact(const Touch& touch, const Spheres& spheres, Counts& counts) {
    const bool first = spheres.is_bead(touch.first);
    if (touch.second == none) ++(first ? counts.bead_wall : counts.rod_wall);
    else if (spheres.is_bead(touch.second) != first) ++counts.rod_bead;
    else ++(first ? counts.bead_bead : counts.rod_rod);
}

/// Contacts steeper than this press a body that stands on a plate into it.
constexpr double steep = 0.05;

/// Whether a sphere at this place, pushed up (side +1) or down (-1), is held by the lid or the base.
bool is_held(const Lane& place, double side, const TouchRules& rules) {
    const double gap = side > 0.0 ? rules.lid - place[2] - place[3] : place[2] - place[3] - rules.base.at;
    return gap < rules.together;
}

/// Whether one of two beads is pressed onto a plate by the other.
bool is_pressed(const Touch& touch, const Spheres& spheres, const TouchRules& rules) {
    if (std::abs(touch.apart.z) < steep * touch.reach) return false;
    const double up = touch.apart.z > 0.0 ? 1.0 : -1.0;
    return is_held(spheres.place[touch.first], up, rules) || is_held(spheres.place[touch.second], -up, rules);
}

/// Two beads: normal and slip do not feel each other.
void resolve_beads(Touch& touch, Spheres& spheres, const TouchRules& rules, TouchReport& report) {
    BeadArrays& beads = spheres.beads;
    Lane &va = beads.velocity[touch.first], &vb = beads.velocity[touch.second];
    Lane &wa = beads.spin[touch.first], &wb = beads.spin[touch.second];
    const Vector apart = vector_of(va) - vector_of(vb);
    if (dot(apart, touch.apart) >= 0.0) return;
    go_back(touch, apart, rules.dt);
    const Vector& n = touch.normal;
    const double ra = spheres.place[touch.first][3], rb = spheres.place[touch.second][3];
    const double approach = dot(apart, n), mass = va[3] + vb[3];
    if (approach >= 0.0) return;
    const Vector u = apart - cross(ra * vector_of(wa) + rb * vector_of(wb), n);
    const Vector slip = u - approach * n;
    const double size = length(slip), normal = -(1.0 + rules.restitution.bead_bead) * approach / mass;
    const double response = mass + ra * ra * wa[3] + rb * rb * wb[3];
    const double tangential = std::min(rules.friction.bead_bead * normal, size / response);
    const Vector along = size > 0.0 ? -tangential / size * slip : Vector{};
    const Vector impulse = normal * n + along, turn = cross(n, along);
    const Vector da = va[3] * impulse, db = -vb[3] * impulse;
    set_vector(va, vector_of(va) + da);
    set_vector(vb, vector_of(vb) + db);
    set_vector(wa, vector_of(wa) - ra * wa[3] * turn);
    set_vector(wb, vector_of(wb) - rb * wb[3] * turn);
    set_vector(spheres.place[touch.first], vector_of(spheres.place[touch.first]) + touch.since * da);
    set_vector(spheres.place[touch.second], vector_of(spheres.place[touch.second]) + touch.since * db);
    report.balance.gravity -=
        touch.since * dot(rules.bead_force, da + db);  // what gravity does for one it takes from the other
    report.balance.impact += 0.5 * normal * (approach + approach + mass * normal);
    report.balance.friction -= tangential * (size - 0.5 * response * tangential);
    if (approach < -counted_speed) ++report.counts.bead_bead;
}

/// Any group: its bodies as movers, its touches as contacts.
class GroupSolver {
public:
    GroupSolver(Spheres& spheres, const TouchRules& rules) : spheres_(spheres), rules_(rules) {}

    void resolve_group(std::span<Touch*> touches, TouchReport& report) {
        movers_.clear();
        bodies_.clear();
        contacts_.clear();
        for (const Touch* touch : touches) {
            add_body(touch->first_body);
            if (touch->second != none) add_body(touch->second_body);
        }
        for (Touch* touch : touches) contacts_.push_back(contact_of(*touch));
        const std::size_t many = touches.size();
        for (const Touch* touch : touches) add_plates(*touch);
        for (std::size_t c = 0; c < many; ++c)
            if (dot(relative_velocity(contacts_[c], movers_), contacts_[c].normal) < -counted_speed)
                count_impact(*touches[c], spheres_, report.counts);
        const ImpactOutcome outcome = resolve(movers_, contacts_, rules_.law);
        if (outcome.approach <= 0.0) return;
        report.balance.impact += outcome.normal;
        report.balance.friction += outcome.friction;
        report.balance.plates += outcome.walls;
        if (contacts_.size() > 1) {
            ++report.counts.groups;
            report.counts.largest_group =
                std::max(report.counts.largest_group, static_cast<std::int64_t>(contacts_.size()));
            report.counts.residual = std::max(report.counts.residual, outcome.residual / outcome.approach);
            if (outcome.residual > rules_.law.tolerance * outcome.approach) ++report.counts.unresolved;
        }
        for (std::size_t b = 0; b < bodies_.size(); ++b) store(bodies_[b], movers_[b]);
        // One time for all: bodies that hold each other move as if their new velocities had been theirs since then, and none into another.
        double since = 0.0;
        for (const Touch* touch : touches) since = std::max(since, touch->since);
        for (std::size_t c = 0; c < many; ++c) {
            const Vector shift = since * contacts_[c].impulse;
            move(touches[c]->first_body, shift, report);
            if (touches[c]->second != none) move(touches[c]->second_body, -1.0 * shift, report);
        }
    }

private:
    int index_of(std::uint32_t body) const {
        return static_cast<int>(std::find(bodies_.begin(), bodies_.end(), body) - bodies_.begin());
    }
    void add_body(std::uint32_t body) {
        if (index_of(body) < static_cast<int>(bodies_.size())) return;
        bodies_.push_back(body);
        const auto beads = static_cast<std::uint32_t>(spheres_.beads.size());
        if (body < beads) {
            movers_.push_back(mover_of_bead(spheres_.beads, body));
        } else {
            const std::uint32_t r = body - beads;
            movers_.push_back(mover_of(spheres_.rods.rod[r], spheres_.shape_of_rod(r)));
        }
    }
    Vector from_centre(std::uint32_t sphere) const {
        if (spheres_.is_bead(sphere)) return {};
        const std::uint32_t r = spheres_.rod(sphere);
        return vector_of(spheres_.place[sphere]) - spheres_.rods.rod[r].position;
    }
    Contact contact_of(Touch& touch) const {
        Contact contact{.first = index_of(touch.first_body), .second = -1};
        const auto& first = movers_[static_cast<std::size_t>(contact.first)];
        Vector velocity = velocity_of(spheres_, touch.first, first);
        if (touch.second != none) {
            contact.second = index_of(touch.second_body);
            velocity =
                velocity - velocity_of(spheres_, touch.second, movers_[static_cast<std::size_t>(contact.second)]);
        }
        go_back(touch, velocity, rules_.dt);
        contact.normal = touch.normal;
        contact.arm_first = from_centre(touch.first) - spheres_.place[touch.first][3] * touch.normal;
        if (touch.second != none)
            contact.arm_second = from_centre(touch.second) + spheres_.place[touch.second][3] * touch.normal;
        const bool bead = spheres_.is_bead(touch.first);
        const Restitution& e = rules_.restitution;
        const Friction& mu = rules_.friction;
        if (touch.second == none) {
            contact.restitution = bead ? e.bead_wall : e.rod_wall;
            contact.friction = bead ? mu.bead_wall : mu.rod_wall;
        } else if (spheres_.is_bead(touch.second) != bead) {
            contact.restitution = e.rod_bead;
            contact.friction = mu.rod_bead;
        } else {
            contact.restitution = bead ? e.bead_bead : e.rod_rod;
            contact.friction = bead ? mu.bead_bead : mu.rod_rod;
        }
        return contact;
    }
    /// The plates that hold what this touch presses onto them.
    void add_plates(const Touch& touch) {
        if (touch.second == none || std::abs(touch.normal.z) < steep) return;
        const double up = touch.normal.z > 0.0 ? 1.0 : -1.0;
        add_plate(touch.first_body, touch.first, up);
        add_plate(touch.second_body, touch.second, -up);
    }
    void add_plate(std::uint32_t body, std::uint32_t sphere, double side) {
        const int index = index_of(body);
        const auto known = [&](const Contact& c) {
            return c.second < 0 && c.first == index && c.wall_velocity.z == rules_.base.speed && c.normal.z == -side;
        };
        if (std::any_of(contacts_.begin(), contacts_.end(), known)) return;
        const bool bead = spheres_.is_bead(sphere);
        Contact contact{.first = index, .second = -1, .normal = {0.0, 0.0, -side}};
        contact.wall_velocity = {0.0, 0.0, rules_.base.speed};
        contact.restitution = bead ? rules_.restitution.bead_plate : rules_.restitution.rod_plate;
        contact.friction = bead ? rules_.friction.bead_plate : rules_.friction.rod_plate;
        const auto add = [&](std::uint32_t s) {
            if (!is_held(spheres_.place[s], side, rules_)) return;
            contact.arm_first = from_centre(s) + side * spheres_.place[s][3] * Vector{0.0, 0.0, 1.0};
            contacts_.push_back(contact);
        };
        if (bead) return add(sphere);
        const RodArrays& rods = spheres_.rods;
        const std::uint32_t r = spheres_.rod(sphere);
        for (const std::uint32_t k : rods.kinds[rods.kind[r]].bearing) add(rods.first[r] + k);
    }
    void store(std::uint32_t body, const Mover& mover) {
        const auto beads = static_cast<std::uint32_t>(spheres_.beads.size());
        if (body < beads) {
            set_vector(spheres_.beads.velocity[body], mover.velocity);
            set_vector(spheres_.beads.spin[body], mover.spin);
        } else {
            Rod& rod = spheres_.rods.rod[body - beads];
            rod.velocity = mover.velocity;
            rod.angular_momentum = angular_momentum(mover);
        }
    }
    void move(std::uint32_t body, const Vector& by_mass, TouchReport& report) {
        const auto beads = static_cast<std::uint32_t>(spheres_.beads.size());
        if (body < beads) {
            Lane& place = spheres_.place[body];
            const double inverse = spheres_.beads.velocity[body][3];
            set_vector(place, vector_of(place) + inverse * by_mass);
            report.balance.gravity -= dot(rules_.acceleration + inverse * rules_.bead_force, by_mass);
        } else {
            const std::uint32_t r = body - beads;
            Rod& rod = spheres_.rods.rod[r];
            rod.position = rod.position + 1.0 / spheres_.shape_of_rod(r).mass * by_mass;
        }
    }

    Spheres& spheres_;
    const TouchRules& rules_;
    std::vector<std::uint32_t> bodies_;
    std::vector<Mover> movers_;
    std::vector<Contact> contacts_;
};
}  // namespace

double smaller_radius(const Touch& touch, const Spheres& spheres) {
    const double first = spheres.place[touch.first][3];
    return touch.second == none ? first : std::min(first, spheres.place[touch.second][3]);
}

void TouchSolver::find(const Walls& walls, const Spheres& spheres, const Neighbours& neighbours, Threads& threads) {
    const std::size_t chunks = neighbours.near.size();
    found_.resize(chunks + 1);
    for (auto& list : found_) list.clear();
    threads.for_chunks(chunks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) find_pairs(spheres, neighbours.near[c], found_[c]);
    });
    find_images(spheres, neighbours.images, found_.back());
    find_walls(walls, spheres, neighbours.near_wall, found_.back());
    touches_.clear();
    for (const auto& list : found_) touches_.insert(touches_.end(), list.begin(), list.end());
}

void TouchSolver::group(std::size_t bodies) {
    const auto count = static_cast<std::uint32_t>(touches_.size());
    last_.resize(bodies, none);
    parent_.resize(count);
    order_.resize(count);
    start_.clear();
    for (std::uint32_t t = 0; t < count; ++t) {
        parent_[t] = t;
        for (const std::uint32_t body : {touches_[t].first_body, touches_[t].second_body}) {
            if (body == none) continue;
            if (last_[body] != none) join(parent_, t, last_[body]);
            last_[body] = t;
        }
    }
    for (const Touch& touch : touches_) {
        last_[touch.first_body] = none;
        if (touch.second_body != none) last_[touch.second_body] = none;
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

TouchReport TouchSolver::step(const Walls& walls, Spheres& spheres, const Neighbours& neighbours,
                              const TouchRules& rules, Threads& threads) {
    find(walls, spheres, neighbours, threads);
    group(spheres.beads.size() + spheres.rods.size());
    constexpr std::size_t groups_per_chunk = 32;
    const std::size_t groups = start_.size() - 1, chunks = groups / groups_per_chunk + 1;
    reports_.assign(chunks, {});
    threads.for_chunks(chunks, 1, [&](std::size_t first, std::size_t last) {
        GroupSolver solver(spheres, rules);
        std::vector<Touch*> members;
        for (std::size_t c = first; c < last; ++c) {
            TouchReport& report = reports_[c];
            for (std::size_t g = c * groups_per_chunk; g < std::min((c + 1) * groups_per_chunk, groups); ++g) {
                members.clear();
                for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) {
                    Touch& touch = touches_[order_[i]];
                    members.push_back(&touch);
                    if (const double depth = overlap_of(touch, spheres); depth > report.depth) {
                        report.depth = depth;
                        report.deepest = touch;
                    }
                }
                Touch& only = *members.front();
                if (members.size() == 1 && only.second != none && spheres.is_bead(only.first) &&
                    spheres.is_bead(only.second) && !is_pressed(only, spheres, rules))
                    resolve_beads(only, spheres, rules, report);
                else solver.resolve_group(members, report);
            }
        }
    });
    TouchReport whole;
    for (const TouchReport& report : reports_) {
        add(report.balance, whole.balance);
        add(report.counts, whole.counts);
        if (report.depth > whole.depth) {
            whole.depth = report.depth;
            whole.deepest = report.deepest;
        }
    }
    return whole;
}

}  // namespace drover::dem
