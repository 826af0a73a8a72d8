// measure/observables.cpp: the rows of what is measured on fields.
#include "drover/measure/observables.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/numerics/transform.hpp"

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

/// UDUNITS text of the order and of its structure factor.
std::string order_unit(const physics::Form& form) { return form.order_is_density ? "mm-2" : "1"; }
std::string order_factor_unit(const physics::Form& form) { return form.order_is_density ? "mm-2" : "mm2"; }

/// S(q) = area |a_q|^2 by shell.
Observable by_shell(std::string name, std::string unit, std::string formula, Powers powers) {
    return {std::move(name),
            std::move(unit),
            {ObservableAxis::shell},
            std::move(formula),
            [powers](const Moment& moment, std::span<double> out) {
                const Setting& setting = moment.setting;
                const auto means = numerics::shell_means(setting.grid, setting.shells, moment.powers.*powers);
                for (std::size_t n = 0; n < means.size(); ++n) out[n] = numerics::area(setting.grid) * means[n];
            }};
}

/// The same by direction and shell, summed over the parts given.
Observable by_direction(std::string name, std::string unit, std::string formula, std::vector<Powers> parts) {
    return {std::move(name),
            std::move(unit),
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

/// Total, extremes, structure factors and number fluctuations of one of the densities.
void add_density(const std::string& what, const std::string& symbol, int component, Powers powers,
                 std::vector<Observable>& rows) {
    const std::string density = what + " density " + symbol;
    rows.push_back(number(what + "s_total", "1",
                          "number of " + what + "s: integral of the " + density + " over the cell",
                          [component](const Moment& moment) {
                              return numerics::area(moment.setting.grid) * mean_of_component(moment, component);
                          }));
    rows.push_back(
        number(what + "_density_least", "mm-2", "least " + density + " on the grid", [component](const Moment& moment) {
            const auto values = moment.fields[component];
            return *std::min_element(values.begin(), values.end());
        }));
    rows.push_back(number(what + "_density_most", "mm-2", "largest " + density + " on the grid",
                          [component](const Moment& moment) {
                              const auto values = moment.fields[component];
                              return *std::max_element(values.begin(), values.end());
                          }));
    rows.push_back(
        by_shell("structure_factor_" + what + "s", "mm-2",
                 "structure factor of the " + what + " density: area |" + symbol + "_q|^2, mean over a shell of |q|",
                 powers));
    rows.push_back(by_direction("structure_factor_" + what + "s_direction", "mm-2",
                                "structure factor of the " + what + " density by direction of q from x: area |" +
                                    symbol + "_q|^2, mean over a sector of a shell; not-a-number where no mode lies",
                                {powers}));
    for (const BoxFamily& family : box_families())
        rows.push_back({what + "_number_variance" + family.ending,
                        "1",
                        {family.axis},
                        "variance of the number of " + what + "s in a " + family.shape +
                            ", DN^2: over all positions of the box at one time",
                        [powers, &family](const Moment& moment, std::span<double> out) {
                            const Setting& setting = moment.setting;
                            const std::vector<int>& sides = setting.*family.sides;
                            for (std::size_t b = 0; b < sides.size(); ++b)
                                out[b] = numerics::box_variance(setting.grid, moment.powers.*powers,
                                                                family.along_x * sides[b], family.along_y * sides[b]);
                        }});
}

/// <p(r0).p(r0 + r)>, by the transform of |p_q|^2, and mean over all r0 and over the directions of r.
void measure_order_correlation(const Moment& moment, std::span<double> out) {
    const Setting& setting = moment.setting;
    numerics::Spectra power(setting.grid, 1);
    for (std::size_t m = 0; m < power.size; ++m)
        power[0][m] = moment.powers.order_along[m] + moment.powers.order_across[m];
    numerics::Fields correlation(setting.grid, 1);
    Threads one(1);
    numerics::Transform(setting.grid, setting.degree, one).backward(power, correlation);
    std::vector<double> weight(out.size());
    std::fill(out.begin(), out.end(), 0.0);
    for (std::size_t i = 0; i < correlation.size; ++i) {
        if (setting.separation_bin[i] < 0) continue;
        const auto bin = static_cast<std::size_t>(setting.separation_bin[i]);
        out[bin] += correlation[0][i];
        weight[bin] += 1.0;
    }
    for (std::size_t bin = 0; bin < out.size(); ++bin) out[bin] /= weight[bin];
}

void add_order(const physics::Form& form, std::vector<Observable>& rows) {
    const std::string unit = order_unit(form), factor = order_factor_unit(form),
                      order = form.order_is_density ? "polar order density" : "polar order";
    const int p = form.polar_order;
    rows.push_back(number("polar_order_mean_x", unit, "mean over the cell of the " + order + " along x, <p_x>",
                          [p](const Moment& moment) { return mean_of_component(moment, p); }));
    rows.push_back(number("polar_order_mean_y", unit, "mean over the cell of the " + order + " along y, <p_y>",
                          [p](const Moment& moment) { return mean_of_component(moment, p + 1); }));
    rows.push_back(number("polar_order_largest", unit, "largest |p| on the grid", largest_order));
    rows.push_back(
        by_shell("structure_factor_order_along", factor,
                 "structure factor of the polar order along q (splay): area |q.p_q|^2/q^2, mean over a shell of |q|",
                 &ModePowers::order_along));
    rows.push_back(
        by_shell("structure_factor_order_across", factor,
                 "structure factor of the polar order across q (bend): area |q x p_q|^2/q^2, mean over a shell of |q|",
                 &ModePowers::order_across));
    rows.push_back(
        by_direction("structure_factor_order_direction", factor,
                     "structure factor of the polar order by direction of q from x: area |p_q|^2, mean over a sector "
                     "of a shell; not-a-number where no mode lies",
                     {&ModePowers::order_along, &ModePowers::order_across}));
    rows.push_back(
        {"polar_order_correlation",
         form.order_is_density ? "mm-4" : "1",
         {ObservableAxis::separation},
         "pair correlation of the order, G(r) = <p(r0).p(r0 + r)>, mean over r0 and over the directions of r; the "
         "square of the mean order is in it",
         measure_order_correlation});
}

void add_rods_and_order(std::vector<Observable>& rows) {
    rows.push_back(
        by_shell("structure_factor_cross", "mm-2",
                 "cross structure factor of rods and order along q: area Re(sigma_q^* i q.p_q)/|q|, mean over a shell "
                 "of |q|; its mean over time is zero when a conserved sigma is stationary",
                 &ModePowers::cross));
}

/// P, the size of the mean orientation.
Observable polar_order(const physics::Form& form) {
    if (!form.order_is_density)
        return number("polar_order", "1", "polar order P = |<p>|, mean over the cell: the size of the mean orientation",
                      mean_order_size);
    return number("polar_order", "1",
                  "polar order P = |<p>|/<sigma>, means over the cell: the size of the mean orientation",
                  [](const Moment& moment) {
                      return mean_order_size(moment) / mean_of_component(moment, moment.setting.form.rod_density);
                  });
}

double velocity_mean(const Moment& moment, int axis) { return (*moment.velocity)[axis][0].real(); }

double velocity_square(const Moment& moment) {
    double sum = 0.0;
    const numerics::Grid& grid = moment.setting.grid;
    for (int axis = 0; axis < 2; ++axis)
        for (std::size_t m = 0; m < moment.velocity->size; ++m)
            sum += numerics::mode_weight(grid, m % numerics::columns(grid)) * std::norm((*moment.velocity)[axis][m]);
    return sum;
}

void add_velocity(std::vector<Observable>& rows) {
    rows.push_back(number("bead_velocity_mean_x", "mm s-1", "mean over the cell of the bead velocity along x, <v_x>",
                          [](const Moment& moment) { return velocity_mean(moment, 0); }));
    rows.push_back(number("bead_velocity_mean_y", "mm s-1", "mean over the cell of the bead velocity along y, <v_y>",
                          [](const Moment& moment) { return velocity_mean(moment, 1); }));
    rows.push_back(number("bead_speed", "mm s-1", "root mean square of the bead velocity over the cell",
                          [](const Moment& moment) { return std::sqrt(velocity_square(moment)); }));
    rows.push_back(
        number("bead_velocity_order", "1",
               "order of the bead velocity, |<v>|/sqrt(<v^2>), means over the cell: 1 when all beads move alike",
               [](const Moment& moment) {
                   const double square = velocity_square(moment);
                   return square > 0.0
                              ? std::hypot(velocity_mean(moment, 0), velocity_mean(moment, 1)) / std::sqrt(square)
                              : 0.0;
               }));
    rows.push_back(
        by_shell("structure_factor_velocity_along", "mm4 s-2",
                 "structure factor of the bead velocity along q (sound): area |q.v_q|^2/q^2, mean over a shell of |q|",
                 &ModePowers::velocity_along));
    rows.push_back(by_shell(
        "structure_factor_velocity_across", "mm4 s-2",
        "structure factor of the bead velocity across q (shear): area |q x v_q|^2/q^2, mean over a shell of |q|",
        &ModePowers::velocity_across));
}

/// Share of the variance of a field that stands in the outer third of its kept modes: what a finer grid would still change.
void add_tails(const physics::Form& form, std::vector<Observable>& rows) {
    const auto add = [&](const std::string& name, int first, int count) {
        if (first < 0) return;
        rows.push_back(
            number("spectral_tail_" + name, "1",
                   "share of the variance of the " + name +
                       " in modes beyond two thirds of the cut of the grid on either axis: small when it is resolved",
                   [first, count](const Moment& moment) {
                       const numerics::Grid& grid = moment.setting.grid;
                       const std::size_t width = numerics::columns(grid);
                       const double cut = 2.0 / 3.0 / (moment.setting.degree + 1);
                       double tail = 0.0, all = 0.0;
                       for (int c = first; c < first + count; ++c)
                           for (std::size_t m = 1; m < moment.spectra.size; ++m) {
                               const double power =
                                   numerics::mode_weight(grid, m % width) * std::norm(moment.spectra[c][m]);
                               all += power;
                               if (static_cast<double>(m % width) > cut * grid.nx ||
                                   std::abs(numerics::mode_number_y(grid, m / width)) > cut * grid.ny)
                                   tail += power;
                           }
                       return all > 0.0 ? tail / all : 0.0;
                   }));
    };
    add("bead_density", form.bead_density, 1);
    add("rod_density", form.rod_density, 1);
    add("bead_velocity", form.bead_velocity, 2);
    add("polar_order", form.polar_order, 2);
}

void add_energies(const physics::Form& form, std::vector<Observable>& rows) {
    const std::string order = form.order_is_density ? "mm-2" : "mm2";
    rows.push_back(number("energy_order", order, "energy of the order: integral of |p|^2/2",
                          [](const Moment& moment) { return moment.energy->order; }));
    rows.push_back({"power_order",
                    order + " s-1",
                    {ObservableAxis::term},
                    "power of each term on the energy of the order",
                    [](const Moment& moment, std::span<double> out) {
                        std::copy(moment.energy->order_powers.begin(), moment.energy->order_powers.end(), out.begin());
                    }});
    if (form.bead_velocity < 0) return;
    rows.push_back(number("energy_kinetic", "mg mm2 s-2", "kinetic energy of the beads: integral of m rho v^2/2",
                          [](const Moment& moment) { return moment.energy->kinetic; }));
    rows.push_back({"power_kinetic",
                    "mg mm2 s-3",
                    {ObservableAxis::term},
                    "power of each term on the kinetic energy of the beads",
                    [](const Moment& moment, std::span<double> out) {
                        std::copy(moment.energy->kinetic_powers.begin(), moment.energy->kinetic_powers.end(),
                                  out.begin());
                    }});
}

}  // namespace

namespace {
/// Displacements on the grid by their length, in bins as wide as a cell, out to half the shorter side; at least that of r = 0.
void sort_separations(Setting& setting) {
    const numerics::Grid& grid = setting.grid;
    const double dx = grid.lx / grid.nx, dy = grid.ly / grid.ny, width = std::max(dx, dy);
    const auto bins = std::max<std::size_t>(1, static_cast<std::size_t>(0.5 * std::min(grid.lx, grid.ly) / width));
    std::vector<double> sum(bins), weight(bins);
    for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
            const double r = std::hypot(dx * std::min(i, grid.nx - i), dy * std::min(j, grid.ny - j));
            const auto bin = static_cast<std::size_t>(r / width + 0.5);
            setting.separation_bin.push_back(bin < bins ? static_cast<int>(bin) : -1);
            if (bin >= bins) continue;
            sum[bin] += r;
            weight[bin] += 1.0;
        }
    for (std::size_t bin = 0; bin < bins; ++bin) setting.separations.push_back(sum[bin] / weight[bin]);
}

/// |part along q|^2 and |part across q|^2 of a vector, mode by mode.
void split_powers(const Setting& setting, std::span<const Complex> x, std::span<const Complex> y,
                  std::vector<double>& along, std::vector<double>& across,
                  const std::function<void(std::size_t, Complex)>& see_along) {
    along.resize(x.size());
    across.resize(x.size());
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(setting.grid.ny); ++j)
        for (std::size_t i = 0; i < numerics::columns(setting.grid); ++i, ++mode) {
            const numerics::Wavevector q = numerics::wavevector(setting.grid, i, j);
            const double size = std::sqrt(q.x * q.x + q.y * q.y);
            const double cosine = size > 0.0 ? q.x / size : 1.0, sine = size > 0.0 ? q.y / size : 0.0;
            const Complex part = cosine * x[mode] + sine * y[mode];
            along[mode] = std::norm(part);
            across[mode] = std::norm(cosine * y[mode] - sine * x[mode]);
            if (see_along) see_along(mode, part);
        }
}
}  // namespace

