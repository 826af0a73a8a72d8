// tests/calibrate/synthetic.hpp: a synthetic particle system with known coefficients and noise.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "drover/base/random.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// The equations of motion:
///     rods   d theta = n x (lambda_s v + mobility h + D_r g_c P).z dt + noise,  dr = u n dt + noise;
///     beads  dv = -(g + c/|v|) v dt + g (s + s3 |P|^2) P dt + noise for the mean velocity v,
///            and for each bead  dr = v dt + noise;
///     shear and density waves: exponential decay towards the driven amplitude, with noise.
struct Truth {
    double turning = 0.3;         ///< lambda_s [1/mm]
    double diffusion = 0.4;       ///< D_r [1/s]
    double memory = 0.0;          ///< correlation time of the angular velocity [s]; 0: white
    double jitter = 0.05;         ///< standard deviation of the observed angle [rad]
    double speed = 3.6;           ///< u [mm/s]
    double mobility = 2e-3;       ///< [1/(mg mm^2 s)]
    double contact = 0.0;         ///< g_c: rods turn to the mean orientation of all, as contacts make them
    double damping = 20.0;        ///< g = Gamma/(m rho) [1/s]
    double coulomb = 0.0;         ///< c [mm/s^2]
    double drag = 2.0;            ///< s = alpha/Gamma [mm/s]
    double drag_cubic = 0.0;      ///< s3 [mm/s]
    double agitation = 0.5;       ///< standard deviation of the mean velocity at rest [mm/s]
    double viscosity = 6.0;       ///< eta/(m rho) [mm^2/s]
    double wave_noise = 0.7;      ///< standard deviation of the amplitude of a shear wave [mm/s]
    double stiffness = 500.0;     ///< E [mg mm^2/s^2]
    double density_rate = 4.0;    ///< of the decay of density waves [1/s]
    double density_noise = 0.02;  ///< standard deviation of their amplitude
    double rods_follow = 0.0;     ///< part by which the density of rods follows that of beads
    double bead_diffusion = 0.0;  ///< D of each bead [mm^2/s]
    double bead_rattle = 0.0;     ///< standard deviation of each observed bead coordinate [mm]
    double rod_diffusion = 0.0;   ///< D of each rod [mm^2/s]
    double step = 0.01;           ///< longest time step [s]
};

class SyntheticSystem : public ParticleSystem {
public:
    SyntheticSystem(const Truth& truth, const dem::Setup& setup, std::uint64_t seed)
        : truth_(truth), setup_(setup), key_{.seed = seed, .stream = Stream::test} {
        for (int r = 0; r < setup.rods.count; ++r) {
            const double angle =
                setup.packing.kind == dem::PackingKind::aligned ? 0.0 : 2.0 * std::numbers::pi * uniform();
            rods_.push_back({.angle = angle});
            if (truth.rods_follow != 0.0) rods_.back().x = setup.cell.lx * uniform();
        }
        spin_.resize(rods_.size());
        for (double& spin : spin_)
            if (truth.memory > 0.0) spin = std::sqrt(truth.diffusion / truth.memory) * normal();
        if (truth.bead_diffusion > 0.0) diffused_.resize(static_cast<std::size_t>(setup.beads.count));
        impose(setup.forces);
    }

