// analysis/stability_maps.cpp: maps of one uniform state for an archive.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/stability.hpp"
#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "theory/instabilities.hpp"

namespace drover::analysis {

namespace {
using std::numbers::pi;

/// One state, and the points at which it is mapped.
struct Mapped {
    const AnalysedState& state;
    std::vector<double> angles, wavenumbers;  // [rad], [1/mm]
    Threads& threads;
};

std::vector<double> logarithmic(double first, double last, int count) {
    return mapped(std::views::iota(0, count), [&](int k) { return first * std::pow(last / first, k / (count - 1.0)); });
}

std::vector<double> indices(Eigen::Index count) {
    return mapped(std::views::iota(Eigen::Index{0}, count), [](Eigen::Index i) { return static_cast<double>(i); });
}

/// Rates at q and -q are complex conjugates: half a turn has all of them, a quarter where the state is
/// mirror-symmetric.
std::vector<double> map_angles(const AnalysedState& state, int per_quarter) {
    if (state.is_mapped_along_x) return {0.0};
    const int quarters = state.linear.is_mirrored() ? 1 : 2, steps = (per_quarter - 1) * quarters;
    return mapped(std::views::iota(0, steps + 1), [&](int a) { return 0.5 * pi * quarters * a / steps; });
}

void add_map(const std::string& name, const std::string& unit, const std::string& meaning,
             std::vector<std::string> axes, std::vector<double> values, files::ResultTable& table) {
    table.quantities.push_back({name, unit, meaning, std::move(axes)});
    table.values.push_back(std::move(values));
}

/// The names of all components, and which of them have a rate.
std::vector<std::pair<std::string, bool>> components_of(const model::LinearisedAt& at) {
    std::vector<std::pair<std::string, bool>> result;
    const std::vector<int>& state = at.state_components();
    for (const model::Field& field : at.equations().model().fields)
        for (const std::string& name : model::dataset_names(field)) {
            const int place = static_cast<int>(result.size());
            result.emplace_back(name, std::ranges::count(state, place) > 0);
        }
    return result;
}

void add_branches(const Mapped& mapped, const std::string& direction, files::ResultTable& table) {
    const model::LinearisedAt& at = mapped.state.linear;
    const theory::ModeMap map = theory::mode_map(at, mapped.wavenumbers, mapped.angles, mapped.threads);
    const Eigen::Index branches = map.modes.front().rates.size();
    table.axes.push_back(
        {"branch", "1", "branch of modes, continued from the smallest q along " + direction, indices(branches)});
    const std::size_t width = mapped.wavenumbers.size(), size = map.modes.size();
    std::vector<model::Symbol> shapes(size);
    for (std::size_t n = 0; n < size; ++n)
        shapes[n] =
            at.all_components(at.wavevector(map.wavenumbers[n % width], map.angles[n / width])) * map.modes[n].shapes;
    const auto fill = [&](const std::string& name, const std::string& unit, const std::string& meaning, auto value) {
        std::vector<double> values;
        for (std::size_t n = 0; n < size; ++n)
            for (Eigen::Index b = 0; b < branches; ++b) values.push_back(value(n, b));
        add_map(name, unit, meaning, {"angle", "wavenumber", "branch"}, std::move(values), table);
    };
    fill("growth_rate", "s-1", "growth rate of the mode, Re s",
         [&](std::size_t n, Eigen::Index b) { return map.modes[n].rates(b).real(); });
    fill("frequency", "s-1", "angular frequency of the mode, -Im s; positive: the wave moves along q",
         [&](std::size_t n, Eigen::Index b) { return -map.modes[n].rates(b).imag(); });
    Eigen::Index row = -1;
    for (const auto& [name, has_rate] : components_of(at)) {
        ++row;
        if (!has_rate) continue;
        fill("amplitude_" + name, "1",
             "amplitude of " + name + " in the mode, whose shape has length 1 in the units of the fields",
             [&](std::size_t n, Eigen::Index b) { return std::abs(shapes[n](row, b)); });
        fill("phase_" + name, "rad", "phase of " + name + " in the mode",
             [&](std::size_t n, Eigen::Index b) { return std::arg(shapes[n](row, b)); });
    }
}

void add_slow_modes(const Mapped& mapped, files::ResultTable& table) {
    std::vector<double> speed, growth, damping, dispersion;
    std::size_t count = 0;
    for (const double angle : mapped.angles) {
        const theory::SlowModes slow = theory::slow_modes(mapped.state.linear, angle);
        if (slow.modes.empty() || (count > 0 && slow.modes.size() != count)) {
            count = 0;
            break;
        }
        count = slow.modes.size();
        for (const theory::SlowMode& mode : slow.modes) {
            speed.push_back(mode.speed.real());
            growth.push_back(mode.speed.imag());
            damping.push_back(mode.damping.real());
            dispersion.push_back(mode.damping.imag());
        }
    }
    table.axes.push_back({"slow_mode", "1", "slow modes at each angle, by speed",
                          indices(static_cast<Eigen::Index>(std::max<std::size_t>(1, count)))});
    if (count == 0) return;
    const std::vector<std::string> axes{"angle", "slow_mode"};
    add_map("slow_speed", "mm s-1", "speed Re u of the slow mode, s = -i u q - gamma q^2 as q -> 0", axes, speed,
            table);
    add_map("slow_growth", "mm s-1", "Im u; positive: the slow mode grows in proportion to q", axes, growth, table);
    add_map("slow_damping", "mm2 s-1", "Re gamma of the slow mode; NaN where u is a defective eigenvalue", axes,
            damping, table);
    add_map("slow_dispersion", "mm2 s-1", "Im gamma: of the frequency u q + Im gamma q^2", axes, dispersion, table);
}

void add_structure_factors(const Mapped& mapped, files::ResultTable& table) {
    const model::LinearisedAt& at = mapped.state.linear;
    const std::vector<StructurePart>& parts = mapped.state.parts;
    const std::size_t width = mapped.wavenumbers.size(), size = mapped.angles.size() * width;
    std::vector<std::vector<double>> values(parts.size(), std::vector<double>(size, nan));
    mapped.threads.for_chunks(size, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const numerics::Wavevector q = at.wavevector(mapped.wavenumbers[n % width], mapped.angles[n / width]);
            const theory::Covariance found = theory::covariance(at, q);
            if (!found.why_none.empty()) continue;
            for (std::size_t p = 0; p < parts.size(); ++p) values[p][n] = parts[p].value(found.matrix, q);
        }
    });
    for (std::size_t p = 0; p < parts.size(); ++p)
        add_map(
            "structure_factor_" + parts[p].name, parts[p].unit,
            "equal-time structure factor of the linear theory; NaN without a stationary state: where a mode grows, or "
            "noise drives one that does not decay",
            {"angle", "wavenumber"}, std::move(values[p]), table);
}

