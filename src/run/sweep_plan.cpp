// run/sweep_plan.cpp: from the text of sweep.vary to runs.
#include <algorithm>
#include <cmath>

#include "drover/run/sweep.hpp"
#include "run/number_lists.hpp"

namespace drover::run {

namespace {
struct Varied {
    std::string key;
    std::vector<double> values;
};

constexpr const char* sweep_key = "sweep.vary";
constexpr const char* sweep_example = "\"relaxation.rate = 0.5, 1, 2\" or \"relaxation.rate = 0.5:2:11\"";

Varied varied_of(const std::string& written, const SourceLocation& where) {
    const auto [key, values] = read_assignment(written, sweep_key, sweep_example, where);
    require(key.find('.') != std::string::npos, where, "{} has \"{}\"; expected \"section.key = values\", as in {}",
            sweep_key, written, sweep_example);
    const auto number_of = [&](const std::string& word) {
        return read_number(word, written, sweep_key, sweep_example, where);
    };
    Varied varied{.key = key, .values = {}};
    if (values.find(':') == std::string::npos) {
        for (const std::string& word : split(values, ',')) varied.values.push_back(number_of(word));
    } else {
        const std::vector<std::string> parts = split(values, ':');
        require(parts.size() == 3, where, "sweep.vary has \"{}\"; expected first:last:count", written);
        const double first = number_of(parts[0]), last = number_of(parts[1]);
        const double count = number_of(parts[2]);
        require(count >= 2.0 && count <= 1e6 && count == std::floor(count), where,
                "sweep.vary has \"{}\"; expected an integer number of values, 2 to 1e6, after the second colon",
                written);
        for (int i = 0; i < static_cast<int>(count); ++i)
            varied.values.push_back(first + (last - first) * i / (count - 1.0));
    }
    require(!varied.values.empty(), where, "sweep.vary has \"{}\" without a value; expected at least one", written);
    return varied;
}

std::vector<SweepPoint> grid_points(const std::vector<Varied>& varied) {
    std::vector<SweepPoint> points{SweepPoint{}};
    for (const Varied& one : varied) {
        std::vector<SweepPoint> longer;
        for (const SweepPoint& point : points)
            for (const double value : one.values) {
                longer.push_back(point);
                longer.back().values.push_back(value);
            }
        points = std::move(longer);
    }
    return points;
}

std::vector<SweepPoint> ramp_points(const Varied& varied, bool down_again) {
    std::vector<SweepPoint> points;
    for (const double value : varied.values) points.push_back({.values = {value}, .branch = "up"});
    if (down_again)
        for (std::size_t i = varied.values.size() - 1; i-- > 0;)
            points.push_back({.values = {varied.values[i]}, .branch = "down"});
    return points;
}

/// Each point of a ramp has its own noise: repeated noise would correlate the two branches.
SweepRun run_at(const SweepLayout& layout, std::size_t point, const io::Scene& scene, int seed) {
    const std::int64_t step = scene.sweep.ramp == "none" ? 0 : static_cast<std::int64_t>(point) * scene.sweep.seeds;
    SweepRun run{.name = text("point-{:04}-seed-{}", point, scene.run.seed + seed), .point = point, .overrides = {}};
    for (std::size_t k = 0; k < layout.keys.size(); ++k)
        run.overrides.push_back(text("{}={}", layout.keys[k], layout.points[point].values[k]));
    run.overrides.push_back(text("run.seed={}", scene.run.seed + seed + step));
    return run;
}
}  // namespace

SweepLayout plan_sweep(const io::Scene& scene) {
    const SourceLocation where = io::location_of(scene, "sweep.vary");
    std::vector<Varied> varied;
    SweepLayout layout;
    for (const std::string& written : scene.sweep.vary) {
        varied.push_back(varied_of(written, where));
        require(std::find(layout.keys.begin(), layout.keys.end(), varied.back().key) == layout.keys.end(), where,
                "sweep.vary names {} twice; expected each key once", varied.back().key);
        for (const char* own : {"run.", "output.", "sweep.", "initial.file", "packing.file"})
            require(!varied.back().key.starts_with(own), where, "sweep.vary names {}, which the sweep sets itself; {}",
                    varied.back().key,
                    varied.back().key == "run.seed" ? "give sweep.seeds"
                                                    : "choose a key of the model, the grid or the time");
        layout.keys.push_back(varied.back().key);
    }
    require(!varied.empty() || scene.sweep.seeds > 1, where,
            "nothing to sweep: give sweep.vary, as in --vary \"relaxation.rate = 0.5:2:4\", or sweep.seeds > 1");
    const bool ramp = scene.sweep.ramp != "none";
    require(!ramp || varied.size() == 1, where, "sweep.ramp = \"{}\" with {} varied keys; expected exactly one",
            scene.sweep.ramp, varied.size());
    for (const char* own : {"grid.", "cell.", "beads.", "rods."})
        require(!ramp || !varied.front().key.starts_with(own), where,
                "sweep.ramp = \"{}\" of {}; a ramp passes on the state {}: choose another key, or ramp = \"none\"",
                scene.sweep.ramp, varied.front().key,
                io::has_grid(scene.kind) ? "on one grid" : "of the same bodies in one cell");
    require(!ramp || io::has_grid(scene.kind) || scene.particles.rods.size_tolerance == 0.0,
            io::location_of(scene, "rods.size_tolerance"),
            "rods.size_tolerance = {} on a ramp, whose points have different seeds and so rods of different sizes; "
            "expected 0, or ramp = \"none\"",
            scene.particles.rods.size_tolerance);
    constexpr double max_runs = 1e6;
    double runs = scene.sweep.seeds;
    for (const Varied& one : varied) runs *= static_cast<double>(one.values.size());
    require(runs <= max_runs, where, "a sweep of {:.3g} runs; expected at most {:.0e}: choose fewer values or seeds",
            runs, max_runs);
    layout.points = ramp ? ramp_points(varied.front(), scene.sweep.ramp == "up-down") : grid_points(varied);
    for (int seed = 0; seed < scene.sweep.seeds; ++seed)
        for (std::size_t point = 0; point < layout.points.size(); ++point) {
            layout.runs.push_back(run_at(layout, point, scene, seed));
            if (ramp && point > 0) layout.runs.back().before = layout.runs.size() - 2;
        }
    return layout;
}

}  // namespace drover::run