    void impose(const dem::BodyForces& forces) override {
        forces_ = forces;
        hold();
    }
    void advance_to(double time) override {
        const double left = time - time_;
        const auto steps = static_cast<int>(std::ceil(left / truth_.step - 1e-9));
        for (int i = 0; i < steps; ++i) step(left / steps);
        time_ = time;
        seen_ = rods_;
        for (RodPose& rod : seen_) rod.angle += truth_.jitter * normal();
        if (truth_.rods_follow != 0.0)
            for (const auto& [number, amplitude] : density_) {
                // To first order a displacement -(d/q) sin(qx) makes the density wave d cos(qx).
                const double q = 2.0 * std::numbers::pi * number / setup_.cell.lx;
                for (RodPose& rod : seen_) rod.x -= truth_.rods_follow * amplitude / q * std::sin(q * rod.x);
            }
        if (truth_.bead_rattle == 0.0) return;
        seen_rattle_.resize(diffused_.size());
        for (Position& one : seen_rattle_)
            one = {.x = truth_.bead_rattle * normal(), .y = truth_.bead_rattle * normal()};
    }
    std::vector<RodPose> rods() const override { return seen_.empty() ? rods_ : seen_; }
    BeadMotion beads() const override { return beads_; }
    std::vector<Position> bead_positions() const override {
        std::vector<Position> positions = diffused_;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            positions[i].x += beads_.x + (seen_rattle_.empty() ? 0.0 : seen_rattle_[i].x);
            positions[i].y += beads_.y + (seen_rattle_.empty() ? 0.0 : seen_rattle_[i].y);
        }
        return positions;
    }
    double shear_wave(int waves) const override { return find(shear_, waves); }
    double density_wave(int waves) const override { return find(density_, waves); }

