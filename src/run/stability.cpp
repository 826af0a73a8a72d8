// run/stability.cpp: the stability of a scene's uniform states, as a report and as maps.
#include "drover/run/stability.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace drover::run {

namespace {
using std::numbers::pi;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double degree = pi / 180.0;

double longest_wave(const numerics::Grid& grid) { return 2.0 * pi / std::max(grid.lx, grid.ly); }

physics::Search search_of(const io::Scene& scene) {
    const io::StabilityPlan& plan = scene.stability;
    physics::Search search{.min = plan.min_wavenumber, .max = plan.max_wavenumber, .wavenumbers = plan.wavenumbers};
    if (search.min == 0.0) search.min = 1e-3 * longest_wave(scene.grid);
    if (search.max == 0.0) search.max = pi * std::max(scene.grid.nx / scene.grid.lx, scene.grid.ny / scene.grid.ly);
    require(search.min < search.max,
            io::location_of(scene, plan.min_wavenumber > 0.0 ? "stability.min_wavenumber" : "stability.max_wavenumber"),
            "waves from |q| = {:.4g} to {:.4g} /mm; expected stability.min_wavenumber below stability.max_wavenumber",
            search.min, search.max);
    return search;
}

bool is_noisy(const physics::Noise& noise) { return noise.order != 0.0 || noise.rods != 0.0 || noise.beads != 0.0; }

std::vector<std::string> notes_of(const physics::Equations& e) {
    std::vector<std::string> notes;
    const physics::Noise& noise = e.model.noise;
    if (is_noisy(noise) && e.form.rod_density >= 0 && noise.rods == 0.0)
        notes.push_back(
            "without noise.rods sigma has no shot noise: DN^2/N goes to 0 in small boxes, where particles go to 1");
    for (const auto& [key, coefficient] : named(e))
        if (coefficient->table() && e.model.table.outside == "hold")
            notes.push_back(
                text("{} is held at the edge of its table beyond {}", key, coefficient->table()->range_text()));
    return notes;
}
}  // namespace

StabilityReport make_stability(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    const double beads = scene.model.uniform.bead_density, rods = scene.model.uniform.rod_density;
    StabilityReport report{.scene = scene,
                           .form = physics::form_name(equations.form),
                           .coefficients = physics::effective_coefficients(equations, beads, rods),
                           .states = {},
                           .no_order = {},
                           .search = search_of(scene),
                           .notes = notes_of(equations)};
    const physics::StationaryStates found = physics::stationary_states(equations);
    report.no_order = found.no_order;
    for (const physics::StationaryState& state : found.states) {
        StateStability one{.state = state,
                           .instabilities = physics::instabilities(equations, state, report.search),
                           .waves = physics::long_waves(equations, state),
                           .slow = {},
                           .direction_diffusion = physics::direction_diffusion(equations, state)};
        const double direction = physics::direction_of(state.point);
        if (one.waves.undefined.empty())
            for (const double angle : {0.0, 30.0, 60.0, 90.0})
                one.slow.push_back({angle * degree, physics::slow_modes(one.waves, direction + angle * degree)});
        report.states.push_back(std::move(one));
    }
    const physics::Stiffness& pressure = scene.model.stiffness;
    if (report.coefficients.pressure_beads < 0.0 && equations.form.bead_density >= 0)
        report.notes.push_back(text(
            "Abar = A + lambda E/Gamma = {:.4g} < 0 (E = {:.4g}): rods turn towards crowded beads, which breaks most "
            "flocks at some oblique angle",
            report.coefficients.pressure_beads, pressure.beads));
    return report;
}

namespace {
/// The arrays of one state, filled over angles and the axis that follows.
class StateTable {
public:
    StateTable(std::string group, std::vector<files::Axis> axes) : table_{std::move(group), std::move(axes), {}, {}} {}

