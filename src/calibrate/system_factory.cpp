// calibrate/system_factory.cpp: systems of the particle world.
#include <cmath>
#include <numbers>

#include "base/mapped.hpp"
#include "dem/packing/packing.hpp"
#include "drover/base/threads.hpp"
#include "drover/calibrate/assay.hpp"
#include "drover/dem/world.hpp"

namespace drover::calibrate {

namespace {
class WorldSystem : public ParticleSystem {
public:
    WorldSystem(const dem::Setup& setup, double dt, std::uint64_t seed)
        : world_(setup, dem::pack(setup, seed), dt, seed, threads_), bodies_(world_.bodies()) {}

    void impose(const dem::BodyForces& forces) override { world_.set_forces(forces); }

    void advance_to(double time) override {
        const double steps = std::round(time / world_.dt());
        require(steps >= static_cast<double>(step_) && steps < 0x1p53, {},
                "advance_to({}) at t = {} s; expected a finite time that is not earlier", time,
                static_cast<double>(step_) * world_.dt());
        const auto end = static_cast<std::int64_t>(steps);
        while (step_ < end) world_.advance(step_++);
        bodies_ = world_.bodies();
    }

    std::vector<RodPose> rods() const override {
        return mapped(bodies_.rods, [](const dem::Rod& rod) {
            return RodPose{rod.position.x, rod.position.y, std::atan2(rod.axis.y, rod.axis.x)};
        });
    }

    BeadMotion beads() const override {
        return {.x = mean([](const dem::Bead& bead) { return bead.position.x; }),
                .y = mean([](const dem::Bead& bead) { return bead.position.y; }),
                .vx = mean([](const dem::Bead& bead) { return bead.velocity.x; }),
                .vy = mean([](const dem::Bead& bead) { return bead.velocity.y; })};
    }

    std::vector<Position> bead_positions() const override {
        return mapped(bodies_.beads, [](const dem::Bead& bead) { return Position{bead.position.x, bead.position.y}; });
    }

    double shear_wave(int waves) const override {
        check_waves(waves);
        const double q = 2.0 * std::numbers::pi * waves / world_.setup().cell.ly;
        const auto wave = [q](const dem::Bead& bead) { return std::sin(q * bead.position.y); };
        // Least-squares fit to the velocities, as in the force that holds the wave.
        return mean([&](const dem::Bead& bead) { return bead.velocity.x * wave(bead); }) /
               mean([&](const dem::Bead& bead) { return wave(bead) * wave(bead); });
    }

    double density_wave(int waves) const override {
        check_waves(waves);
        const double q = 2.0 * std::numbers::pi * waves / world_.setup().cell.lx;
        return 2.0 * mean([q](const dem::Bead& bead) { return std::cos(q * bead.position.x); });
    }

private:
    void check_waves(int waves) const {
        require(waves >= 1 && !bodies_.beads.empty(), {}, "{} waves of {} beads; expected 1 or more of each", waves,
                bodies_.beads.size());
    }
    template <class Function>
    double mean(Function function) const {
        double total = 0.0;
        for (const dem::Bead& bead : bodies_.beads) total += function(bead);
        return bodies_.beads.empty() ? 0.0 : total / static_cast<double>(bodies_.beads.size());
    }

    Threads threads_{1};
    dem::World world_;
    dem::Bodies bodies_;
    std::int64_t step_ = 0;
};
}  // namespace

SystemFactory system_factory(double dt) {
    return [dt](const dem::Setup& setup, std::uint64_t seed) { return std::make_unique<WorldSystem>(setup, dt, seed); };
}

}  // namespace drover::calibrate
