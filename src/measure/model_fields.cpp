// measure/model_fields.cpp: the observables of any field.
#include "drover/measure/model_fields.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "drover/base/text.hpp"
#include "drover/measure/fields.hpp"
#include "drover/numerics/transform.hpp"
#include "measure/field_axes.hpp"
#include "measure/shared_rows.hpp"

namespace drover::measure {

namespace {
using numerics::Complex;
using ModelRows = Observables<ModelMoment>;

/// The unit of a product of quantities: "(1/mm^2)^2 mm2".
std::string product_unit(const std::string& first, const std::string& second, const std::string& factor = "") {
    std::string unit;
    if (first == second && first != "1") unit = "(" + first + ")^2";
    else
        for (const std::string& one : {first, second})
            if (one != "1") unit += (unit.empty() ? "(" : " (") + one + ")";
    if (!factor.empty()) unit += (unit.empty() ? "" : " ") + factor;
    return unit.empty() ? "1" : unit;
}

/// Calls see(mode, column, row) for each stored mode.
template <class See>
void for_stored_modes(const numerics::Grid& grid, See see) {
    std::size_t mode = 0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(grid.ny); ++row)
        for (std::size_t column = 0; column < numerics::columns(grid); ++column) see(mode++, column, row);
}

FieldPowers powers_of_field(const MeasuredField& field, const ModelMoment& moment) {
    FieldPowers powers;
    if (field.spin == 0) {
        for (const Complex value : moment.modes(field.first)) powers.along.push_back(std::norm(value));
        return powers;
    }
    const auto first = moment.modes(field.first), second = moment.modes(field.first + 1);
    powers.along.resize(first.size());
    powers.across.resize(first.size());
    const numerics::Grid& grid = moment.setting.grid.grid;
    for_stored_modes(grid, [&](std::size_t mode, std::size_t column, std::size_t row) {
        const numerics::Wavevector q = numerics::wavevector(grid, column, row);
        const double angle = field.spin * std::atan2(q.y, q.x), cosine = std::cos(angle), sine = std::sin(angle);
        if (mode == 0 || !field.is_solenoidal)
            powers.along[mode] = std::norm(cosine * first[mode] + sine * second[mode]);
        powers.across[mode] = std::norm(cosine * second[mode] - sine * first[mode]);
    });
    return powers;
}

std::vector<double> sum_of(const FieldPowers& powers) {
    std::vector<double> sum = powers.along;
    for (std::size_t mode = 0; mode < powers.across.size(); ++mode) sum[mode] += powers.across[mode];
    return sum;
}

/// area times the mean over each shell.
std::vector<double> by_shell(const FieldSetting& setting, const std::vector<double>& powers) {
    std::vector<double> means = numerics::shell_means(setting.grid, setting.shells, powers);
    for (double& mean : means) mean *= numerics::area(setting.grid);
    return means;
}

double mean_of(const ModelMoment& moment, int component) { return moment.modes(component)[0].real(); }

double largest_size(const ModelMoment& moment, int first) {
    const auto x = moment.points(first), y = moment.points(first + 1);
    double square = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) square = std::max(square, x[i] * x[i] + y[i] * y[i]);
    return std::sqrt(square);
}

struct ModelVariance {
    double all = 0.0, tail = 0.0;
};
ModelVariance variance_of(const FieldSetting& setting, const FieldPowers& powers) {
    ModelVariance variance;
    const std::vector<double> sum = sum_of(powers);
    for_stored_modes(setting.grid, [&](std::size_t mode, std::size_t column, std::size_t row) {
        if (mode == 0 || !numerics::is_kept(setting.grid, setting.degree, column, row)) return;
        const double power = sum[mode] * numerics::mode_weight(setting.grid, column);
        variance.all += power;
        if (is_in_tail(setting.grid, setting.degree, column, row)) variance.tail += power;
    });
    return variance;
}

void add_means(const ModelSetting& setting, const MeasuredField& field, ModelRows& rows) {
    const int first = field.first;
    for (int part = 0; part < (field.spin == 0 ? 1 : 2); ++part) {
        const std::string& name = setting.components[static_cast<std::size_t>(first + part)].name;
        add(rows, "mean_" + name, field.unit, "mean of " + name + " over the cell",
            [component = first + part](const ModelMoment& moment) { return mean_of(moment, component); });
    }
    if (field.spin == 0) {
        add(rows, "min_" + field.name, field.unit, "smallest " + field.name + " on the grid",
            [first](const ModelMoment& moment) { return std::ranges::min(moment.points(first)); });
        add(rows, "max_" + field.name, field.unit, "largest " + field.name + " on the grid",
            [first](const ModelMoment& moment) { return std::ranges::max(moment.points(first)); });
        return;
    }
    add(rows, "size_mean_" + field.name, field.unit, "size of the mean of " + field.name + " over the cell",
        [first](const ModelMoment& moment) { return std::hypot(mean_of(moment, first), mean_of(moment, first + 1)); });
    add(rows, "largest_" + field.name, field.unit, "largest size of " + field.name + " on the grid",
        [first](const ModelMoment& moment) { return largest_size(moment, first); });
}