    std::vector<double>& add(const std::string& name, const std::string& unit, const std::string& meaning,
                             std::vector<std::string> axes, std::size_t size) {
        table_.quantities.push_back({name, unit, meaning, std::move(axes)});
        return table_.values.emplace_back(size, not_a_number);
    }
    files::ResultTable take() { return std::move(table_); }

private:
    files::ResultTable table_;
};

std::vector<double> logarithmic(double first, double last, int count) {
    std::vector<double> result;
    for (int k = 0; k < count; ++k) result.push_back(first * std::pow(last / first, k / (count - 1.0)));
    return result;
}

/// Names of a form's components in the order of places_of.
std::vector<std::string> component_list(const physics::Form& form) {
    std::vector<std::string> names;
    for (const physics::Component& component : physics::component_names(form)) names.push_back(component.name);
    // Components stand in the order of the form; places in that of a Symbol.
    std::vector<std::string> ordered;
    const auto add = [&](int component, int count) {
        for (int c = component; component >= 0 && c < component + count; ++c)
            ordered.push_back(names[static_cast<std::size_t>(c)]);
    };
    add(form.bead_density, 1);
    add(form.rod_density, 1);
    add(form.bead_velocity, 2);
    add(form.polar_order, 2);
    return ordered;
}

void add_branches(const physics::Equations& e, const physics::ModeMap& map, StateTable& table) {
    const std::size_t points = map.modes.size(), branches = static_cast<std::size_t>(map.modes.front().rates.size());
    const std::vector<std::string> axes{"angle", "wavenumber", "branch"};
    const auto fill = [&](const std::string& name, const std::string& unit, const std::string& meaning, auto value) {
        std::vector<double>& out = table.add(name, unit, meaning, axes, points * branches);
        for (std::size_t n = 0; n < points; ++n)
            for (std::size_t b = 0; b < branches; ++b)
                out[n * branches + b] = value(map.modes[n], static_cast<Eigen::Index>(b));
    };
    using physics::Modes;
    fill("growth_rate", "s-1", "growth rate of the mode, Re s",
         [](const Modes& m, Eigen::Index b) { return m.rates(b).real(); });
    fill("frequency", "s-1", "angular frequency of the mode, -Im s: above 0 it moves along q",
         [](const Modes& m, Eigen::Index b) { return -m.rates(b).imag(); });
    const std::vector<std::string> components = component_list(e.form);
    for (std::size_t c = 0; c < components.size(); ++c) {
        const auto row = static_cast<Eigen::Index>(c);
        fill("amplitude_" + components[c], "1",
             "amplitude of " + components[c] + " in the mode, of length 1 as numbers in mm, s, mg",
             [row](const Modes& m, Eigen::Index b) { return std::abs(m.shapes(row, b)); });
        fill("phase_" + components[c], "rad", "phase of " + components[c] + " in the mode",
             [row](const Modes& m, Eigen::Index b) { return std::arg(m.shapes(row, b)); });
    }
}

void add_slow_modes(const StateStability& state, const std::vector<double>& angles, StateTable& table) {
    const auto count = static_cast<std::size_t>(state.waves.right.cols());
    if (count == 0 || !state.waves.undefined.empty()) return;
    const std::vector<std::string> axes{"angle", "slow_mode"};
    const std::size_t size = angles.size() * count;
    // Taken once each: a reference is good only until the next is added.
    std::vector<double> speed(size), growth(size), damping(size);
    const double direction = physics::direction_of(state.state.point);
    for (std::size_t a = 0; a < angles.size(); ++a) {
        const std::vector<physics::SlowMode> modes = physics::slow_modes(state.waves, direction + angles[a]);
        for (std::size_t k = 0; k < count; ++k) {
            speed[a * count + k] = modes[k].speed.real();
            growth[a * count + k] = modes[k].speed.imag();
            damping[a * count + k] = modes[k].damping.real();
        }
    }
    table.add("slow_speed", "mm s-1", "speed u of the slow mode, s = -i u q - gamma q^2 as q -> 0", axes, size) = speed;
    table.add("slow_growth", "mm s-1", "Im u: growth of the slow mode as q", axes, size) = growth;
    table.add("slow_damping", "mm2 s-1", "Re gamma of the slow mode; not-a-number where its speed is a defective one",
              axes, size) = damping;
}

/// Parts of a structure matrix that a form has.
struct Part {
    std::string name, unit;
    std::function<double(const physics::Symbol&)> value;
};
std::vector<Part> parts_of(const physics::Form& form, double direction) {
    std::vector<Part> parts;
    const auto density = [&](const char* name, physics::FieldIndex::Value place) {
        parts.push_back({name, "mm-2", [place](const physics::Symbol& s) { return s(place, place).real(); }});
    };
    if (form.rod_density >= 0) density("rods", physics::FieldIndex::rod_density);
    if (form.bead_density >= 0) density("beads", physics::FieldIndex::bead_density);
    const std::string unit = form.order_is_density ? "mm-2" : "mm2";
    const auto order = [&](const char* name, double angle) {
        parts.push_back({name, unit, [c = std::cos(angle), sn = std::sin(angle)](const physics::Symbol& s) {
                             using namespace physics;
                             return c * c * s(FieldIndex::polar_order_x, FieldIndex::polar_order_x).real() +
                                    sn * sn * s(FieldIndex::polar_order_y, FieldIndex::polar_order_y).real() +
                                    2.0 * c * sn * s(FieldIndex::polar_order_x, FieldIndex::polar_order_y).real();
                         }});
    };
    order("order_along_p0", direction);
    order("order_across_p0", direction + 0.5 * pi);
    return parts;
}

void add_structure_factors(const physics::Equations& e, const physics::UniformPoint& point,
                           const std::vector<double>& angles, const std::vector<double>& wavenumbers, Threads& threads,
                           StateTable& table) {
    const std::size_t width = wavenumbers.size(), size = angles.size() * width;
    std::vector<physics::Symbol> matrices(size, physics::Symbol::Constant(not_a_number));
    threads.for_chunks(size, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const numerics::Wavevector q =
                physics::wavevector_from_order(point, wavenumbers[n % width], angles[n / width]);
            if (physics::mode_rates(e, point, q).real().maxCoeff() < 0.0)
                matrices[n] = physics::structure_matrix(e, point, q);
        }
    });
    for (const Part& part : parts_of(e.form, physics::direction_of(point))) {
        std::vector<double>& out =
            table.add("structure_factor_" + part.name, part.unit,
                      "equal-time structure factor of the linear theory; not-a-number where a mode grows",
                      {"angle", "wavenumber"}, size);
        for (std::size_t n = 0; n < size; ++n) out[n] = part.value(matrices[n]);
    }
}

