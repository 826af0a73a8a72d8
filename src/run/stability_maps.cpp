// run/stability_maps.cpp: maps of one uniform state for an archive.
#include "run/stability_maps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "drover/physics/fluctuations.hpp"
#include "drover/physics/stability_rows.hpp"

namespace drover::run {

namespace {
using std::numbers::pi;

/// One state, and the points at which it is mapped.
struct Mapped {
    const physics::Equations& equations;
    const physics::StationaryState& state;
    const model::LongWaves& waves;
    std::vector<double> angles, wavenumbers;  // [rad], [1/mm]
    Threads& threads;
};

std::vector<double> logarithmic(double first, double last, int count) {
    std::vector<double> result;
    for (int k = 0; k < count; ++k) result.push_back(first * std::pow(last / first, k / (count - 1.0)));
    return result;
}

std::vector<double> indices(Eigen::Index count) {
    std::vector<double> result;
    for (Eigen::Index i = 0; i < count; ++i) result.push_back(static_cast<double>(i));
    return result;
}

/// Rates at q and -q are complex conjugates: half a turn has all of them, a quarter where the state is
/// mirror-symmetric.
std::vector<double> map_angles(const physics::UniformPoint& point, int per_quarter) {
    const int quarters = physics::is_mirrored(point) ? 1 : 2, steps = (per_quarter - 1) * quarters;
    std::vector<double> angles;
    for (int a = 0; a <= steps; ++a) angles.push_back(0.5 * pi * quarters * a / steps);
    return angles;
}

void add_branches(const Mapped& mapped, files::ResultTable& table) {
    const physics::ModeMap map =
        physics::mode_map(mapped.equations, mapped.state, mapped.wavenumbers, mapped.angles, mapped.threads);
    const Eigen::Index branches = map.modes.front().rates.size();
    table.axes.push_back({"branch", "1", "branch of modes, continued from the smallest q along p0", indices(branches)});
    const auto fill = [&](const std::string& name, const std::string& unit, const std::string& meaning, auto value) {
        std::vector<double> values;
        for (const physics::Modes& modes : map.modes)
            for (Eigen::Index b = 0; b < branches; ++b) values.push_back(value(modes, b));
        add_map(name, unit, meaning, {"angle", "wavenumber", "branch"}, std::move(values), table);
    };
    using physics::Modes;
    fill("growth_rate", "s-1", "growth rate of the mode, Re s",
         [](const Modes& m, Eigen::Index b) { return m.rates(b).real(); });
    fill("frequency", "s-1", "angular frequency of the mode, -Im s; positive: the wave moves along q",
         [](const Modes& m, Eigen::Index b) { return -m.rates(b).imag(); });
    Eigen::Index row = 0;
    for (const physics::Component& component : physics::components_in_symbol_order(mapped.equations.form)) {
        fill("amplitude_" + component.name, "1",
             "amplitude of " + component.name + " in the mode, whose shape has length 1 in mm, s, mg",
             [row](const Modes& m, Eigen::Index b) { return std::abs(m.shapes(row, b)); });
        fill("phase_" + component.name, "rad", "phase of " + component.name + " in the mode",
             [row](const Modes& m, Eigen::Index b) { return std::arg(m.shapes(row, b)); });
        ++row;
    }
}

void add_slow_modes(const Mapped& mapped, files::ResultTable& table) {
    const Eigen::Index count = mapped.waves.right.cols();
    table.axes.push_back(
        {"slow_mode", "1", "slow modes at each angle, by speed", indices(std::max<Eigen::Index>(1, count))});
    if (count == 0 || !mapped.waves.why_none.empty()) return;
    std::vector<double> speed, growth, damping;
    for (const double angle : mapped.angles)
        for (const model::SlowMode& mode :
             model::slow_modes(mapped.waves, physics::direction_of(mapped.state.point) + angle)) {
            speed.push_back(mode.speed.real());
            growth.push_back(mode.speed.imag());
            damping.push_back(mode.damping.real());
        }
    const std::vector<std::string> axes{"angle", "slow_mode"};
    add_map("slow_speed", "mm s-1", "speed Re u of the slow mode, s = -i u q - gamma q^2 as q -> 0", axes, speed,
            table);
    add_map("slow_growth", "mm s-1", "Im u; positive: the slow mode grows in proportion to q", axes, growth, table);
    add_map("slow_damping", "mm2 s-1", "Re gamma of the slow mode; NaN where u is a defective eigenvalue", axes,
            damping, table);
}

bool is_decaying(const Mapped& mapped, const numerics::Wavevector& q) {
    return physics::mode_rates(mapped.equations, mapped.state.point, q).real().maxCoeff() < 0.0;
}

void add_structure_factors(const Mapped& mapped, files::ResultTable& table) {
    const physics::UniformPoint& point = mapped.state.point;
    const std::size_t width = mapped.wavenumbers.size(), size = mapped.angles.size() * width;
    std::vector<physics::Symbol> matrices(size, physics::Symbol::Constant(nan));
    mapped.threads.for_chunks(size, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const numerics::Wavevector q =
                physics::wavevector_from_order(point, mapped.wavenumbers[n % width], mapped.angles[n / width]);
            if (is_decaying(mapped, q)) matrices[n] = physics::structure_matrix(mapped.equations, point, q);
        }
    });
    for (const physics::StructurePart& part :
         physics::structure_parts(mapped.equations.form, physics::direction_of(point))) {
        std::vector<double> values;
        for (const physics::Symbol& matrix : matrices) values.push_back(part.value(matrix));
        add_map("structure_factor_" + part.name, part.unit,
                "equal-time structure factor of the linear theory; NaN where a mode grows", {"angle", "wavenumber"},
                std::move(values), table);
    }
}