namespace {
/// Shorter sides of long boxes; on the least of grids the longer side is the whole cell's.
std::vector<int> long_ladder(int n) {
    std::vector<int> sides = numerics::box_ladder(n / 4);
    if (sides.empty()) sides.push_back(1);
    return sides;
}
}  // namespace

Setting make_setting(const numerics::Grid& grid, const physics::Form& form, int degree,
                     std::vector<std::string> power_terms) {
    Setting setting{.grid = grid,
                    .form = form,
                    .shells = numerics::shells(grid, degree),
                    .sectors = numerics::sectors(grid, direction_sectors),
                    .boxes = numerics::box_ladder(std::min(grid.nx, grid.ny)),
                    .long_boxes = long_ladder(std::min(grid.nx, grid.ny)),
                    .degree = degree,
                    .separations = {},
                    .separation_bin = {},
                    .terms = std::move(power_terms)};
    sort_separations(setting);
    return setting;
}

ModePowers mode_powers(const Setting& setting, const numerics::Spectra& spectra, const numerics::Spectra* velocity) {
    const physics::Form& form = setting.form;
    const bool has_rods = form.rod_density >= 0, has_beads = form.bead_density >= 0, has_order = form.polar_order >= 0;
    ModePowers powers;
    if (has_rods)
        for (const Complex sigma : spectra[form.rod_density]) powers.rods.push_back(std::norm(sigma));
    if (has_beads)
        for (const Complex rho : spectra[form.bead_density]) powers.beads.push_back(std::norm(rho));
    for (std::size_t m = 0; has_beads && has_rods && m < spectra.size; ++m)
        powers.beads_rods.push_back((std::conj(spectra[form.bead_density][m]) * spectra[form.rod_density][m]).real());
    if (velocity != nullptr)
        split_powers(setting, (*velocity)[0], (*velocity)[1], powers.velocity_along, powers.velocity_across, {});
    if (!has_order) return powers;
    if (has_rods) powers.cross.resize(spectra.size);
    const auto cross = [&](std::size_t mode, Complex along) {
        const Complex sigma = spectra[form.rod_density][mode];
        powers.cross[mode] = sigma.imag() * along.real() - sigma.real() * along.imag();  // Re(sigma^* i along)
    };
    split_powers(setting, spectra[form.polar_order], spectra[form.polar_order + 1], powers.order_along,
                 powers.order_across, has_rods ? cross : std::function<void(std::size_t, Complex)>());
    return powers;
}