private:
    static double find(const std::map<int, double>& waves, int number) {
        const auto found = waves.find(number);
        return found == waves.end() ? 0.0 : found->second;
    }
    double uniform() {
        double drawn = 0.0;
        fill_uniform(key_, next_++, 1, {&drawn, 1});
        return drawn;
    }
    double normal() {
        if (left_ == 0) {
            RandomKey key = key_;
            key.substep = 1;
            fill_normal(key, next_, 1, pool_);
            next_ += pool_.size();
            left_ = pool_.size();
        }
        return pool_[--left_];
    }
    void hold() {
        if (!forces_.hold_beads) return;
        if (forces_.held_waves > 0) {
            shear_[forces_.held_waves] = forces_.bead_velocity_x;
            return;
        }
        beads_.vx = forces_.bead_velocity_x;
        beads_.vy = forces_.bead_velocity_y;
    }
    /// Exact step of x' = -rate (x - rest) + noise with this stationary standard deviation.
    double relaxed(double x, double rest, double rate, double deviation, double dt) {
        const double kept = std::exp(-rate * dt);
        return rest + kept * (x - rest) + deviation * std::sqrt(1.0 - kept * kept) * normal();
    }
    void step(double dt) {
        const std::array<double, 2> before = order();
        turn_rods(dt);
        move_beads(before, dt);
        const double wave = 2.0 * std::numbers::pi / setup_.cell.ly;
        for (auto& [number, amplitude] : shear_)
            amplitude = relaxed(amplitude, 0.0, truth_.damping + truth_.viscosity * std::pow(wave * number, 2),
                                truth_.wave_noise, dt);
        if (forces_.push != 0.0) density_.insert({forces_.push_waves, 0.0});
        for (auto& [number, amplitude] : density_) {
            const double push = number == forces_.push_waves ? forces_.push : 0.0;
            amplitude = relaxed(amplitude, -push / (truth_.stiffness * wave * number), truth_.density_rate,
                                truth_.density_noise, dt);
        }
        diffuse(dt);
        hold();
    }
    void diffuse(double dt) {
        const double bead = std::sqrt(2.0 * truth_.bead_diffusion * dt),
                     rod = std::sqrt(2.0 * truth_.rod_diffusion * dt);
        for (Position& one : diffused_) one.x += bead * normal(), one.y += bead * normal();
        if (rod > 0.0)
            for (RodPose& one : rods_) one.x += rod * normal(), one.y += rod * normal();
    }
    /// Exact in a constant field: tan of half the angle to it decays exponentially.  Half of the noise acts before the
    /// turn and half after.
    void turn_rods(double dt) {
        const std::array<double, 2> mean = order();
        const double pull = truth_.mobility * forces_.torque, contact = truth_.diffusion * truth_.contact;
        const double x = truth_.turning * beads_.vx + pull * std::cos(forces_.angle) + contact * mean[0];
        const double y = truth_.turning * beads_.vy + pull * std::sin(forces_.angle) + contact * mean[1];
        const double field = std::atan2(y, x), shrink = std::exp(-std::hypot(x, y) * dt);
        for (std::size_t r = 0; r < rods_.size(); ++r) {
            RodPose& rod = rods_[r];
            const double before = rod.angle;
            const double kick = noise_of_turning(spin_[r], dt);
            const double apart = std::remainder(rod.angle + 0.5 * kick - field, 2.0 * std::numbers::pi);
            rod.angle += kick + 2.0 * std::atan(std::tan(0.5 * apart) * shrink) - apart;
            rod.x += truth_.speed * dt * 0.5 * (std::cos(before) + std::cos(rod.angle));
            rod.y += truth_.speed * dt * 0.5 * (std::sin(before) + std::sin(rod.angle));
        }
    }
    /// Rotation by noise; with memory, the exact integral of an Ornstein-Uhlenbeck angular velocity.
    double noise_of_turning(double& spin, double dt) {
        const double white = std::sqrt(2.0 * truth_.diffusion), first = normal();
        if (truth_.memory == 0.0) return white * std::sqrt(dt) * first;
        const double kept = std::exp(-dt / truth_.memory), before = spin;
        const double spread = std::sqrt((1.0 - kept * kept) / (2.0 * truth_.memory));
        const double shared = (1.0 - kept) / spread;  // covariance of the noise in the new spin and over the step
        spin = kept * before + white * spread * first;
        return truth_.memory * (before - spin) +
               white * (shared * first + std::sqrt(std::max(dt - shared * shared, 0.0)) * normal());
    }
    /// Mean of n over rods.
    std::array<double, 2> order() const {
        std::array<double, 2> sum{};
        for (const RodPose& rod : rods_) {
            sum[0] += std::cos(rod.angle) / static_cast<double>(rods_.size());
            sum[1] += std::sin(rod.angle) / static_cast<double>(rods_.size());
        }
        return sum;
    }
    void move_beads(const std::array<double, 2>& before_turn, double dt) {
        const std::array<double, 2> after_turn = order();
        const double px = 0.5 * (before_turn[0] + after_turn[0]), py = 0.5 * (before_turn[1] + after_turn[1]);
        const double carried = truth_.drag + truth_.drag_cubic * (px * px + py * py);
        const double rate = truth_.damping, speed = std::hypot(beads_.vx, beads_.vy);
        const double slower = speed > 0.0 ? truth_.coulomb / (rate * speed) : 0.0;
        const double rest_x = carried * px - slower * beads_.vx, rest_y = carried * py - slower * beads_.vy;
        const BeadMotion before = beads_;
        beads_.vx = relaxed(before.vx, rest_x, rate, truth_.agitation, dt);
        beads_.vy = relaxed(before.vy, rest_y, rate, truth_.agitation, dt);
        // The integral of an exponential, from its ends.
        const double half = std::tanh(0.5 * rate * dt) / rate;
        beads_.x += rest_x * dt + half * (before.vx + beads_.vx - 2.0 * rest_x);
        beads_.y += rest_y * dt + half * (before.vy + beads_.vy - 2.0 * rest_y);
    }

    Truth truth_;
    dem::Setup setup_;
    RandomKey key_;
    std::uint64_t next_ = 0;
    std::vector<double> pool_ = std::vector<double>(256);
    std::size_t left_ = 0;
    double time_ = 0.0;
    dem::BodyForces forces_;
    std::vector<RodPose> rods_, seen_;
    std::vector<Position> diffused_, seen_rattle_;  // of each bead, relative to the mean displacement
    std::vector<double> spin_;
    BeadMotion beads_;
    std::map<int, double> shear_, density_;
};

inline SystemFactory synthetic_factory(const Truth& truth) {
    return [truth](const dem::Setup& setup, std::uint64_t seed) {
        return std::make_unique<SyntheticSystem>(truth, setup, seed);
    };
}

/// A periodic square of 30 mm with these numbers of rods and beads.
inline Conditions synthetic_conditions(int rods, std::uint64_t seed = 1, int beads = 900) {
    Conditions conditions{.setup = {}, .seed = seed};
    conditions.setup.cell.lx = conditions.setup.cell.ly = 30.0;
    conditions.setup.beads.count = beads;
    conditions.setup.rods.count = rods;
    return conditions;
}

}  // namespace drover::calibrate
