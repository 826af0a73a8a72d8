// run/model_stability.cpp: states, instabilities, terms that drive them, long waves, and maps for archives.
#include "run/model_stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/constants.hpp"
#include "run/stability_maps.hpp"

namespace drover::run {

namespace {
using std::numbers::pi;

Entry only_data(Entry entry) {
    entry.shown.text = false;
    return entry;
}

/// A state with its linearisation and the range of waves that are searched.
struct Searched {
    const model::StationaryState& state;
    model::LinearisedAt linear;
    model::GrowthSearch search;
};

List instability_list(const Searched& at) {
    List list{.name = "instabilities",
              .heading = text("waves that grow{}", at.linear.is_isotropic() ? "" : " (angles from the order)"),
              .row = "instability",
              .meaning = "ranges of |q| that grow, by angle",
              .prefix = "instability_",
              .empty = text("stable against all waves from |q| = {:.3g} to {:.3g} /mm", at.search.min, at.search.max)};
    const std::vector<double> angles = at.linear.is_isotropic() ? std::vector{0.0} : std::vector{0.0, 30.0, 60.0, 90.0};
    for (const double angle : angles)
        for (const model::Band& band : model::growth_bands(at.linear, angle * radians_per_degree, at.search))
            list.rows.push_back(
                {.entries = {number("angle", "degree", "angle of q from the order", angle),
                             number("rate", "s-1", "largest growth rate, Re s", band.growth.rate),
                             number("frequency", "s-1", "angular frequency of the fastest wave, -Im s",
                                    band.growth.frequency),
                             number("wavenumber", "mm-1", "|q| of the fastest wave", band.q),
                             number("wavelength", "mm", "2 pi/|q| of the fastest wave", 2.0 * pi / band.q),
                             number("grows_from", "mm-1", "smallest |q| that grows; 0: the smallest searched grows",
                                    band.reaches_min ? 0.0 : band.min),
                             number("grows_to", "mm-1", "largest |q| that grows; infinite: the largest searched grows",
                                    band.reaches_max ? std::numeric_limits<double>::infinity() : band.max)}});
    return list;
}

/// The share of each term in the rate of the fastest wave.
List share_list(const Searched& at, const model::FastestWave& fastest) {
    const model::Equations& equations = at.linear.equations();
    List list{.name = "shares",
              .heading =
                  text("terms in the rate {:.6g} /s of the fastest wave, |q| = {:.4g} /mm{}", fastest.growth.rate,
                       fastest.q,
                       at.linear.is_isotropic() ? "" : text(", at {:.4g} degrees", fastest.angle / radians_per_degree)),
              .row = "term",
              .meaning = "terms of the equations",
              .prefix = "share_"};
    for (std::size_t n = 0; n < fastest.shares.size(); ++n) {
        const model::TermSummary& term = equations.terms()[n];
        if (fastest.shares[n] == 0.0) continue;
        list.rows.push_back(
            {.entries = {
                 {.name = "of", .unit = "", .meaning = "field", .value = equations.model().fields[term.field].symbol},
                 {.name = "term", .unit = "", .meaning = "as written", .value = term.text},
                 number("growth", "s-1", "its share in the growth rate", fastest.shares[n].real()),
                 number("frequency", "s-1", "its share in the frequency", -fastest.shares[n].imag())}});
    }
    return list;
}

List slow_mode_list(const Searched& at, std::string& undefined) {
    List list{.name = "slow_modes",
              .heading = "long waves, s = -i u q - gamma q^2: u = speed + i growth, gamma = damping",
              .shown = {.archive = false}};
    for (const double angle : {0.0, 30.0, 60.0, 90.0}) {
        const model::SlowModes slow = model::slow_modes(at.linear, angle * radians_per_degree);
        if (!slow.why_none.empty()) {
            undefined = slow.why_none;
            continue;
        }
        for (const model::SlowMode& mode : slow.modes)
            list.rows.push_back(slow_mode_record(mode, angle, "the order", angle == 0.0 || !at.linear.is_isotropic()));
    }
    return list;
}

// ---- maps

/// Branches of modes and structure factors over angle and |q|.
files::ResultTable maps_of(const io::Scene& scene, const Searched& at, Threads& threads) {
    const int per_half = at.linear.is_isotropic() ? 1 : 2 * scene.stability.angles - 1;
    std::vector<double> angles, wavenumbers, branches;
    for (int a = 0; a < per_half; ++a) angles.push_back(per_half == 1 ? 0.0 : pi * a / (per_half - 1));
    const int looks = (per_half == 1 ? 4 : 1) * scene.stability.wavenumbers;  // a curve needs more than a map
    for (int k = 0; k < looks; ++k)
        wavenumbers.push_back(at.search.min * std::pow(at.search.max / at.search.min, k / (looks - 1.0)));
    const std::size_t width = wavenumbers.size(), size = angles.size() * width,
                      count = static_cast<std::size_t>(model::mode_rates(at.linear, {1.0, 0.0}).size());
    const std::vector<std::string> parts = model::part_names(at.linear.equations());
    for (std::size_t b = 0; b < count; ++b) branches.push_back(static_cast<double>(b));
    std::vector<double> growth(size * count, nan), frequency(size * count, nan);
    std::vector<std::vector<double>> structure(parts.size(), std::vector<double>(size, nan));
    const bool has_noise = at.linear.equations().has_noise();
    threads.for_chunks(size, 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const numerics::Wavevector q = at.linear.wavevector(wavenumbers[n % width], angles[n / width]);
            const model::Modes modes = model::modes(at.linear, q);
            for (Eigen::Index b = 0; b < modes.rates.size(); ++b) {
                growth[n * count + static_cast<std::size_t>(b)] = modes.rates(b).real();
                frequency[n * count + static_cast<std::size_t>(b)] = -modes.rates(b).imag();
            }
            if (!has_noise) continue;
            const model::Covariance found = model::covariance(at.linear, q);
            if (!found.why_none.empty()) continue;
            const model::Symbol turned = at.linear.along_and_across(found.matrix, q);
            for (std::size_t p = 0; p < parts.size(); ++p)
                structure[p][n] = turned(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(p)).real();
        }
    });
    files::ResultTable table;
    std::vector<double> in_degrees = angles;
    for (double& angle : in_degrees) angle /= radians_per_degree;
    table.axes = {{"angle", "degree", "angle of q from the order", in_degrees},
                  {"wavenumber", "mm-1", "|q|", wavenumbers},
                  {"branch", "1", "modes, fastest first", branches}};
    add_map("growth_rate", "s-1", "growth rate of the mode, Re s", {"angle", "wavenumber", "branch"}, growth, table);
    add_map("frequency", "s-1", "angular frequency of the mode, -Im s", {"angle", "wavenumber", "branch"}, frequency,
            table);
    for (std::size_t p = 0; has_noise && p < parts.size(); ++p)
        add_map("structure_factor_" + parts[p], "1",
                "structure factor of " + parts[p] +
                    " in the linear theory, in the units of the model; NaN where a mode "
                    "grows",
                {"angle", "wavenumber"}, structure[p], table);
    return table;
}

