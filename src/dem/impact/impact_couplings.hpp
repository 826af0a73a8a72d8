// dem/impact/impact_couplings.hpp: how impulses at one contact of a group change the velocities at the others.
#pragma once
#include <array>
#include <cstddef>
#include <memory_resource>
#include <span>

#include "dem/bodies/vec4d.hpp"
#include "dem/impact/impact_frame.hpp"

namespace drover::dem {

using ContactVectors = std::pmr::vector<Vec4d>;  ///< of each contact: components along its normal and its tangents

/// One of the bodies of a contact.
struct Side {
    int body = -1;
    double sign = 0.0;
    const Lever* lever = nullptr;
};
inline std::array<Side, 2> sides_of(const Contact& contact, const Frame& frame) {
    return {Side{contact.first, 1.0, &frame.first}, Side{contact.second, -1.0, &frame.second}};
}

/// Changes of the velocities at contact `at` by unit impulses of another contact along its normal and tangents.
struct Coupling {
    std::size_t at = 0;
    std::array<Vec4d, 3> change{};
};

/// For each contact, the couplings to all contacts that share a body with it, itself included.
class Couplings {
public:
    Couplings(std::span<const ImpactBody> bodies, std::span<const Contact> contacts, std::span<const Frame> frames,
              std::pmr::memory_resource* memory)
        : start_(memory), all_(memory) {
        start_.reserve(contacts.size() + 1);
        all_.reserve(3 * contacts.size());
        for (std::size_t by = 0; by < contacts.size(); ++by) {
            start_.push_back(all_.size());
            for (std::size_t at = 0; at < contacts.size(); ++at) add(bodies, contacts, frames, by, at);
        }
        start_.push_back(all_.size());
    }
    /// Changes the velocities at all contacts by an impulse at one.
    void push(std::size_t by, double n, double x, double y, ContactVectors& slips) const {
        for (std::size_t k = start_[by]; k < start_[by + 1]; ++k) {
            const Coupling& to = all_[k];
            slips[to.at] += n * to.change[0] + x * to.change[1] + y * to.change[2];
        }
    }

private:
    void add(std::span<const ImpactBody> bodies, std::span<const Contact> contacts, std::span<const Frame> frames,
             std::size_t by, std::size_t at) {
        Coupling coupling{.at = at};
        bool shared = false;
        for (const Side& here : sides_of(contacts[at], frames[at]))
            for (const Side& there : sides_of(contacts[by], frames[by])) {
                if (here.body < 0 || here.body != there.body) continue;
                shared = true;
                const double sign = here.sign * there.sign,
                             inverse = bodies[static_cast<std::size_t>(here.body)].mass_inverse;
                for (std::size_t j = 0; j < 3; ++j)
                    for (std::size_t i = 0; i < 3; ++i)
                        coupling.change[j][i] += sign * (inverse * dot(frames[at].axes[i], frames[by].axes[j]) +
                                                         dot(here.lever->turn[i], there.lever->spin[j]));
            }
        if (shared) all_.push_back(coupling);
    }

    std::pmr::vector<std::size_t> start_;
    std::pmr::vector<Coupling> all_;
};

}  // namespace drover::dem
