// measure/observables.cpp: the rows of what is measured on fields.
#include "drover/measure/observables.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace drover::measure {

namespace {

using numerics::Complex;
using Powers = std::vector<double> ModePowers::*;

double mean_of_component(const Moment& moment, int component) { return moment.spectra[component][0].real(); }

double mean_order_size(const Moment& moment) {
    const int p = moment.setting.form.polar_order;
    return std::hypot(mean_of_component(moment, p), mean_of_component(moment, p + 1));
}

double largest_order(const Moment& moment) {
    const auto x = moment.fields[moment.setting.form.polar_order],
               y = moment.fields[moment.setting.form.polar_order + 1];
    double most = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, x[i] * x[i] + y[i] * y[i]);
    return std::sqrt(most);
}

Observable number(std::string name, std::string unit, std::string formula,
                  std::function<double(const Moment&)> function) {
    return {std::move(name),
            std::move(unit),
            {},
            std::move(formula),
            [function = std::move(function)](const Moment& moment, std::span<double> out) {
                out[0] = function(moment);
            }};
}

/// S(q) = area |a_q|^2 by shell.
Observable by_shell(std::string name, std::string formula, Powers powers) {
    return {std::move(name),
            "mm-2",
            {ObservableAxis::shell},
            std::move(formula),
            [powers](const Moment& moment, std::span<double> out) {
                const Setting& setting = moment.setting;
                const auto means = numerics::shell_means(setting.grid, setting.shells, moment.powers.*powers);
                for (std::size_t n = 0; n < means.size(); ++n) out[n] = numerics::area(setting.grid) * means[n];
            }};
}

/// The same by direction and shell, summed over the parts given.
Observable by_direction(std::string name, std::string formula, std::vector<Powers> parts) {
    return {std::move(name),
            "mm-2",
            {ObservableAxis::sector, ObservableAxis::shell},
            std::move(formula),
            [parts = std::move(parts)](const Moment& moment, std::span<double> out) {
                const Setting& setting = moment.setting;
                std::fill(out.begin(), out.end(), 0.0);
                for (const Powers powers : parts) {
                    const auto means =
                        numerics::sector_means(setting.grid, setting.shells, setting.sectors, moment.powers.*powers);
                    for (std::size_t n = 0; n < means.size(); ++n) out[n] += numerics::area(setting.grid) * means[n];
                }
            }};
}

void add_rods(std::vector<Observable>& rows) {
    rows.push_back(number("rods_total", "1", "number of rods: integral of the rod density sigma over the cell",
                          [](const Moment& moment) {
                              return numerics::area(moment.setting.grid) *
                                     mean_of_component(moment, moment.setting.form.rod_density);
                          }));
    rows.push_back(number("rod_density_least", "mm-2", "least rod density sigma on the grid", [](const Moment& moment) {
        const auto sigma = moment.fields[moment.setting.form.rod_density];
        return *std::min_element(sigma.begin(), sigma.end());
    }));
    rows.push_back(
        number("rod_density_most", "mm-2", "largest rod density sigma on the grid", [](const Moment& moment) {
            const auto sigma = moment.fields[moment.setting.form.rod_density];
            return *std::max_element(sigma.begin(), sigma.end());
        }));
    rows.push_back(by_shell("structure_factor_rods",
                            "structure factor of the rod density: area |sigma_q|^2, mean over a shell of |q|",
                            &ModePowers::rods));
    rows.push_back(
        by_direction("structure_factor_rods_direction",
                     "structure factor of the rod density by direction of q from x: area |sigma_q|^2, mean over a "
                     "sector of a shell; not-a-number where no mode lies",
                     {&ModePowers::rods}));
    rows.push_back({"rod_number_variance",
                    "1",
                    {ObservableAxis::box},
                    "variance of the number of rods in a box, DN^2: over all positions of the box at one time",
                    [](const Moment& moment, std::span<double> out) {
                        const Setting& setting = moment.setting;
                        for (std::size_t b = 0; b < setting.boxes.size(); ++b)
                            out[b] = numerics::box_variance(setting.grid, moment.powers.rods, setting.boxes[b],
                                                            setting.boxes[b]);
                    }});
}