Record state_record(const io::Scene& scene, const Searched& at, std::size_t number_of_state, Threads* threads) {
    const model::Model& model = at.linear.equations().model();
    Threads one(1);
    const model::FastestWave fastest = model::fastest_wave(at.linear, at.search, threads != nullptr ? *threads : one);
    std::string undefined;
    std::string group = "/" + at.state.name;
    std::replace_if(
        group.begin() + 1, group.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    Record record{.heading = "state: " + state_words(model, at.state), .group = text("{}_{}", group, number_of_state)};
    record.entries = {only_data({.name = "name", .unit = "", .meaning = "name of the state", .value = at.state.name}),
                      only_data({.name = "free_direction",
                                 .unit = "1",
                                 .meaning = "1: turned copies of the state are states too",
                                 .value = at.state.has_free_direction}),
                      only_data({.name = "stable",
                                 .unit = "1",
                                 .meaning = "1: no wave of the search grows",
                                 .value = !fastest.growth.grows()}),
                      only_data(number("fastest_rate", "s-1", "the largest growth rate", fastest.growth.rate)),
                      only_data(number("fastest_wavenumber", "mm-1", "its |q|", fastest.q))};
    std::size_t component = 0;
    for (const model::Field& field : model.fields)
        for (const std::string& name : model::dataset_names(field))
            record.entries.push_back(
                only_data(number(name, field.unit, name + " of the state", at.state.values[component++])));
    record.lists = {instability_list(at), share_list(at, fastest), slow_mode_list(at, undefined)};
    if (fastest.growth.grows() && fastest.q == 0.0)
        record.footer.push_back(text("the uniform state itself changes at {:.6g} /s", fastest.growth.rate));
    if (fastest.growth.grows() && fastest.at_max)
        record.footer.emplace_back(
            "the growth rate still increases at the shortest wave searched; no term of the model stabilises short "
            "waves");
    if (!undefined.empty()) record.footer.push_back("no long-wave expansion: " + undefined);
    if (threads != nullptr) record.maps = maps_of(scene, at, *threads);
    return record;
}
}  // namespace

