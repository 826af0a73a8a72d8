// measure/field_rows.cpp: the observables of any field, and of the bodies that fields describe.
#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>

#include "drover/base/text.hpp"
#include "drover/numerics/transform.hpp"
#include "measure/fields.hpp"
#include "measure/shared_rows.hpp"
#include "measure/summary.hpp"

namespace drover::measure {

namespace {
using numerics::Complex;
using FieldRows = Observables<FieldMoment>;

Axis shell_axis(const FieldSetting& setting) {
    return {"wavenumber", "mm-1", "mean |q| of the shell", setting.shells.q};
}

Axis sector_axis(const FieldSetting& setting) {
    Axis axis{"direction", "degree", "angle of q from x; q and -q are equivalent", {}};
    for (int s = 0; s < setting.sectors.count; ++s) axis.values.push_back(180.0 / setting.sectors.count * s);
    return axis;
}

Axis family_axis(const BoxFamily& family, const FieldSetting& setting) {
    const double cell = cell_width(setting) * cell_height(setting);
    if (family.along_x == family.along_y && setting.grid.ny == 1) {
        Axis axis = box_axis(setting.*family.sides, cell);
        for (double& side : axis.values) side = std::sqrt(side * std::sqrt(cell));  // segments: area ~ cells
        return axis;
    }
    if (family.along_x == family.along_y) return box_axis(setting.*family.sides, cell);
    Axis axis{"long_box_side",
              "mm",
              setting.grid.ny == 1 ? "length of a segment of the line, or a quarter of it"
                                   : "shorter side, in cells as wide as along x, of a box with the aspect ratio 4",
              {}};
    for (const int cells : setting.*family.sides) axis.values.push_back(cell_width(setting) * cells);
    return axis;
}

/// Calls see(mode, column, row) for each stored mode.
template <class See>
void for_stored_modes(const numerics::Grid& grid, See see) {
    std::size_t mode = 0;
    for (std::size_t row = 0; row < static_cast<std::size_t>(grid.ny); ++row)
        for (std::size_t column = 0; column < numerics::columns(grid); ++column) see(mode++, column, row);
}

/// e^{i spin theta}, theta the angle of q: its real part times F_1 and its imaginary part times F_2 are along q.
Complex frame_of(const numerics::Grid& grid, std::size_t column, std::size_t row, int spin) {
    const numerics::Wavevector q = numerics::wavevector(grid, column, row);
    const double size = std::sqrt(q.x * q.x + q.y * q.y);
    const Complex direction = size > 0.0 ? Complex(q.x / size, q.y / size) : Complex(1.0);
    Complex frame = direction;
    for (int m = 1; m < spin; ++m)
        frame = {frame.real() * direction.real() - frame.imag() * direction.imag(),
                 frame.real() * direction.imag() + frame.imag() * direction.real()};
    return frame;
}

FieldPowers powers_of_field(const MeasuredField& field, const FieldMoment& moment) {
    FieldPowers powers;
    if (field.spin == 0) {
        for (const Complex value : moment.modes(field.first)) powers.along.push_back(std::norm(value));
        return powers;
    }
    const auto first = moment.modes(field.first), second = moment.modes(field.first + 1);
    powers.along.resize(first.size());
    powers.across.resize(first.size());
    const numerics::Grid& grid = moment.setting.grid;
    for_stored_modes(grid, [&](std::size_t mode, std::size_t column, std::size_t row) {
        const Complex frame = frame_of(grid, column, row, field.spin);
        if (mode == 0 || !field.solenoidal)
            powers.along[mode] = std::norm(frame.real() * first[mode] + frame.imag() * second[mode]);
        powers.across[mode] = std::norm(frame.real() * second[mode] - frame.imag() * first[mode]);
    });
    return powers;
}

/// area times the mean over each shell.
std::vector<double> by_shell(const FieldSetting& setting, const std::vector<double>& powers) {
    std::vector<double> means = numerics::shell_means(setting.grid, setting.shells, powers);
    for (double& mean : means) mean *= numerics::area(setting.grid);
    return means;
}

double mean_of(const FieldMoment& moment, int component) { return moment.modes(component)[0].real(); }

/// Sets what follows from the parts along and across q.
void complete(const FieldSetting& setting, FieldPowers& powers) {
    powers.sum = powers.along;
    for (std::size_t mode = 0; mode < powers.across.size(); ++mode) powers.sum[mode] += powers.across[mode];
    for_stored_modes(setting.grid, [&](std::size_t mode, std::size_t column, std::size_t row) {
        const double power = powers.sum[mode];
        if (mode == 0 || power == 0.0 || !numerics::is_kept(setting.grid, setting.degree, column, row)) return;
        const double weighted = power * numerics::mode_weight(setting.grid, column);
        powers.variance += weighted;
        if (is_in_tail(setting.grid, setting.degree, column, row)) powers.tail += weighted;
    });
}

/// <a(r0) a(r0 + r)> by the distance r, averaged over r0 and the directions of r.
class RadialCorrelation {
public:
    explicit RadialCorrelation(const FieldSetting& setting) : transform_(setting.grid, setting.degree, one_) {}

