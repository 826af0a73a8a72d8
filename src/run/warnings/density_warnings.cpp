// run/warnings/density_warnings.cpp: negative densities, and values beyond a table.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "drover/base/expression.hpp"
#include "io/units.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// Samples below a limit (or above it, with the sign -1), and the worst of them.
struct Excess {
    std::size_t samples = 0;
    double worst = 0.0, time = 0.0;
};
Excess samples_below(const files::ArchiveReader& archive, const std::string& observable, double limit,
                     double sign = 1.0) {
    const std::vector<double> values = series_of(archive, observable), times = series_of(archive, "time");
    Excess excess;
    for (std::size_t i = 0; i < std::min(values.size(), times.size()); ++i) {
        if (!(sign * values[i] < sign * limit)) continue;
        if (++excess.samples == 1 || sign * values[i] < sign * excess.worst)
            excess = {.samples = excess.samples, .worst = values[i], .time = times[i]};
    }
    return excess;
}

/// A remedy where noise makes densities negative: relative shot noise of 1/4 or less in a cell, of which zero is four
/// standard deviations away.
std::string more_in_a_cell(const numerics::Grid& grid, const model::Integrated& what, const model::Field& field) {
    constexpr double min_in_cell = 16.0;
    const double in_cell = field.reference * numerics::area(grid) / static_cast<double>(numerics::points(grid));
    const double excess = std::max(min_in_cell / in_cell, 4.0), factor = grid.ny == 1 ? excess : std::sqrt(excess);
    const auto even = [&](int points) { return std::max(4, 2 * static_cast<int>(points / factor / 2.0)); };
    numerics::Grid coarser = grid;
    coarser.nx = even(coarser.nx);
    if (grid.ny > 1) coarser.ny = even(coarser.ny);
    const numerics::System system = what.equations.linear_system(coarser, what.kept_degree);
    constexpr std::size_t fewest = 4;  // waves along an axis
    const bool has_waves = (coarser.nx == grid.nx || numerics::is_kept(coarser, system.degree, fewest, 0)) &&
                           (coarser.ny == grid.ny || numerics::is_kept(coarser, system.degree, 0, fewest)) &&
                           growing_waves_warning(what.equations, system, {}).empty();
    return text("a cell of the grid holds {:.2g} {}s{}{}", in_cell, field.observed.counted,
                has_waves ? ": choose larger cells, " + grid_keys(coarser)
                          : ", and a grid whose cells hold enough is too coarse for the waves: choose a larger mean",
                field.noise > 0.0 ? text(", or noise of the strength {:.2g}", field.noise / 4.0) : "");
}

/// Negative densities of bodies, except where the equation is linear in the fields and noise makes them, and where the
/// model stops at them.
void add_negative_densities(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                            std::vector<std::string>& warnings) {
    const model::Equations& equations = what.equations;
    const std::vector<model::Field>& fields = equations.model().fields;
    for (std::size_t n = 0; n < fields.size(); ++n) {
        const model::Field& field = fields[n];
        if (field.observed.counted.empty()) continue;
        const bool is_linear =
            std::ranges::all_of(equations.terms(), [&](const auto& term) { return term.field != n || term.is_linear; });
        if (is_linear && equations.has_noise()) continue;
        // An edge, such as that of a vacuum, rings by less than a hundredth of the density beside it.
        const std::vector<double> highest = series_of(archive, "max_" + field.name);
        const double scale = highest.empty() ? field.reference : *std::ranges::max_element(highest);
        const Excess negative = samples_below(archive, "min_" + field.name, -0.01 * scale);
        if (negative.samples == 0) continue;
        warnings.push_back(
            text("{} is negative in {} samples, {} at t = {} (min_{}); expected >= 0: {}{}", field.name,
                 negative.samples, io::in_unit("{:.3g}", negative.worst, field.unit, scene.units),
                 io::in_unit("{:.6g}", negative.time, "s", scene.units), field.name,
                 equations.has_noise() ? more_in_a_cell(scene.grid, what, field)
                                       : text("choose a larger {}, a smaller time.dt or a finer grid",
                                              key_of_term(scene, equations, field, "lap " + field.symbol)),
                 is_linear ? "" : ", or terms that are linear in the fields, which allow negative densities"));
    }
}

/// A formula in one field that does not turn, and numbers of the model; nothing where it is of another kind.
struct OfField {
    const model::Field* field;
    Expression value;
};
std::optional<OfField> of_one_field(const std::string& formula, const io::Scene& scene, const model::Model& model) {
    for (const model::Field& field : model.fields) {
        if (field.spin != 0) continue;
        try {
            return OfField{&field, parse_expression(formula, {.variables = {{field.symbol, 0}},
                                                              .constants = scene.declared.coefficients})};
        } catch (const Error&) {  // it has other names
        }
    }
    return std::nullopt;
}

/// A table that holds the values at its edge, of a formula: samples in which it left its nodes.
void add_held_formula(const files::ArchiveReader& archive, const io::Scene& scene, const physics::HeldRange& held,
                      const model::Model& model, std::vector<std::string>& warnings) {
    const std::optional<OfField> of = of_one_field(held.symbol, scene, model);
    if (!of) {
        warnings.push_back(
            text("it is not known whether {} left the table of coefficients; outside {:.4g} to {:.4g} the values at "
                 "its edge are held (outside = \"hold\"); with outside = \"refuse\" the run would stop there",
                 held.symbol, held.min, held.max));
        return;
    }
    const std::vector<double> low = series_of(archive, "min_" + of->field->name),
                              high = series_of(archive, "max_" + of->field->name);
    std::size_t samples = 0;
    constexpr int parts = 32;
    for (std::size_t i = 0; i < std::min(low.size(), high.size()); ++i) {
        bool leaves = false;
        for (int k = 0; k <= parts && !leaves; ++k) {
            const double value = evaluate(of->value, std::array{low[i] + (high[i] - low[i]) * k / parts});
            leaves = value < held.min || value > held.max;
        }
        samples += leaves ? 1 : 0;
    }
    if (samples > 0)
        warnings.push_back(
            text("{} left the table of coefficients in {} samples; the values at its edge were held there (outside "
                 "= \"hold\"): use a table wider than {:.4g} to {:.4g}",
                 held.symbol, samples, held.min, held.max));
}
}  // namespace

void add_density_warnings(const files::ArchiveReader& archive, const io::Scene& scene, const model::Integrated& what,
                          std::vector<std::string>& warnings) {
    add_negative_densities(archive, scene, what, warnings);
    const std::vector<model::Field>& fields = what.equations.model().fields;
    for (const physics::HeldRange& held : held_ranges(scene)) {
        if (std::ranges::find(fields, held.symbol, &model::Field::symbol) == fields.end())
            add_held_formula(archive, scene, held, what.equations.model(), warnings);
        for (const model::Field& field : fields) {
            if (field.symbol != held.symbol) continue;
            for (const Excess& excess : {samples_below(archive, "min_" + field.name, held.min),
                                         samples_below(archive, "max_" + field.name, held.max, -1.0)})
                if (excess.samples > 0)
                    warnings.push_back(
                        text("{} left the table of coefficients in {} samples, {} at t = {}; the values at "
                             "its edge were held there (outside = \"hold\"): use a table wider than {:.4g} to {}",
                             field.name, excess.samples, io::in_unit("{:.4g}", excess.worst, field.unit, scene.units),
                             io::in_unit("{:.6g}", excess.time, "s", scene.units), held.min,
                             io::in_unit("{:.4g}", held.max, field.unit, scene.units)));
        }
    }
}

}  // namespace drover::run
