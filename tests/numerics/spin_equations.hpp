// tests/numerics/spin_equations.hpp: random isotropic equations of fields of spins, in components, without angles.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <random>

#include "drover/numerics/system.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::numerics {

/// F_1 + j F_2 at one wavevector.  F_1 and F_2 are Fourier coefficients: j is not the i of exp(i q.r).
struct SpinField {
    Complex first, second;
};
inline SpinField operator*(Complex c, const SpinField& f) {  // c = real + j imaginary
    return {c.real() * f.first - c.imag() * f.second, c.real() * f.second + c.imag() * f.first};
}
/// d F = (d_x + j d_y) F, d* F = (d_x - j d_y) F.
inline SpinField raised(const Wavevector& q, const SpinField& f) {
    const Complex i(0.0, 1.0);
    return {i * (q.x * f.first - q.y * f.second), i * (q.x * f.second + q.y * f.first)};
}
inline SpinField lowered(const Wavevector& q, const SpinField& f) {
    const Complex i(0.0, 1.0);
    return {i * (q.x * f.first + q.y * f.second), i * (q.x * f.second - q.y * f.first)};
}

/// dF/dt = -damping F + sum of c lap^n d^k G, c lap^n d*^k G and c lap^n d^k conj(G) over all pairs of fields, with k
/// such that the spins agree.  A reflection takes F_1 + j F_2 to its conjugate, times -1 where the field is odd: c is
/// real between fields of one parity, imaginary between others, and both for a chiral layout.  Derivatives are in units
/// of `scale`.
class SpinEquations {
public:
    SpinEquations(Layout the_layout, double damping, double strength, double scale, unsigned seed)
        : layout(std::move(the_layout)), damping_(damping), scale_(scale) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal(0.0, strength);
        for (const FieldKind& to : layout.fields)
            for (const FieldKind& from : layout.fields)
                for (Coupling& c : std::array<Coupling, 4>{{{}, {.laplacians = 1}, {.conjugates = true}, {true, 1}}}) {
                    const double a = normal(random), b = normal(random);
                    c.factor = {layout.chiral || to.odd == from.odd ? a : 0.0,
                                layout.chiral || to.odd != from.odd ? b : 0.0};
                    couplings_.push_back(c);
                }
    }

    Eigen::MatrixXcd matrix(const Wavevector& q) const {
        const int count = components(layout);
        Eigen::MatrixXcd m(count, count);
        for (int k = 0; k < count; ++k) m.col(k) = rates(q, Eigen::VectorXcd::Unit(count, k));
        return m;
    }

    /// The matrix at q along x, in parts.  Adds what should be zero in it to `wrong`.
    IsotropicBlocks blocks(double q, double* wrong = nullptr) const {
        const BlockParts parts = block_parts(layout);
        const Eigen::MatrixXcd m = matrix({q, 0.0});
        const auto entry = [&](const Part& row, const Part& column) {
            const Complex factor = q > 0.0 ? std::pow(Complex(0.0, 1.0), row.spin - column.spin) : 1.0;
            return factor * m(row.component, column.component);
        };
        if (wrong)
            for (const Part& even : parts.even)
                for (const Part& odd : parts.odd) *wrong += std::abs(entry(even, odd)) + std::abs(entry(odd, even));
        return blocks_of(parts, [&](const Part& row, const Part& column) {
            if (wrong) *wrong += std::abs(entry(row, column).imag());
            return entry(row, column).real();
        });
    }

    Layout layout;

private:
    struct Coupling {
        bool conjugates = false;
        int laplacians = 0;
        Complex factor = {};
    };

    Eigen::VectorXcd rates(Wavevector q, const Eigen::VectorXcd& values) const {
        q = {q.x / scale_, q.y / scale_};
        Eigen::VectorXcd result = -damping_ * values;
        auto coupling = couplings_.begin();
        Eigen::Index row = 0;
        for (const FieldKind& to : layout.fields) {
            Eigen::Index column = 0;
            for (const FieldKind& from : layout.fields) {
                const SpinField source{values(column), from.spin > 0 ? values(column + 1) : 0.0};
                for (int k = 0; k < 4; ++k, ++coupling) {
                    SpinField f = source;
                    int raise = to.spin - from.spin;
                    if (coupling->conjugates) f.second = -f.second, raise = to.spin + from.spin;
                    for (; raise > 0; --raise) f = raised(q, f);
                    for (; raise < 0; ++raise) f = lowered(q, f);
                    for (int n = 0; n < coupling->laplacians; ++n) f = raised(q, lowered(q, f));
                    f = coupling->factor * f;
                    result(row) += f.first;
                    if (to.spin > 0) result(row + 1) += f.second;
                }
                column += components(from);
            }
            row += components(to);
        }
        return result;
    }

    double damping_, scale_;
    std::vector<Coupling> couplings_;
};

/// exp(m): a series of 24 terms on a norm below 1/4, then squarings.
inline Eigen::MatrixXcd exp_by_series(Eigen::MatrixXcd m) {
    int squarings = 0;
    for (; m.norm() > 0.25; m /= 2.0) ++squarings;
    const Eigen::MatrixXcd one = Eigen::MatrixXcd::Identity(m.rows(), m.cols());
    Eigen::MatrixXcd result = one;
    for (int n = 24; n >= 1; --n) result = one + m * result / n;
    for (; squarings > 0; --squarings) result = result * result;
    return result;
}

}  // namespace drover::numerics
