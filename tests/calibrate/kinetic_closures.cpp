// tests/calibrate/kinetic_closures.cpp: saturation and self-advection against the whole hierarchy of moments.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>

#include "calibrate/alignment.hpp"
#include "calibrate/collision_rule.hpp"
#include "calibrate/table.hpp"
#include "numerics/algebra/dense.hpp"

namespace drover::calibrate::kinetic_closures_tests {
namespace {

constexpr int depth = 12;  // moments of the hierarchy
constexpr double a = 0.2, u = 3.0, sigma = 0.02;

/// Rods that turn with the flow; those that meet keep half the angle between them.
class Hierarchy {
public:
    Hierarchy(double g, double diameter) : g_(g) {
        for (int k = 1; k <= depth; ++k)
            for (int q = k - depth; q <= depth; ++q)
                kernel_[{k, q}] = calibrate::kernel({.kept = 0.5, .reach = diameter, .speed = u}, k, q);
    }
    double kernel(int k, int q) const { return kernel_.at({k, q}); }

    /// Moments of the uniform flock, from Newton steps that start at this order.
    Eigen::VectorXd flock(double order) const {
        Eigen::VectorXd psi(depth);
        for (int k = 1; k <= depth; ++k) psi(k - 1) = std::pow(order, k);
        for (int step = 0; step < 50; ++step) psi -= derivative(psi).lu().solve(rates(psi));
        return psi;
    }
    Eigen::VectorXd rates(const Eigen::VectorXd& psi) const {
        Eigen::VectorXd rate(depth);
        for (int k = 1; k <= depth; ++k) {
            rate(k - 1) = -a * k * k * at(psi, k) + 0.5 * k * a * g_ * at(psi, 1) * (at(psi, k - 1) - at(psi, k + 1));
            for (int q = k - depth; q <= depth; ++q) rate(k - 1) += sigma * kernel(k, q) * at(psi, q) * at(psi, k - q);
        }
        return rate;
    }
    /// The speed of a wave of the direction along the flock, over that of the rods: first-order perturbation of the
    /// rotation psi_k -> psi_k exp(i k angle), which costs nothing.
    double speed_of_waves(const Eigen::VectorXd& psi) const {
        Eigen::MatrixXd turning = Eigen::MatrixXd::Zero(depth, depth), transport = turning;
        const auto add = [](Eigen::MatrixXd& m, int k, int q, double value) {  // of eta_q, odd in q
            if (q != 0 && std::abs(q) <= depth) m(k - 1, std::abs(q) - 1) += q > 0 ? value : -value;
        };
        for (int k = 1; k <= depth; ++k) {
            add(turning, k, k, -a * k * k);
            const double pull = 0.5 * k * a * g_;
            add(turning, k, 1, pull * (at(psi, k - 1) + at(psi, k + 1)));
            add(turning, k, k - 1, pull * at(psi, 1));
            add(turning, k, k + 1, -pull * at(psi, 1));
            for (int q = k - depth; q <= depth; ++q) {
                add(turning, k, q, sigma * kernel(k, q) * at(psi, k - q));
                add(turning, k, k - q, sigma * kernel(k, q) * at(psi, q));
            }
            add(transport, k, k + 1, 0.5);
            add(transport, k, k - 1, 0.5);
        }
        Eigen::VectorXd right(depth);
        for (int k = 1; k <= depth; ++k) right(k - 1) = k * at(psi, k);
        EXPECT_LT((turning * right).norm(), 1e-10 * right.norm());
        const numerics::DenseEigen solved = numerics::dense_eigen(turning.transpose().cast<std::complex<double>>());
        Eigen::Index slow = 0;
        solved.values.cwiseAbs().minCoeff(&slow);
        const Eigen::VectorXcd mode = solved.vectors.col(slow);
        Eigen::Index largest = 0;
        mode.cwiseAbs().maxCoeff(&largest);
        const Eigen::VectorXd left = (mode / mode(largest)).real();
        return left.dot(transport * right) / left.dot(right);
    }

private:
    static double at(const Eigen::VectorXd& psi, int k) {
        return k == 0 ? 1.0 : std::abs(k) > depth ? 0.0 : psi(std::abs(k) - 1);
    }
    Eigen::MatrixXd derivative(const Eigen::VectorXd& psi) const {
        constexpr double step = 1e-6;
        Eigen::MatrixXd m(depth, depth);
        for (int k = 0; k < depth; ++k) {
            Eigen::VectorXd more = psi, less = psi;
            more(k) += step, less(k) -= step;
            m.col(k) = (rates(more) - rates(less)) / (2.0 * step);
        }
        return m;
    }
    double g_;
    std::map<std::pair<int, int>, double> kernel_;
};

/// What a table derives from the assays of this world.
std::map<std::string, double> derived(const Hierarchy& world, double g) {
    Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {5.0 * sigma}, .rows = {}};
    const auto add = [&](const std::string& name, double value) {
        table.rows.push_back({.name = name, .entries = {{.value = value, .origin = Origin::measured}}});
    };
    add("relaxation_rate", a);
    add("weathercock", 0.5 * g * a / 2.0);
    add("propulsion", u);
    add("drag", 2.0);
    add("rod_area", 5.0);
    add("contact_scattering", world.kernel(1, 0) + world.kernel(1, 1));
    add("scattering_second", world.kernel(2, 0) + world.kernel(2, 2));
    add("scattering_excitation", world.kernel(2, 1));
    add("scattering_saturation", -world.kernel(1, 2) - world.kernel(1, -1));
    add_derived(table);
    std::map<std::string, double> values;
    for (const TableRow& row : table.rows) values[row.name] = row.entries.front().value;
    return values;
}

/// Without contacts g = 2 is the onset; with them less flow is enough.
class KineticClosures : public testing::TestWithParam<double> {};

TEST_P(KineticClosures, are_those_of_all_moments_at_onset) {
    const double diameter = GetParam();
    const Hierarchy without_flow(0.0, diameter);
    const double c = without_flow.kernel(1, 0) + without_flow.kernel(1, 1);
    const double onset = 2.0 - 2.0 * c * sigma / a;
    double before = 0.0;
    for (const double above : {0.04, 0.02, 0.01}) {
        const double g = onset + above;
        const Hierarchy world(g, diameter);
        const auto table = derived(world, g);
        EXPECT_NEAR(table.at("alignment_kinetic"), 2.0 + above, 1e-9);
        const double rate = 0.5 * a * above;  // of growth of a small order
        const Eigen::VectorXd psi = world.flock(std::sqrt(rate / table.at("saturation_kinetic")));
        ASSERT_LT(world.rates(psi).norm(), 1e-12);
        const double order = psi(0), b = rate / (order * order), w = u * world.speed_of_waves(psi) / order;
        EXPECT_GT(order, 0.05);
        // The moments that the closures leave out change b and w by a part of the order of the distance from onset.
        const double of_b = table.at("saturation_kinetic") / b - 1.0, of_w = table.at("advection_kinetic") / w - 1.0;
        EXPECT_LT(std::abs(of_b), 2.0 * above);
        EXPECT_LT(std::abs(of_w), 2.0 * above);
        if (before != 0.0) {
            EXPECT_NEAR(of_b / before, 0.5, 0.05);
        }
        before = of_b;
        EXPECT_NEAR(table.at("elasticity_kinetic"),
                    0.25 * u * u / (4.0 * a - sigma * (world.kernel(2, 0) + world.kernel(2, 2))), 1e-12);
        if (diameter == 0.0) {
            // Those that scenes use, of p = sigma u P.
            EXPECT_NEAR(table.at("advection") * sigma * u, table.at("advection_kinetic") * (2.0 + above) / g, 1e-12);
        }
    }
}
TEST(KineticClosuresMissing, where_collisions_excite_the_second_moment_without_bound) {
    Table table{.varied_key = {}, .bead_fractions = {0.4}, .rod_fractions = {5.0 * sigma}, .rows = {}};
    for (const auto& [name, value] : std::map<std::string, double>{
             {"relaxation_rate", a}, {"propulsion", u}, {"rod_area", 5.0}, {"scattering_second", 41.0}})
        table.rows.push_back({.name = name, .entries = {{.value = value, .origin = Origin::measured}}});
    add_derived(table);  // 4 a = 0.8 < 41 sigma
    const TableEntry& entry = find_row(table, "elasticity_kinetic")->entries.front();
    EXPECT_EQ(entry.origin, Origin::missing);
    EXPECT_EQ(entry.remark, "the closure has no finite value with these numbers");
}

INSTANTIATE_TEST_SUITE_P(All, KineticClosures, testing::Values(0.0, 1.5));

}  // namespace
}  // namespace drover::calibrate::kinetic_closures_tests