void add_order(std::vector<Observable>& rows) {
    rows.push_back(
        number("polar_order_mean_x", "mm-2", "mean over the cell of the polar order density along x, <p_x>",
               [](const Moment& moment) { return mean_of_component(moment, moment.setting.form.polar_order); }));
    rows.push_back(
        number("polar_order_mean_y", "mm-2", "mean over the cell of the polar order density along y, <p_y>",
               [](const Moment& moment) { return mean_of_component(moment, moment.setting.form.polar_order + 1); }));
    rows.push_back(number("polar_order_largest", "mm-2", "largest |p| on the grid", largest_order));
    rows.push_back(
        by_shell("structure_factor_order_along",
                 "structure factor of the polar order along q (splay): area |q.p_q|^2/q^2, mean over a shell of |q|",
                 &ModePowers::order_along));
    rows.push_back(
        by_shell("structure_factor_order_across",
                 "structure factor of the polar order across q (bend): area |q x p_q|^2/q^2, mean over a shell of |q|",
                 &ModePowers::order_across));
    rows.push_back(
        by_direction("structure_factor_order_direction",
                     "structure factor of the polar order by direction of q from x: area |p_q|^2, mean over a sector "
                     "of a shell; not-a-number where no mode lies",
                     {&ModePowers::order_along, &ModePowers::order_across}));
}

void add_rods_and_order(std::vector<Observable>& rows) {
    rows.push_back(number("polar_order", "1",
                          "polar order P = |<p>|/<sigma>, means over the cell: the size of the mean orientation",
                          [](const Moment& moment) {
                              return mean_order_size(moment) /
                                     mean_of_component(moment, moment.setting.form.rod_density);
                          }));
    rows.push_back(
        by_shell("structure_factor_cross",
                 "cross structure factor of rods and order along q: area Re(sigma_q^* i q.p_q)/|q|, mean over a shell "
                 "of |q|; its mean over time is zero when a conserved sigma is stationary",
                 &ModePowers::cross));
}

}  // namespace

Setting make_setting(const numerics::Grid& grid, const physics::Form& form, int degree) {
    return {.grid = grid,
            .form = form,
            .shells = numerics::shells(grid, degree),
            .sectors = numerics::sectors(grid, direction_sectors),
            .boxes = numerics::box_ladder(std::min(grid.nx, grid.ny))};
}

ModePowers mode_powers(const Setting& setting, const numerics::Spectra& spectra) {
    const bool has_rods = setting.form.rod_density >= 0, has_order = setting.form.polar_order >= 0;
    ModePowers powers;
    if (has_rods)
        for (const Complex sigma : spectra[setting.form.rod_density]) powers.rods.push_back(std::norm(sigma));
    if (!has_order) return powers;
    const auto px = spectra[setting.form.polar_order], py = spectra[setting.form.polar_order + 1];
    powers.order_along.resize(px.size());
    powers.order_across.resize(px.size());
    if (has_rods) powers.cross.resize(px.size());
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(setting.grid.ny); ++j)
        for (std::size_t i = 0; i < numerics::columns(setting.grid); ++i, ++mode) {
            const numerics::Wavevector q = numerics::wavevector(setting.grid, i, j);
            const double size = std::sqrt(q.x * q.x + q.y * q.y);
            const double cosine = size > 0.0 ? q.x / size : 1.0, sine = size > 0.0 ? q.y / size : 0.0;
            const Complex along = cosine * px[mode] + sine * py[mode], across = cosine * py[mode] - sine * px[mode];
            powers.order_along[mode] = std::norm(along);
            powers.order_across[mode] = std::norm(across);
            if (!has_rods) continue;
            const Complex sigma = spectra[setting.form.rod_density][mode];
            powers.cross[mode] = sigma.imag() * along.real() - sigma.real() * along.imag();  // Re(sigma^* i along)
        }
    return powers;
}

std::vector<Observable> observables(const physics::Form& form) {
    std::vector<Observable> rows;
    if (form.rod_density >= 0 && form.polar_order >= 0) add_rods_and_order(rows);
    if (form.polar_order >= 0) add_order(rows);
    if (form.rod_density >= 0) add_rods(rows);
    return rows;
}

std::size_t size_of(ObservableAxis axis, const Setting& setting) {
    switch (axis) {
        case ObservableAxis::shell: return setting.shells.q.size();
        case ObservableAxis::sector: return static_cast<std::size_t>(setting.sectors.count);
        case ObservableAxis::box: break;
    }
    return setting.boxes.size();
}

std::size_t size_of(const Observable& observable, const Setting& setting) {
    std::size_t size = 1;
    for (const ObservableAxis axis : observable.axes) size *= size_of(axis, setting);
    return size;
}

}  // namespace drover::measure