    /// From |a_q|^2 of each stored mode.
    std::vector<double> operator()(const FieldSetting& setting, const std::vector<double>& powers) const {
        numerics::Spectra power(setting.grid, 1);
        for (std::size_t m = 0; m < power.size; ++m) power[0][m] = powers[m];
        numerics::Fields correlation(setting.grid, 1);
        transform_.backward(power, correlation);
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

private:
    Threads one_{1};
    numerics::Transform transform_;
};

/// Sum over the grid of the product of two fields, divided by the number of points.
double mean_product(std::span<const double> a, std::span<const double> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum / static_cast<double>(a.size());
}

MeanVector mean_over_bodies(const FieldMoment& moment, const BodyVector& vector) {
    const int x = vector.first, y = x + 1, density = vector.density;
    if (density < 0) return {mean_of(moment, x), mean_of(moment, y)};
    if (vector.is_sum) return {mean_of(moment, x), mean_of(moment, y), mean_of(moment, density)};
    return {mean_product(moment.points(density), moment.points(x)),
            mean_product(moment.points(density), moment.points(y)), mean_of(moment, density)};
}

void add_means(const MeasuredField& field, FieldRows& rows) {
    const int first = field.first;
    const std::string words = words_of(field.name);
    for (std::size_t part = 0; part < field.components.size(); ++part)
        add(rows, statistic_name(field, "mean", part), field.unit,
            "mean of " + field.components[part] + " over the cell",
            [component = first + static_cast<int>(part)](const FieldMoment& moment) {
                return mean_of(moment, component);
            });
    if (field.spin == 0) {
        add(rows, "min_" + field.name, field.unit, "smallest " + words + " on the grid",
            [first](const FieldMoment& moment) { return std::ranges::min(moment.points(first)); });
        add(rows, "max_" + field.name, field.unit, "largest " + words + " on the grid",
            [first](const FieldMoment& moment) { return std::ranges::max(moment.points(first)); });
        return;
    }
    add(rows, "size_mean_" + field.name, field.unit, "size of the mean of " + words + " over the cell",
        [first](const FieldMoment& moment) { return std::hypot(mean_of(moment, first), mean_of(moment, first + 1)); });
    add(rows, statistic_name(field, "largest"), field.unit, "largest size of " + words + " on the grid",
        [first](const FieldMoment& moment) {
            const auto x = moment.points(first), y = moment.points(first + 1);
            double square = 0.0;
            for (std::size_t i = 0; i < x.size(); ++i) square = std::max(square, x[i] * x[i] + y[i] * y[i]);
            return std::sqrt(square);
        });
}

void add_spectra(const FieldSetting& setting, std::size_t n,
                 const std::shared_ptr<const RadialCorrelation>& correlation, FieldRows& rows) {
    const MeasuredField& field = setting.fields[n];
    const std::string words = words_of(field.name), symbol = field.symbol,
                      square = unit_product({field.unit, field.unit}),
                      factor = unit_product({field.unit, field.unit, "mm2"}),
                      structure_factor = "structure_factor_" + field.short_name;
    add(rows, "variance_" + field.name, square, "variance of " + words + " over the cell",
        [n](const FieldMoment& moment) { return moment.powers[n].variance; })
        .nature = Nature::square;
    auto& tail = add(rows, "spectral_tail_" + field.name, "1",
                     "fraction of the variance of " + words +
                         " in modes beyond two thirds of the cut of the grid on either axis: small when it is resolved",
                     [n](const FieldMoment& moment) {
                         const FieldPowers& powers = moment.powers[n];
                         return powers.variance != 0.0 ? powers.tail / powers.variance : 0.0;  // NaN stays NaN
                     });
    tail.nature = Nature::ratio;
    tail.is_of_grid = true;
    const auto part = [&](const std::string& ending, const std::string& meaning,
                          std::vector<double> FieldPowers::*powers) {
        add(rows, structure_factor + ending, factor, {shell_axis(setting)},
            "structure factor of " + words + meaning + ": area |" + symbol + "_q|^2, mean over a shell of |q|",
            [n, powers](const FieldMoment& moment) { return by_shell(moment.setting, moment.powers[n].*powers); })
            .nature = Nature::square_area;
    };
    if (field.spin == 0) {
        part("", "", &FieldPowers::along);
    } else {
        part("_along", ", its part along q", &FieldPowers::along);
        part("_across", ", its part across q", &FieldPowers::across);
    }
    add(rows, structure_factor + "_direction", factor, {sector_axis(setting), shell_axis(setting)},
        "structure factor of " + words + " by direction of q from x: area |" + symbol +
            "_q|^2, mean over a sector of a shell; NaN where the sector contains no mode",
        [n](const FieldMoment& moment) {
            const FieldSetting& s = moment.setting;
            std::vector<double> means = numerics::sector_means(s.grid, s.shells, s.sectors, moment.powers[n].sum);
            for (double& mean : means) mean *= numerics::area(s.grid);
            return means;
        })
        .nature = Nature::square_area;
    add(rows, statistic_name(field, "correlation"), square,
        {{"separation", "mm", "mean distance in the bin", setting.separations}},
        "<" + symbol + "(r0) . " + symbol +
            "(r0 + r)>, averaged over r0 and over the directions of r; includes the square of the mean",
        [n, correlation](const FieldMoment& moment) { return (*correlation)(moment.setting, moment.powers[n].sum); });
}

void add_numbers(const FieldSetting& setting, std::size_t n, FieldRows& rows) {
    const MeasuredField& field = setting.fields[n];
    if (field.counted != field.name)
        add(rows, total_name(field), unit_product({field.unit, "mm2"}),
            "number of " + field.counted + "s: integral of the " + words_of(field.name) + " over the cell",
            [first = field.first](const FieldMoment& moment) {
                return numerics::area(moment.setting.grid) * mean_of(moment, first);
            });
    for (const BoxFamily& family : box_families())
        add_number_variance(rows, field.counted, family.ending, shape_of(family, setting), family_axis(family, setting),
                            [n, &family](const FieldMoment& moment) {
                                const numerics::Grid& grid = moment.setting.grid;
                                std::vector<double> variances;
                                for (const int side : moment.setting.*family.sides) {
                                    const auto box = numerics::box_cells(grid, side, family.along_x, family.along_y);
                                    variances.push_back(
                                        numerics::box_variance(grid, moment.powers[n].along, box.x, box.y));
                                }
                                return variances;
                            });
}

void add_pair(const FieldSetting& setting, const MeasuredField& a, const MeasuredField& b, FieldRows& rows) {
    add(rows, cross_name(a, b), unit_product({a.unit, b.unit, "mm2"}), {shell_axis(setting)},
        text("cross structure factor of {} and {}: area Re({}_q^* {}_q), mean over a shell of |q|", words_of(a.name),
             words_of(b.name), a.symbol, b.symbol),
        [first = a.first, second = b.first](const FieldMoment& moment) {
            const auto one = moment.modes(first), other = moment.modes(second);
            std::vector<double> products;
            for (std::size_t mode = 0; mode < one.size(); ++mode)
                products.push_back((std::conj(one[mode]) * other[mode]).real());
            return by_shell(moment.setting, products);
        })
        .nature = Nature::square_area;
}

/// Of a density and the order of its bodies.
void add_cross(const FieldSetting& setting, FieldRows& rows) {
    add(rows, "structure_factor_cross", "mm-2", {shell_axis(setting)},
        "cross structure factor of rods and order along q: area Re(sigma_q^* i q.p_q)/|q|, mean over a shell of "
        "|q|; its mean over time is zero when a conserved sigma is stationary without diffusion and noise of its own",
        [](const FieldMoment& moment) {
            const numerics::Grid& grid = moment.setting.grid;
            const BodyVector& order = *moment.setting.order;
            const auto sigma = moment.modes(order.density), x = moment.modes(order.first),
                       y = moment.modes(order.first + 1);
            std::vector<double> products(sigma.size());
            for_stored_modes(grid, [&](std::size_t mode, std::size_t column, std::size_t row) {
                const Complex frame = frame_of(grid, column, row, 1);
                const Complex along = frame.real() * x[mode] + frame.imag() * y[mode];
                products[mode] = sigma[mode].imag() * along.real() - sigma[mode].real() * along.imag();
            });
            return by_shell(moment.setting, products);
        })
        .nature = Nature::square_area;
}

void add_energies(const FieldSetting& setting, FieldRows& rows) {
    Axis terms{"term", "1", "number of the term: 0, 1, ... for " + joined(*setting.terms), {}};
    for (std::size_t i = 0; i < setting.terms->size(); ++i) terms.values.push_back(static_cast<double>(i));
    for (std::size_t n = 0; n < setting.energies.size(); ++n) {
        const MeasuredEnergy& energy = setting.energies[n];
        add(rows, "energy_" + energy.name, energy.unit,
            text("energy of the {}: integral of {}", energy.of, energy.formula),
            [n](const FieldMoment& moment) { return moment.energy->energies[n]; })
            .nature = Nature::energy;
        add(rows, "power_" + energy.name, unit_product({energy.unit, "s-1"}), {terms},
            text("power of each term on the energy of the {}", energy.of),
            [n](const FieldMoment& moment) { return moment.energy->powers[n]; })
            .nature = Nature::energy;
    }
}
}  // namespace

static MeanVector mean_direction(const FieldMoment& moment) { return mean_over_bodies(moment, *moment.setting.order); }

static MeanVector mean_velocity(const FieldMoment& moment) { return mean_over_bodies(moment, *moment.setting.flow); }

static double mean_square_velocity(const FieldMoment& moment) {
    const numerics::Grid& grid = moment.setting.grid;
    const auto [first, rho, is_sum] = *moment.setting.flow;
    double sum = 0.0;
    if (rho >= 0) {
        const auto density = moment.points(rho), x = moment.points(first), y = moment.points(first + 1);
        for (std::size_t i = 0; i < density.size(); ++i) sum += density[i] * (x[i] * x[i] + y[i] * y[i]);
        return sum / static_cast<double>(density.size()) / mean_of(moment, rho);
    }
    for (int axis = 0; axis < 2; ++axis)
        for_stored_modes(grid, [&](std::size_t mode, std::size_t column, std::size_t) {
            sum += numerics::mode_weight(grid, column) * std::norm(moment.modes(first + axis)[mode]);
        });
    return sum;
}

std::string statistic_name(const MeasuredField& field, const std::string& statistic) {
    return field.observed.name_first ? field.name + "_" + statistic : statistic + "_" + field.name;
}

std::string statistic_name(const MeasuredField& field, const std::string& statistic, std::size_t part) {
    return statistic_name(field, statistic) + field.components[part].substr(field.name.size());
}

std::string total_name(const MeasuredField& field) { return field.short_name + "_total"; }

std::vector<FieldPowers> FieldMoment::powers_of(const FieldMoment& moment) {
    std::vector<FieldPowers> powers;
    for (const MeasuredField& field : moment.setting.fields) {
        powers.push_back(powers_of_field(field, moment));
        complete(moment.setting, powers.back());
    }
    return powers;
}

Observables<FieldMoment> field_observables(const FieldSetting& setting) {
    FieldRows rows;
    add_shared({.order = name_of(setting, setting.order), .flow = name_of(setting, setting.flow)}, rows);
    if (setting.order && setting.order->density >= 0) add_cross(setting, rows);
    const auto correlation = std::make_shared<const RadialCorrelation>(setting);
    for (std::size_t n = 0; n < setting.fields.size(); ++n) {
        add_means(setting.fields[n], rows);
        add_spectra(setting, n, correlation, rows);
        if (!setting.fields[n].counted.empty()) add_numbers(setting, n, rows);
    }
    for (const MeasuredField& a : setting.fields)
        for (const MeasuredField& b : setting.fields)
            if (a.first < b.first && a.spin == 0 && b.spin == 0) add_pair(setting, a, b, rows);
    if (setting.watches_error)
        add(rows, "step_error", "1",
            "estimated error of the time steps so far: the largest of any field, relative to its deviation from its "
            "mean over the cell and time; with noise on the same path, without the direction of the mean order; NaN "
            "where accuracy.effort does not resolve it",
            [](const FieldMoment& moment) { return moment.step_error; })
            .nature = Nature::ratio;
    if (setting.terms) add_energies(setting, rows);
    std::erase_if(rows, [](const auto& row) { return size_of(row.axes) == 0; });  // a grid too small for any shell
    return rows;
}

}  // namespace drover::measure