/// Frequencies from minus to plus twice the fastest slow wave, or the fastest rate of the slowest modes.
std::vector<double> frequencies_of(const physics::Equations& e, const physics::UniformPoint& point, double q,
                                   const std::vector<double>& angles, int count) {
    double most = 0.0;
    for (const double angle : angles)
        for (const std::complex<double> s :
             physics::mode_rates(e, point, physics::wavevector_from_order(point, q, angle)))
            if (std::abs(s.imag()) > 1e-9 * std::abs(s)) most = std::max(most, std::abs(s.imag()));  // else rounding
    if (most == 0.0)
        for (const std::complex<double> s :
             physics::mode_rates(e, point, physics::wavevector_from_order(point, q, 0.0)))
            most = most == 0.0 ? std::abs(s) : std::min(most, std::abs(s));
    std::vector<double> result;
    for (int k = 0; k < count; ++k) result.push_back(2.0 * most * (2.0 * k / (count - 1.0) - 1.0));
    return result;
}

void add_dynamic_structure(const physics::Equations& e, const physics::UniformPoint& point, double q,
                           const std::vector<double>& angles, const std::vector<double>& frequencies, Threads& threads,
                           StateTable& table) {
    const std::size_t width = frequencies.size(), size = angles.size() * width;
    const std::vector<Part> parts = parts_of(e.form, physics::direction_of(point));
    std::vector<std::vector<double>> values(parts.size(), std::vector<double>(size, not_a_number));
    threads.for_chunks(angles.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a) {
            const numerics::Wavevector at = physics::wavevector_from_order(point, q, angles[a]);
            if (physics::mode_rates(e, point, at).real().maxCoeff() >= 0.0) continue;
            for (std::size_t k = 0; k < width; ++k) {
                const physics::Symbol s = physics::dynamic_structure_matrix(e, point, at, frequencies[k]);
                for (std::size_t p = 0; p < parts.size(); ++p) values[p][a * width + k] = parts[p].value(s);
            }
        }
    });
    table.add("sound_wavenumber", "mm-1", "wavenumber |q| of the dynamic structure factors", {}, 1) = {q};
    for (std::size_t p = 0; p < parts.size(); ++p)
        table.add("dynamic_structure_factor_" + parts[p].name, parts[p].unit + " s",
                  text("S(q, omega) at |q| = {:.6g} /mm; its integral over omega/(2 pi) is S(q)", q),
                  {"angle", "frequency_axis"}, size) = values[p];
}
}  // namespace

