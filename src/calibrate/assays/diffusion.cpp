// calibrate/assays/diffusion.cpp: self-diffusion of beads and of single rods from mean-square displacements.
#include <cmath>
#include <numbers>

#include "calibrate/assays/mean_squares.hpp"
#include "calibrate/catalogue.hpp"

namespace drover::calibrate {

namespace {
std::vector<double> bead_displacements(const DiffusionPlan& plan, const SystemFactory& make, const dem::Setup& given,
                                       std::uint64_t seed) {
    const auto system = make(beads_alone(given), seed);
    const Lags lags = lags_of(plan);
    const std::size_t frames = frames_in(plan.time, plan.frame);
    std::vector<Path> x, y;
    for (std::size_t frame = 0; frame <= frames; ++frame) {
        system->advance_to(plan.warm_up + static_cast<double>(frame) * plan.frame);
        const std::vector<Position> beads = system->bead_positions();
        require(beads.size() >= 2, {}, "diffusion: {} beads; expected two or more, since drift of the bed is removed",
                beads.size());
        Position mean;
        for (const Position& bead : beads) {
            mean.x += bead.x / static_cast<double>(beads.size());
            mean.y += bead.y / static_cast<double>(beads.size());
        }
        x.resize(beads.size()), y.resize(beads.size());
        for (std::size_t b = 0; b < beads.size(); ++b) {
            x[b].push_back(beads[b].x - mean.x);
            y[b].push_back(beads[b].y - mean.y);
        }
    }
    std::vector<double> squares(lags.count(), 0.0);
    for (std::size_t b = 0; b < x.size(); ++b) {
        const std::vector<double> along_x = squared_displacements(x[b], lags),
                                  along_y = squared_displacements(y[b], lags);
        for (std::size_t i = 0; i < squares.size(); ++i)
            squares[i] += (along_x[i] + along_y[i]) / static_cast<double>(x.size() - 1);
    }
    return squares;
}

/// The paths of one rod along and across its axis.
struct BodyPath {
    Path along{0.0}, across{0.0};
    void add(const RodPose& before, const RodPose& now) {
        const double angle = before.angle + 0.5 * std::remainder(now.angle - before.angle, 2.0 * std::numbers::pi);
        const double dx = now.x - before.x, dy = now.y - before.y;
        along.push_back(along.back() + dx * std::cos(angle) + dy * std::sin(angle));
        across.push_back(across.back() - dx * std::sin(angle) + dy * std::cos(angle));
    }
};

std::vector<double> rod_displacements(const DiffusionPlan& plan, const SystemFactory& make, const dem::Setup& given,
                                      std::uint64_t seed) {
    const std::vector<std::vector<RodPose>> rods = rod_frames(plan, make, with_rods(given, false), seed);
    const Lags lags = lags_of(plan);
    const std::size_t frames = rods.size() - 1;
    std::vector<BodyPath> paths(rods.front().size());
    for (std::size_t frame = 1; frame <= frames; ++frame)
        for (std::size_t r = 0; r < paths.size(); ++r) paths[r].add(rods[frame - 1][r], rods[frame][r]);
    std::vector<double> squares(lags.count(), 0.0);
    for (BodyPath& path : paths) {
        const double step = path.along.back() / static_cast<double>(frames);  // u of this rod times the frame
        for (std::size_t i = 0; i < path.along.size(); ++i) path.along[i] -= step * static_cast<double>(i);
        const std::vector<double> along = squared_displacements(path.along, lags),
                                  across = squared_displacements(path.across, lags);
        for (std::size_t i = 0; i < squares.size(); ++i) {
            const double left = 1.0 - static_cast<double>(lags.first + i) / static_cast<double>(frames);
            squares[i] += (along[i] / left + across[i]) / static_cast<double>(paths.size());
        }
    }
    return squares;
}

/// The mean-square displacements of beads, then those of rods, at all lags of the fit.
Trial follow(const DiffusionPlan& plan, const SystemFactory& make, const dem::Setup& given, std::uint64_t seed) {
    require_beads(given, "diffusion");
    Trial trial = bead_displacements(plan, make, given, seed);
    const std::vector<double> rods = rod_displacements(plan, make, given, trial_seed(seed, "rods", 0));
    trial.insert(trial.end(), rods.begin(), rods.end());
    return trial;
}

std::vector<double> estimates_of(const DiffusionPlan& plan, std::span<const double> means) {
    const std::size_t count = means.size() / 2;
    std::vector<double> values;
    for (const std::span<const double> squares : {means.first(count), means.last(count)}) {
        const Line line = line_of(plan, squares, 0, count);
        values.insert(values.end(), {0.25 * line.slope, line.at_zero, change_of_slope(plan, squares)});
    }
    return {values[0], values[3], values[1], values[4], values[2], values[5]};
}

std::string conclude(std::vector<measure::Estimate>& estimates) {
    std::string diagnosis;
    for (const auto& [name, q] : {std::pair{"beads", 4u}, std::pair{"rods", 5u}}) {
        diagnosis += diagnosis.empty() ? "" : "; ";
        diagnosis += text("{}: {}", name, diffusive_words(estimates[q], "motion", "displacement", "D"));
    }
    return diagnosis;
}
}  // namespace

Assay diffusion(const DiffusionPlan& plan) {
    require_lags(plan, "diffusion");
    return {.name = "diffusion",
            .population = Population::single_rods,
            .quantities = {{"bead_diffusion", "mm^2/s", "D of beads: <|r(t) - r(0)|^2> = c + 4 D t, without rods"},
                           {"rod_diffusion", "mm^2/s", "D of single rods, without propulsion"},
                           {"bead_diffusion_offset", "mm^2", "c of beads", false},
                           {"rod_diffusion_offset", "mm^2", "c of rods", false},
                           {"bead_diffusion_change", "1", "(D of longer lags - D of shorter lags)/D, beads", false},
                           {"rod_diffusion_change", "1", "(D of longer lags - D of shorter lags)/D, rods", false}},
            .trial = std::bind_front(follow, plan),
            .estimator = always(std::bind_front(estimates_of, plan)),
            .conclude = conclude};
}

Rows<DiffusionPlan> DiffusionPlan::rows() {
    using Plan = DiffusionPlan;
    return Rows<DiffusionPlan>{
        {"warm_up", &Plan::warm_up, "before positions are recorded", "s", not_negative},
        {"frame", &Plan::frame, "between recorded positions; a multiple of the plate period", "s", positive},
        {"time", &Plan::time, "recorded in each trial", "s", positive},
        {"min_lag", &Plan::min_lag, "shortest lag of the fit; longer than ballistic motion and rattling in a cage", "s",
         positive},
        {"max_lag", &Plan::max_lag, "longest lag of the fit; less than time", "s", positive},
    };
}

}  // namespace drover::calibrate