Record slow_mode_record(const model::SlowMode& mode, double angle, const std::string& direction, bool is_in_text) {
    return {.entries = {number("angle", "degree", "angle of q from " + direction, angle),
                        number("speed", "mm s-1", "Re u", mode.speed.real()),
                        number("growth", "mm s-1", "Im u", mode.speed.imag()),
                        number("damping", "mm2 s-1", "Re gamma; not defined where u is a defective eigenvalue",
                               mode.damping.real())},
            .shown = {.text = is_in_text}};
}

std::string state_text(const model::Model& model, const model::UniformState& values) {
    std::string result;
    std::size_t at = 0;
    for (const model::Field& field : model.fields) {
        const auto count = static_cast<std::size_t>(model::components(field));
        const double value = count == 1 ? values[at] : std::hypot(values[at], values[at + 1]);
        if (value != 0.0)
            result += text("{}{} = {:.6g}", result.empty() ? "" : ", ",
                           count == 1 ? field.symbol : "|" + field.symbol + "|", value);
        at += count;
    }
    return result.empty() ? "all fields 0" : result;
}

std::string state_words(const model::Model& model, const model::StationaryState& state) {
    return text("{}, {}", state.is_isotropic ? "isotropic" : "ordered", state_text(model, state.values));
}

model::GrowthSearch growth_search(const io::Scene& scene) {
    const io::StabilityPlan& plan = scene.stability;
    model::GrowthSearch search{.min = plan.min_wavenumber,
                               .max = plan.max_wavenumber,
                               .wavenumbers = std::max(3, plan.wavenumbers),
                               .angles = 2 * plan.angles};
    if (search.min == 0.0) search.min = 1e-3 * smallest_wavenumber(scene.grid);
    if (search.max == 0.0) search.max = pi * std::max(scene.grid.nx / scene.grid.lx, scene.grid.ny / scene.grid.ly);
    const char* given = plan.min_wavenumber > 0.0 ? "stability.min_wavenumber" : "stability.max_wavenumber";
    require(search.min < search.max, io::location_of(scene, given),
            "the search covers |q| = {:.4g} to {:.4g} /mm; expected stability.min_wavenumber below "
            "stability.max_wavenumber",
            search.min, search.max);
    return search;
}

Result make_model_stability(const io::Scene& scene, Threads* threads) {
    const model::Equations equations(io::model_of(scene.declared));
    const model::StationaryStates found = model::stationary_states(equations);
    const model::GrowthSearch search = growth_search(scene);
    List states{.name = "states"};
    for (const model::StationaryState& state : found.states)
        states.rows.push_back(state_record(scene, {state, model::LinearisedAt(equations, state.values), search},
                                           states.rows.size() + 1, threads));
    Record root{.entries = {{.name = "model", .unit = "", .meaning = "its name", .value = scene.declared.name},
                            number("searched_from", "mm-1", "smallest |q| of the search for instabilities", search.min),
                            number("searched_to", "mm-1", "largest |q| of the search for instabilities", search.max),
                            only_data({.name = "no_state", .unit = "", .meaning = "", .value = found.why_none}),
                            only_data({.name = "no_order", .unit = "", .meaning = "", .value = found.why_no_order})},
                .lists = {std::move(states)}};
    if (!found.why_none.empty()) root.footer.push_back("\nno uniform stationary state: " + found.why_none);
    if (!found.why_no_order.empty()) root.footer.push_back("\nno ordered state: " + found.why_no_order);
    return {.root = std::move(root)};
}

}  // namespace drover::run