void add_spectra(const ModelSetting& setting, std::size_t n, ModelRows& rows) {
    const MeasuredField& field = setting.fields[n];
    const FieldSetting& grid = setting.grid;
    const std::string square = product_unit(field.unit, field.unit),
                      factor = product_unit(field.unit, field.unit, "mm2"), symbol = field.symbol;
    add(rows, "variance_" + field.name, square, "variance of " + field.name + " over the cell",
        [n](const ModelMoment& moment) { return variance_of(moment.setting.grid, moment.powers[n]).all; });
    add(rows, "spectral_tail_" + field.name, "1",
        "fraction of the variance of " + field.name +
            " in modes beyond two thirds of the cut of the grid on either axis: small when it is resolved",
        [n](const ModelMoment& moment) {
            const ModelVariance variance = variance_of(moment.setting.grid, moment.powers[n]);
            return variance.all != 0.0 ? variance.tail / variance.all : 0.0;  // NaN stays NaN
        });
    const auto part = [&](const std::string& ending, const std::string& meaning,
                          std::vector<double> FieldPowers::*powers) {
        add(rows, "structure_factor_" + field.name + ending, factor, {shell_axis(grid)},
            "structure factor of " + field.name + meaning + ": area |" + symbol + "_q|^2, mean over a shell of |q|",
            [n, powers](const ModelMoment& moment) { return by_shell(moment.setting.grid, moment.powers[n].*powers); });
    };
    if (field.spin == 0) {
        part("", "", &FieldPowers::along);
    } else {
        part("_along", ", its part along q", &FieldPowers::along);
        part("_across", ", its part across q", &FieldPowers::across);
    }
    add(rows, "structure_factor_" + field.name + "_direction", factor, {sector_axis(grid), shell_axis(grid)},
        "structure factor of " + field.name + " by direction of q from x: area |" + symbol +
            "_q|^2, mean over a sector of a shell; NaN where the sector contains no mode",
        [n](const ModelMoment& moment) {
            const FieldSetting& g = moment.setting.grid;
            std::vector<double> means = numerics::sector_means(g.grid, g.shells, g.sectors, sum_of(moment.powers[n]));
            for (double& mean : means) mean *= numerics::area(g.grid);
            return means;
        });
    add(rows, "correlation_" + field.name, square, {separation_axis(grid)},
        "<" + symbol + "(r0) . " + symbol +
            "(r0 + r)>, averaged over r0 and over the directions of r; includes the square of the mean",
        [n](const ModelMoment& moment) { return radial_correlation(moment.setting.grid, sum_of(moment.powers[n])); });
}

void add_boxes(const ModelSetting& setting, std::size_t n, ModelRows& rows) {
    for (const BoxFamily& family : box_families())
        add_number_variance(rows, setting.fields[n].name, family.ending, family.shape,
                            family_axis(family, setting.grid), [n, &family](const ModelMoment& moment) {
                                const FieldSetting& g = moment.setting.grid;
                                std::vector<double> variances;
                                for (const int side : g.*family.sides) {
                                    const numerics::BoxCells box =
                                        numerics::box_cells(g.grid, side, family.along_x, family.along_y);
                                    variances.push_back(
                                        numerics::box_variance(g.grid, moment.powers[n].along, box.x, box.y));
                                }
                                return variances;
                            });
}

void add_pair(const ModelSetting& setting, const MeasuredField& a, const MeasuredField& b, ModelRows& rows) {
    add(rows, "structure_factor_" + a.name + "_" + b.name, product_unit(a.unit, b.unit, "mm2"),
        {shell_axis(setting.grid)},
        text("cross structure factor of {} and {}: area Re({}_q^* {}_q), mean over a shell of |q|", a.name, b.name,
             a.symbol, b.symbol),
        [first = a.first, second = b.first](const ModelMoment& moment) {
            const auto one = moment.modes(first), other = moment.modes(second);
            std::vector<double> products;
            for (std::size_t mode = 0; mode < one.size(); ++mode)
                products.push_back((std::conj(one[mode]) * other[mode]).real());
            return by_shell(moment.setting.grid, products);
        });
}
}  // namespace

