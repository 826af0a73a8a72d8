// tests/bench/particles/plain_rod.hpp: one rod between vibrating plates, by the pairwise law, without the library:
// plain arrays, a matrix of response, small explicit steps.  It serves as the independent check of contacts.law =
// "pairwise".
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace plain {

using V = std::array<double, 3>;
inline V operator+(V a, const V& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline V operator-(V a, const V& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline V operator*(double s, const V& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const V& a, const V& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double size(const V& a) { return std::sqrt(dot(a, a)); }
inline V cross(const V& a, const V& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The solution of K j = d, by Cramer's rule; `k` holds columns.
inline V solve(const std::array<V, 3>& k, const V& d) {
    const double det = dot(k[0], cross(k[1], k[2]));
    return {dot(d, cross(k[1], k[2])) / det, dot(k[0], cross(d, k[2])) / det, dot(k[0], cross(k[1], d)) / det};
}

/// The printed numbers of the paper: mm, s, mg.
struct Choice {
    double step = 2e-6, kick = 0.015, amplitude = 0.04, frequency = 200.0, gap = 1.2, restitution = 0.1,
           friction = 0.03;
    bool decoupled = false;  ///< the textbook's friction; else it stops the slip or slides along the slip before
    bool hull = false;       ///< only spheres 0, 6 and 12 bear
    std::string order = "tail-first";
};

struct Body {
    double mass = 0.0, along = 0.0, across = 0.0;  ///< inertia about its axis and across it
    std::vector<double> at, radius;                ///< spheres, from the centre of mass
};

/// The union of 13 spheres as a solid of revolution of density 8.7, by a sum over thin discs.
inline Body make_body() {
    Body body;
    for (int i = 0; i < 13; ++i) {
        body.radius.push_back(i < 7 ? 0.55 : i < 10 ? 0.44 : 0.36);
        body.at.push_back(0.55 + i * (4.5 - 0.55 - 0.36) / 12.0);
    }
    constexpr int discs = 450000;
    constexpr double thick = 4.5 / discs;
    double first = 0.0, second = 0.0, fourth = 0.0;
    for (int d = 0; d < discs; ++d) {
        const double z = (d + 0.5) * thick;
        double r2 = 0.0;
        for (int i = 0; i < 13; ++i)
            r2 = std::max(r2, body.radius[i] * body.radius[i] - (z - body.at[i]) * (z - body.at[i]));
        const double m = 8.7 * std::numbers::pi * r2 * thick;
        body.mass += m;
        first += m * z;
        second += m * z * z;
        fourth += m * r2;
    }
    const double centre = first / body.mass;
    body.along = 0.5 * fourth;
    body.across = second - body.mass * centre * centre + 0.25 * fourth;
    for (double& at : body.at) at -= centre;
    return body;
}

/// One frame: place and axis in the plane.
struct Frame {
    double x = 0.0, y = 0.0, nx = 0.0, ny = 0.0;
};

class Rod {
public:
    Rod(const Choice& choice, std::uint64_t seed) : c_(choice), body_(make_body()), random_(seed) {
        const double angle = 2.0 * std::numbers::pi * uniform_(random_);
        const double tilt = (2.0 * uniform_(random_) - 1.0) * 0.9 * 0.1 / 3.59;
        n_ = {std::sqrt(1.0 - tilt * tilt) * std::cos(angle), std::sqrt(1.0 - tilt * tilt) * std::sin(angle), tilt};
        double low = -1e300, high = 1e300;
        for (int i = 0; i < 13; ++i) {
            low = std::max(low, body_.radius[i] - body_.at[i] * tilt);
            high = std::min(high, c_.gap - body_.radius[i] - body_.at[i] * tilt);
        }
        x_ = {0.0, 0.0, 2.0 * c_.amplitude + low + (high - low) * uniform_(random_)};
    }
    Frame frame() const { return {x_[0], x_[1], n_[0], n_[1]}; }

    void advance() {
        const double h = c_.step, rate = 2.0 * std::numbers::pi * c_.frequency;
        v_[2] -= 9810.0 * h;
        x_ = x_ + h * v_;
        turn(h);
        ++step_;
        const double phase = std::fmod(c_.frequency * h * static_cast<double>(step_), 1.0) * 2.0 * std::numbers::pi;
        const double base = c_.amplitude * (1.0 + std::cos(phase)), speed = -c_.amplitude * rate * std::sin(phase);
        std::vector<std::array<int, 2>> hits;  // sphere, side
        for (int i = 0; i < 13; ++i) {
            if (c_.hull && i % 6 != 0) continue;
            const double z = x_[2] + body_.at[i] * n_[2];
            if (z - body_.radius[i] < base) hits.push_back({i, 1});
            if (z + body_.radius[i] > base + c_.gap) hits.push_back({i, -1});
        }
        if (c_.order == "random") std::shuffle(hits.begin(), hits.end(), random_);
        for (std::size_t k = 0; k < hits.size(); ++k) {
            if (c_.order == "fastest-first") {
                std::size_t best = k;
                for (std::size_t j = k + 1; j < hits.size(); ++j)
                    if (opening(hits[j], speed) < opening(hits[best], speed)) best = j;
                std::rotate(hits.begin() + static_cast<long>(k), hits.begin() + static_cast<long>(best),
                            hits.begin() + static_cast<long>(best) + 1);
            }
            hit(hits[k], speed);
        }
    }

private:
    V spin_of(const V& momentum) const {
        return 1.0 / body_.across * momentum + (1.0 / body_.along - 1.0 / body_.across) * dot(momentum, n_) * n_;
    }
    V arm(const std::array<int, 2>& hit) const {
        const auto i = static_cast<std::size_t>(hit[0]);
        return body_.at[i] * n_ + V{0.0, 0.0, -hit[1] * body_.radius[i]};
    }
    double opening(const std::array<int, 2>& hit, double speed) const {
        return hit[1] * (v_[2] + cross(spin_of(l_), arm(hit))[2] - speed);
    }
    void turn(double h) {
        const double l = size(l_), angle = l * h / body_.across;
        if (l == 0.0) return;
        const V pole = 1.0 / l * l_;
        n_ = std::cos(angle) * n_ + std::sin(angle) * cross(pole, n_) + (1.0 - std::cos(angle)) * dot(pole, n_) * pole;
        n_ = 1.0 / size(n_) * n_;
    }
    void hit(const std::array<int, 2>& where, double speed) {
        const V normal{0.0, 0.0, static_cast<double>(where[1])}, r = arm(where);
        const V u = v_ + cross(spin_of(l_), r) - V{0.0, 0.0, speed};
        const double un = dot(u, normal);
        if (un >= 0.0) return;
        std::array<V, 3> k;
        for (std::size_t j = 0; j < 3; ++j) {
            V unit{};
            unit[j] = 1.0;
            k[j] = 1.0 / body_.mass * unit + cross(spin_of(cross(r, unit)), r);
        }
        const auto times = [&](const V& a) { return a[0] * k[0] + a[1] * k[1] + a[2] * k[2]; };
        const V slip = u - un * normal, t = size(slip) > 0.0 ? 1.0 / size(slip) * slip : V{};
        V j = solve(k, -c_.restitution * un * normal - u);
        if (c_.decoupled) {
            const double jn = -(1.0 + c_.restitution) * un / dot(normal, times(normal));
            j = jn * normal;
            if (size(slip) > 0.0) j = j - std::min(c_.friction * jn, size(slip) / dot(t, times(t))) * t;
        } else if (const double jn = dot(j, normal); size(j - jn * normal) > c_.friction * jn) {
            const V direction = normal - c_.friction * t;
            j = -(1.0 + c_.restitution) * un / dot(normal, times(direction)) * direction;
        }
        v_ = v_ + 1.0 / body_.mass * j;
        l_ = l_ + cross(r, j);
        // omega_z += +-eps |u_n| by a change of the angular momentum.
        const V kick{0.0, 0.0, (random_() >> 40 & 1 ? 1.0 : -1.0) * c_.kick * -un};
        const double along = dot(kick, n_);
        l_ = l_ + body_.across * (kick - along * n_) + body_.along * along * n_;
    }

    Choice c_;
    Body body_;
    std::mt19937_64 random_;
    std::uniform_real_distribution<double> uniform_{0.0, 1.0};
    V x_{}, v_{}, n_{}, l_{};
    std::int64_t step_ = 0;
};

/// Frames every `spacing` from time 0 to `seconds`.
inline std::vector<Frame> run(const Choice& choice, std::uint64_t seed, double seconds, double spacing) {
    Rod rod(choice, seed);
    std::vector<Frame> frames{rod.frame()};
    const auto each = std::llround(spacing / choice.step), count = std::llround(seconds / spacing);
    for (long long f = 0; f < count; ++f) {
        for (long long s = 0; s < each; ++s) rod.advance();
        frames.push_back(rod.frame());
    }
    return frames;
}

/// Mean displacement along the axis at the start of each frame, over the frame time, after a warm-up [mm/s].
inline double speed(const std::vector<Frame>& frames, double spacing, double warm_up) {
    double total = 0.0;
    const auto first = static_cast<std::size_t>(std::llround(warm_up / spacing));
    for (std::size_t f = first; f + 1 < frames.size(); ++f) {
        const double nx = frames[f].nx, ny = frames[f].ny;
        total += ((frames[f + 1].x - frames[f].x) * nx + (frames[f + 1].y - frames[f].y) * ny) / std::hypot(nx, ny);
    }
    return total / (spacing * static_cast<double>(frames.size() - 1 - first));
}

}  // namespace plain