void add_dynamic_structure(const Mapped& mapped, double q, const std::vector<double>& frequencies,
                           files::ResultTable& table) {
    const model::LinearisedAt& at = mapped.state.linear;
    const std::vector<StructurePart>& parts = mapped.state.parts;
    const std::size_t width = frequencies.size(), size = mapped.angles.size() * width;
    std::vector<std::vector<double>> values(parts.size(), std::vector<double>(size, nan));
    std::vector<std::string> why_none(mapped.angles.size());
    mapped.threads.for_chunks(mapped.angles.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a) {
            const numerics::Wavevector wave = at.wavevector(q, mapped.angles[a]);
            const theory::Correlations found = theory::dynamic_structures(at, wave, frequencies);
            why_none[a] = found.why_none;
            for (std::size_t k = 0; k < found.matrices.size(); ++k)
                for (std::size_t p = 0; p < parts.size(); ++p)
                    values[p][a * width + k] = parts[p].value(found.matrices[k], wave);
        }
    });
    const auto first_why = std::ranges::find_if(why_none, [](const auto& why) { return !why.empty(); });
    const std::string why = first_why == why_none.end() ? "" : "; NaN: " + *first_why;
    add_map("sound_wavenumber", "mm-1", "wavenumber |q| of the dynamic structure factors", {}, {q}, table);
    for (std::size_t p = 0; p < parts.size(); ++p)
        add_map("dynamic_structure_factor_" + parts[p].name, parts[p].unit + " s",
                "S(q, omega) at |q| = sound_wavenumber; its integral over omega/(2 pi) is S(q)" + why,
                {"angle", "frequency_axis"}, std::move(values[p]), table);
}