ModelSetting make_model_setting(const model::Equations& equations, const numerics::Grid& grid, int degree,
                                bool watches_error, bool with_balanced) {
    ModelSetting setting{.grid = make_field_setting(grid, physics::Form{}, degree),
                         .fields = {},
                         .components = model::components_of_state(equations)};
    setting.of_state = static_cast<int>(setting.components.size());
    if (with_balanced)
        std::ranges::copy(model::components_in_balance(equations), std::back_inserter(setting.components));
    setting.grid.watches_error = watches_error;
    for (std::size_t c = 0; c < setting.components.size(); ++c) {
        const model::StateComponent& component = setting.components[c];
        if (component.part != 0) continue;
        const model::Field& field = equations.model().fields[component.field];
        setting.fields.push_back({.name = field.name,
                                  .symbol = field.symbol,
                                  .unit = field.unit,
                                  .spin = field.spin,
                                  .odd = field.odd,
                                  .first = static_cast<int>(c),
                                  .is_density = field.spin == 0 && field.conserved && field.reference > 0.0,
                                  .is_solenoidal = field.solenoidal});
    }
    return setting;
}

std::vector<FieldPowers> ModelMoment::powers_of(const ModelMoment& moment) {
    std::vector<FieldPowers> powers;
    for (const MeasuredField& field : moment.setting.fields) powers.push_back(powers_of_field(field, moment));
    return powers;
}

Observables<ModelMoment> model_observables(const ModelSetting& setting) {
    ModelRows rows;
    for (std::size_t n = 0; n < setting.fields.size(); ++n) {
        add_means(setting, setting.fields[n], rows);
        add_spectra(setting, n, rows);
        if (setting.fields[n].is_density) add_boxes(setting, n, rows);
    }
    for (std::size_t a = 0; a < setting.fields.size(); ++a)
        for (std::size_t b = a + 1; b < setting.fields.size(); ++b)
            if (setting.fields[a].spin == 0 && setting.fields[b].spin == 0)
                add_pair(setting, setting.fields[a], setting.fields[b], rows);
    if (setting.grid.watches_error)
        add(rows, "step_error", "1",
            "estimated error of the time steps so far: the largest of any field, relative to its deviation from its "
            "mean over the cell and time; with noise on the same path",
            [](const ModelMoment& moment) { return moment.step_error; });
    std::erase_if(rows, [](const auto& row) { return size_of(row.axes) == 0; });  // a grid too small for any shell
    return rows;
}

Recorded model_recording(const ModelSetting& setting, std::vector<RecordedSeries> series) {
    Recorded recorded{.series = std::move(series), .area = numerics::area(setting.grid.grid)};
    const auto points = static_cast<double>(numerics::points(setting.grid.grid));
    for (const MeasuredField& field : setting.fields) {
        if (field.first >= setting.of_state) break;  // what is in balance follows the others
        if (const RecordedSeries* variance = find_row(recorded.series, "variance_" + field.name))
            recorded.indicators.push_back(variance->values);
        if (const RecordedSeries* mean = find_row(recorded.series, "size_mean_" + field.name))
            recorded.indicators.push_back(mean->values);
        const RecordedSeries* mean = find_row(recorded.series, "mean_" + field.name);
        if (!field.is_density || mean == nullptr || mean->values.empty()) continue;
        for (const BoxFamily& family : box_families()) {
            BoxSizes boxes{field.name, family.ending, family.shape, mean->values.front() * recorded.area, {}};
            for (const int side : setting.grid.*family.sides) {
                const numerics::BoxCells box =
                    numerics::box_cells(setting.grid.grid, side, family.along_x, family.along_y);
                boxes.fractions.push_back(static_cast<double>(box.x) * box.y / points);
            }
            recorded.boxes.push_back(std::move(boxes));
        }
    }
    return recorded;
}

std::vector<double> radial_correlation(const FieldSetting& setting, const std::vector<double>& powers) {
    numerics::Spectra power(setting.grid, 1);
    for (std::size_t m = 0; m < power.size; ++m) power[0][m] = powers[m];
    numerics::Fields correlation(setting.grid, 1);
    Threads one(1);
    numerics::Transform(setting.grid, setting.degree, one).backward(power, correlation);
    std::vector<double> sums(setting.separations.size()), counts(sums.size());
    for (std::size_t i = 0; i < correlation.size; ++i) {
        if (setting.separation_bin[i] < 0) continue;
        const auto bin = static_cast<std::size_t>(setting.separation_bin[i]);
        sums[bin] += correlation[0][i];
        counts[bin] += 1.0;
    }
    for (std::size_t bin = 0; bin < sums.size(); ++bin) sums[bin] /= counts[bin];
    return sums;
}

}  // namespace drover::measure