std::vector<Observable> observables(const physics::Form& form, bool energies) {
    std::vector<Observable> rows;
    if (form.polar_order >= 0) rows.push_back(polar_order(form));
    if (form.rod_density >= 0 && form.polar_order >= 0) add_rods_and_order(rows);
    if (form.polar_order >= 0) add_order(form, rows);
    if (form.velocity != physics::Velocity::absent) add_velocity(rows);
    if (form.rod_density >= 0) add_density("rod", "sigma", form.rod_density, &ModePowers::rods, rows);
    if (form.bead_density >= 0) add_density("bead", "rho", form.bead_density, &ModePowers::beads, rows);
    if (form.rod_density >= 0 && form.bead_density >= 0)
        rows.push_back(
            by_shell("structure_factor_beads_rods", "mm-2",
                     "cross structure factor of beads and rods: area Re(rho_q^* sigma_q), mean over a shell of |q|",
                     &ModePowers::beads_rods));
    add_tails(form, rows);
    if (energies) add_energies(form, rows);
    return rows;
}

std::span<const BoxFamily> box_families() {
    static constexpr BoxFamily families[] = {{"", "square box", ObservableAxis::box, &Setting::boxes, 1, 1},
                                             {"_long_x", "box four times longer along x", ObservableAxis::long_box,
                                              &Setting::long_boxes, 4, 1},
                                             {"_long_y", "box four times longer along y", ObservableAxis::long_box,
                                              &Setting::long_boxes, 1, 4}};
    return families;
}