void add_dynamic_structure(const Mapped& mapped, double q, const std::vector<double>& frequencies,
                           files::ResultTable& table) {
    const physics::UniformPoint& point = mapped.state.point;
    const std::size_t width = frequencies.size(), size = mapped.angles.size() * width;
    const std::vector<physics::StructurePart> parts =
        physics::structure_parts(mapped.equations.form, physics::direction_of(point));
    std::vector<std::vector<double>> values(parts.size(), std::vector<double>(size, nan));
    mapped.threads.for_chunks(mapped.angles.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a) {
            const numerics::Wavevector at = physics::wavevector_from_order(point, q, mapped.angles[a]);
            if (!is_decaying(mapped, at)) continue;
            for (std::size_t k = 0; k < width; ++k) {
                const physics::Symbol s =
                    physics::dynamic_structure_matrix(mapped.equations, point, at, frequencies[k]);
                for (std::size_t p = 0; p < parts.size(); ++p) values[p][a * width + k] = parts[p].value(s);
            }
        }
    });
    add_map("sound_wavenumber", "mm-1", "wavenumber |q| of the dynamic structure factors", {}, {q}, table);
    for (std::size_t p = 0; p < parts.size(); ++p)
        add_map("dynamic_structure_factor_" + parts[p].name, parts[p].unit + " s",
                text("S(q, omega) at |q| = {:.6g} /mm; its integral over omega/(2 pi) is S(q)", q),
                {"angle", "frequency_axis"}, values[p], table);
}
}  // namespace

void add_map(const std::string& name, const std::string& unit, const std::string& meaning,
             std::vector<std::string> axes, std::vector<double> values, files::ResultTable& table) {
    table.quantities.push_back({name, unit, meaning, std::move(axes)});
    table.values.push_back(std::move(values));
}

double smallest_wavenumber(const numerics::Grid& grid) { return 2.0 * pi / std::max(grid.lx, grid.ly); }

files::ResultTable stability_maps(const io::Scene& scene, const physics::Equations& equations,
                                  const physics::StationaryState& state, const model::LongWaves& waves,
                                  const model::GrowthSearch& search, Threads& threads) {
    const io::StabilityPlan& plan = scene.stability;
    const Mapped mapped{.equations = equations,
                        .state = state,
                        .waves = waves,
                        .angles = map_angles(state.point, plan.angles),
                        .wavenumbers = logarithmic(search.min, search.max, plan.wavenumbers),
                        .threads = threads};
    std::vector<double> degrees;
    for (const double angle : mapped.angles) degrees.push_back(angle / radians_per_degree);
    const double sound = plan.sound > 0.0 ? plan.sound : smallest_wavenumber(scene.grid);
    const std::vector<double> frequencies =
        physics::structure_frequencies(equations, state.point, sound, mapped.angles, plan.frequencies);
    files::ResultTable table{
        .group = {},
        .axes = {{"angle", "degree",
                  "angle of the wavevector from p0 (without order: from the bead velocity; at rest: from x)", degrees},
                 {"wavenumber", "mm-1", "wavenumber |q|", mapped.wavenumbers},
                 {"frequency_axis", "s-1", "angular frequency omega", frequencies}},
        .quantities = {},
        .values = {}};
    add_branches(mapped, table);
    add_slow_modes(mapped, table);
    if (physics::has_noise(scene.model.noise)) {
        add_structure_factors(mapped, table);
        add_dynamic_structure(mapped, sound, frequencies, table);
    }
    return table;
}

}  // namespace drover::run