std::vector<files::ResultTable> stability_tables(const StabilityReport& report, Threads& threads) {
    const physics::Equations equations(report.scene.model);
    const io::StabilityPlan& plan = report.scene.stability;
    const std::vector<double> wavenumbers = logarithmic(report.search.min, report.search.max, plan.wavenumbers);
    const double sound = plan.sound > 0.0 ? plan.sound : longest_wave(report.scene.grid);
    std::vector<files::ResultTable> tables;
    for (const StateStability& one : report.states) {
        // Rates at q and -q are conjugate: half a turn holds all, a quarter where the state is its own mirror image.
        const physics::StationaryState& state = one.state;
        const int quarters = physics::is_mirrored(state.point) ? 1 : 2;
        std::vector<double> angles, degrees, branches, slow;
        const int steps = (plan.angles - 1) * quarters;
        for (int a = 0; a <= steps; ++a) angles.push_back(0.5 * pi * quarters * a / steps);
        for (const double angle : angles) degrees.push_back(angle / degree);
        const physics::ModeMap map = physics::mode_map(equations, state, wavenumbers, angles, threads);
        for (int b = 0; b < map.modes.front().rates.size(); ++b) branches.push_back(b);
        for (int k = 0; k < std::max<Eigen::Index>(1, one.waves.right.cols()); ++k) slow.push_back(k);
        const std::vector<double> frequencies = frequencies_of(equations, state.point, sound, angles, plan.frequencies);
        std::string group = "/" + one.state.name;
        std::replace(group.begin(), group.end(), ' ', '_');
        StateTable table(
            group, {{"angle", "degree",
                     "angle of the wavevector from p0 (without order from the velocity of the beads, at rest from x)",
                     degrees},
                    {"wavenumber", "mm-1", "wavenumber |q|", wavenumbers},
                    {"branch", "1", "branch of the modes, followed from the smallest q along p0", branches},
                    {"slow_mode", "1", "slow modes at each angle, by their speed", slow},
                    {"frequency_axis", "s-1", "angular frequency omega", frequencies}});
        add_branches(equations, map, table);
        add_slow_modes(one, angles, table);
        if (is_noisy(report.scene.model.noise)) {
            add_structure_factors(equations, state.point, angles, wavenumbers, threads, table);
            add_dynamic_structure(equations, state.point, sound, angles, frequencies, threads, table);
        }
        tables.push_back(table.take());
    }
    return tables;
}

}  // namespace drover::run