std::size_t size_of(ObservableAxis axis, const Setting& setting) {
    switch (axis) {
        case ObservableAxis::shell: return setting.shells.q.size();
        case ObservableAxis::sector: return static_cast<std::size_t>(setting.sectors.count);
        case ObservableAxis::separation: return setting.separations.size();
        case ObservableAxis::term: return setting.terms.size();
        case ObservableAxis::long_box: return setting.long_boxes.size();
        case ObservableAxis::box: break;
    }
    return setting.boxes.size();
}

std::size_t size_of(const Observable& observable, const Setting& setting) {
    std::size_t size = 1;
    for (const ObservableAxis axis : observable.axes) size *= size_of(axis, setting);
    return size;
}

std::string name_of(ObservableAxis axis) {
    switch (axis) {
        case ObservableAxis::shell: return "wavenumber";
        case ObservableAxis::sector: return "direction";
        case ObservableAxis::box: return "box_side";
        case ObservableAxis::long_box: return "long_box_side";
        case ObservableAxis::separation: return "separation";
        case ObservableAxis::term: return "term";
    }
    return "";
}

std::vector<std::string> names_of(std::span<const ObservableAxis> axes) {
    std::vector<std::string> names;
    for (const ObservableAxis axis : axes) names.push_back(name_of(axis));
    return names;
}

}  // namespace drover::measure
