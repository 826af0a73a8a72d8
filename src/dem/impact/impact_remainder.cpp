// dem/impact/impact_remainder.cpp: a frictionless inelastic impact of a group, by an active set.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <memory_resource>

#include "dem/impact/impact_couplings.hpp"
#include "dem/impact/impact_group.hpp"

namespace drover::dem {

namespace {
/// Change of the velocity along each normal by a unit impulse along each.
Eigen::MatrixXd normal_responses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                 std::span<const Frame> frames) {
    std::pmr::memory_resource* const memory = std::pmr::get_default_resource();
    const Couplings couplings(bodies, contacts, frames, memory);
    const auto count = static_cast<Eigen::Index>(contacts.size());
    Eigen::MatrixXd responses(count, count);
    for (Eigen::Index by = 0; by < count; ++by) {
        ContactVectors changes(contacts.size(), Vec4d{}, memory);
        couplings.push(static_cast<std::size_t>(by), 1.0, 0.0, 0.0, changes);
        for (Eigen::Index at = 0; at < count; ++at) responses(at, by) = changes[static_cast<std::size_t>(at)][0];
    }
    return responses;
}

/// The p >= 0 with the least p.u + p.A p/2, for a positive definite A: Lawson & Hanson, Solving Least Squares Problems
/// (1974), ch. 23.
Eigen::VectorXd least_energy(const Eigen::MatrixXd& a, const Eigen::VectorXd& u) {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(u.size());
    std::vector<Eigen::Index> active;
    const double rounding = 1e-15 * u.lpNorm<Eigen::Infinity>();
    const double enough = std::max(1e-10 * -u.minCoeff(), rounding);
    for (Eigen::Index round = 0; round < 10 * u.size(); ++round) {
        const Eigen::VectorXd after = u + a * p;
        Eigen::Index next = -1;
        for (Eigen::Index c = 0; c < u.size(); ++c)
            if (std::ranges::find(active, c) == active.end() && after[c] < -enough &&
                (next < 0 || after[c] < after[next]))
                next = c;
        if (next < 0) break;
        active.push_back(next);
        while (!active.empty()) {
            const Eigen::VectorXd wanted = a(active, active).ldlt().solve(-u(active));
            double fraction = 1.0;  // of the way to `wanted` until a contact would pull
            for (std::size_t k = 0; k < active.size(); ++k)
                if (const double now = p[active[k]], then = wanted[static_cast<Eigen::Index>(k)]; then <= 0.0)
                    fraction = std::min(fraction, now / (now - then));
            for (std::size_t k = 0; k < active.size(); ++k)
                p[active[k]] += fraction * (wanted[static_cast<Eigen::Index>(k)] - p[active[k]]);
            if (fraction == 1.0) break;
            std::erase_if(active, [&](Eigen::Index c) {
                const bool pulls = p[c] <= 1e-14 * p.lpNorm<Eigen::Infinity>();
                if (pulls) p[c] = 0.0;
                return pulls;
            });
        }
    }
    return p;
}
}  // namespace

std::vector<double> inelastic_impulses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                       std::span<const Frame> frames, std::span<const double> velocities) {
    Eigen::MatrixXd a = normal_responses(bodies, contacts, frames);
    const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
    a = (scale.asDiagonal() * a * scale.asDiagonal()).eval();
    // Makes the impulses unique: contacts in one place share theirs, and those that do nothing are zero.
    constexpr double regularisation = 1e-13, max_ratio = 1e9;
    a.diagonal().array() += regularisation;
    const Eigen::VectorXd u = scale.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(velocities.data(), scale.size()));
    const Eigen::VectorXd p = least_energy(a, u);
    if (!(p.maxCoeff() <= max_ratio * u.lpNorm<Eigen::Infinity>())) return {};
    const Eigen::VectorXd impulses = scale.cwiseProduct(p);
    return {impulses.begin(), impulses.end()};
}

}  // namespace drover::dem