/// `count` angular frequencies [1/s], symmetric about 0, up to twice that of the fastest wave of wavenumber q; if no
/// wave propagates, up to twice the slowest rate that is not 0.
std::vector<double> structure_frequencies(const Mapped& mapped, double q, int count) {
    const model::LinearisedAt& at = mapped.state.linear;
    double fastest = 0.0, slowest = 0.0;
    for (const double angle : mapped.angles) {
        const theory::Modes modes = theory::modes(at, at.wavevector(q, angle));
        for (Eigen::Index k = 0; k < modes.rates.size(); ++k) {
            const std::complex<double> s = modes.rates(k);
            if (std::abs(s) <= modes.roundings(k)) continue;
            if (std::abs(s.imag()) > 1e-9 * std::abs(s))  // smaller ones are rounding errors
                fastest = std::max(fastest, std::abs(s.imag()));
            if (angle == 0.0) slowest = slowest == 0.0 ? std::abs(s) : std::min(slowest, std::abs(s));
        }
    }
    const double largest = fastest > 0.0 ? fastest : slowest;
    return drover::mapped(std::views::iota(0, count),
                          [&](int k) { return 2.0 * largest * (2.0 * k / (count - 1.0) - 1.0); });
}

/// Of any wave.
bool has_noise(const model::LinearisedAt& at) {
    if (at.equations().placed_noise() != nullptr) return false;
    return at.noise({1.0, 0.0}).cwiseAbs().maxCoeff() > 0.0 || at.noise({0.6, 0.8}).cwiseAbs().maxCoeff() > 0.0;
}
}  // namespace

files::ResultTable stability_maps(const io::StabilityPlan& plan, const numerics::Grid& grid, const AnalysedState& state,
                                  const std::string& direction, const theory::GrowthSearch& search, Threads& threads) {
    // A curve needs more points than a map.
    const int wavenumbers = (state.is_mapped_along_x ? 4 : 1) * plan.wavenumbers;
    const Mapped mapped{.state = state,
                        .angles = map_angles(state, plan.angles),
                        .wavenumbers = logarithmic(search.min, search.max, wavenumbers),
                        .threads = threads};
    const std::vector<double> degrees =
        drover::mapped(mapped.angles, [](double angle) { return angle / radians_per_degree; });
    const double sound = plan.sound > 0.0 ? plan.sound : smallest_wavenumber(grid);
    const std::vector<double> frequencies = structure_frequencies(mapped, sound, plan.frequencies);
    files::ResultTable table{
        .axes = {{"angle", "degree",
                  text("angle of the wavevector from {} (of a state without one: from x)", direction), degrees},
                 {"wavenumber", "mm-1", "wavenumber |q|", mapped.wavenumbers},
                 {"frequency_axis", "s-1", "angular frequency omega", frequencies}}};
    add_branches(mapped, direction, table);
    add_slow_modes(mapped, table);
    if (has_noise(state.linear)) {
        add_structure_factors(mapped, table);
        add_dynamic_structure(mapped, sound, frequencies, table);
    }
    return table;
}

}  // namespace drover::analysis
