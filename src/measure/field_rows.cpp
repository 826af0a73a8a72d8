// measure/field_rows.cpp: the observables of fields.
#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/measure/fields.hpp"
#include "measure/field_axes.hpp"
#include "measure/shared_rows.hpp"

namespace drover::measure {

namespace {

using FieldRows = Observables<FieldMoment>;
using Powers = std::vector<double> ModePowers::*;

double mean_of_component(const FieldMoment& moment, int component) { return moment.spectra[component][0].real(); }

/// Sum over the grid of the product of two fields, divided by the number of points.
double mean_product(std::span<const double> a, std::span<const double> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum / static_cast<double>(a.size());
}

std::span<const double> velocity_on_grid(const FieldMoment& moment, int axis) {
    const int v = moment.setting.form.bead_velocity;
    return v >= 0 ? moment.fields[v + axis] : (*moment.slaved_velocity)[axis];
}

double largest_order(const FieldMoment& moment) {
    const auto x = moment.fields[moment.setting.form.polar_order],
               y = moment.fields[moment.setting.form.polar_order + 1];
    double max = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) max = std::max(max, x[i] * x[i] + y[i] * y[i]);
    return std::sqrt(max);
}

}  // namespace

/// p is <n> of the rods at a point, or sigma <n>.  Without a field sigma the rods are uniform.
static MeanVector mean_direction(const FieldMoment& moment) {
    const physics::Form& form = moment.setting.form;
    const int p = form.polar_order, sigma = form.rod_density;
    if (form.order_is_density)
        return {mean_of_component(moment, p), mean_of_component(moment, p + 1), mean_of_component(moment, sigma)};
    if (sigma < 0) return {mean_of_component(moment, p), mean_of_component(moment, p + 1)};
    return {mean_product(moment.fields[sigma], moment.fields[p]),
            mean_product(moment.fields[sigma], moment.fields[p + 1]), mean_of_component(moment, sigma)};
}

static MeanVector mean_velocity(const FieldMoment& moment) {
    const int rho = moment.setting.form.bead_density;
    if (rho < 0) return {(*moment.velocity)[0][0].real(), (*moment.velocity)[1][0].real()};
    return {mean_product(moment.fields[rho], velocity_on_grid(moment, 0)),
            mean_product(moment.fields[rho], velocity_on_grid(moment, 1)), mean_of_component(moment, rho)};
}

static double mean_square_velocity(const FieldMoment& moment) {
    const numerics::Grid& grid = moment.setting.grid;
    const int rho = moment.setting.form.bead_density;
    double sum = 0.0;
    if (rho >= 0) {
        const auto density = moment.fields[rho], x = velocity_on_grid(moment, 0), y = velocity_on_grid(moment, 1);
        for (std::size_t i = 0; i < density.size(); ++i) sum += density[i] * (x[i] * x[i] + y[i] * y[i]);
        return sum / static_cast<double>(density.size()) / mean_of_component(moment, rho);
    }
    for (int axis = 0; axis < 2; ++axis)
        for (std::size_t m = 0; m < moment.velocity->size; ++m)
            sum += numerics::mode_weight(grid, m % numerics::columns(grid)) * std::norm((*moment.velocity)[axis][m]);
    return sum;
}

namespace {

/// S(q) = area |a_q|^2 by shell.
auto by_shell(Powers powers) {
    return [powers](const FieldMoment& moment) {
        const FieldSetting& setting = moment.setting;
        auto means = numerics::shell_means(setting.grid, setting.shells, moment.powers.*powers);
        for (double& mean : means) mean *= numerics::area(setting.grid);
        return means;
    };
}

/// The same by direction and shell, summed over the components given.
auto by_direction(std::vector<Powers> components) {
    return [components = std::move(components)](const FieldMoment& moment) {
        const FieldSetting& setting = moment.setting;
        std::vector<double> out(setting.shells.q.size() * static_cast<std::size_t>(setting.sectors.count));
        for (const Powers powers : components) {
            const auto means =
                numerics::sector_means(setting.grid, setting.shells, setting.sectors, moment.powers.*powers);
            for (std::size_t n = 0; n < means.size(); ++n) out[n] += numerics::area(setting.grid) * means[n];
        }
        return out;
    };
}

std::vector<double> box_variances(const BoxFamily& family, Powers powers, const FieldMoment& moment) {
    std::vector<double> variances;
    for (const int side : moment.setting.*family.sides) {
        const numerics::BoxCells box = numerics::box_cells(moment.setting.grid, side, family.along_x, family.along_y);
        variances.push_back(numerics::box_variance(moment.setting.grid, moment.powers.*powers, box.x, box.y));
    }
    return variances;
}

/// Total, extremes, structure factors and number fluctuations of one of the densities.
void add_density(const FieldSetting& setting, const std::string& what, const std::string& symbol, int component,
                 Powers powers, FieldRows& rows) {
    const std::string density = what + " density " + symbol;
    add(rows, what + "s_total", "1", "number of " + what + "s: integral of the " + density + " over the cell",
        [component](const FieldMoment& moment) {
            return numerics::area(moment.setting.grid) * mean_of_component(moment, component);
        });
    add(rows, "min_" + what + "_density", "mm-2", "smallest " + density + " on the grid",
        [component](const FieldMoment& moment) { return std::ranges::min(moment.fields[component]); });
    add(rows, "max_" + what + "_density", "mm-2", "largest " + density + " on the grid",
        [component](const FieldMoment& moment) { return std::ranges::max(moment.fields[component]); });
    add(rows, "structure_factor_" + what + "s", "mm-2", {shell_axis(setting)},
        "structure factor of the " + what + " density: area |" + symbol + "_q|^2, mean over a shell of |q|",
        by_shell(powers));
    add(rows, "structure_factor_" + what + "s_direction", "mm-2", {sector_axis(setting), shell_axis(setting)},
        "structure factor of the " + what + " density by direction of q from x: area |" + symbol +
            "_q|^2, mean over a sector of a shell; NaN where the sector contains no mode",
        by_direction({powers}));
    for (const BoxFamily& family : box_families())
        add_number_variance(rows, what, family.ending, family.shape, family_axis(family, setting),
                            [powers, &family](const FieldMoment& moment) {
                                return box_variances(family, powers, moment);
                            });
}

/// <p(r0).p(r0 + r)>, by the transform of |p_q|^2, averaged over all r0 and over the directions of r.
std::vector<double> order_correlation(const FieldMoment& moment) {
    std::vector<double> powers = moment.powers.order_along;
    for (std::size_t m = 0; m < powers.size(); ++m) powers[m] += moment.powers.order_across[m];
    return radial_correlation(moment.setting, powers);
}

void add_rods_and_order(const FieldSetting& setting, FieldRows& rows) {
    add(rows, "structure_factor_cross", "mm-2", {shell_axis(setting)},
        "cross structure factor of rods and order along q: area Re(sigma_q^* i q.p_q)/|q|, mean over a shell of "
        "|q|; its mean over time is zero when a conserved sigma is stationary without diffusion and noise of its own",
        by_shell(&ModePowers::cross));
}

void add_field_order(const FieldSetting& setting, FieldRows& rows) {
    const bool density = setting.form.order_is_density;
    const std::string unit = density ? "mm-2" : "1", factor = density ? "mm-2" : "mm2",
                      order = density ? "polar order density" : "polar order";
    const int p = setting.form.polar_order;
    const Axis shells = shell_axis(setting);
    add(rows, "polar_order_mean_x", unit, "mean over the area of the " + order + " along x, <p_x>",
        [p](const FieldMoment& moment) { return mean_of_component(moment, p); });
    add(rows, "polar_order_mean_y", unit, "mean over the area of the " + order + " along y, <p_y>",
        [p](const FieldMoment& moment) { return mean_of_component(moment, p + 1); });
    add(rows, "polar_order_largest", unit, "largest |p| on the grid", largest_order);
    add(rows, "structure_factor_order_along", factor, {shells},
        "structure factor of the polar order along q (splay): area |q.p_q|^2/q^2, mean over a shell of |q|",
        by_shell(&ModePowers::order_along));
    add(rows, "structure_factor_order_across", factor, {shells},
        "structure factor of the polar order across q (bend): area |q x p_q|^2/q^2, mean over a shell of |q|",
        by_shell(&ModePowers::order_across));
    add(rows, "structure_factor_order_direction", factor, {sector_axis(setting), shells},
        "structure factor of the polar order by direction of q from x: area |p_q|^2, mean over a sector of a "
        "shell; NaN where the sector contains no mode",
        by_direction({&ModePowers::order_along, &ModePowers::order_across}));
    add(rows, "polar_order_correlation", density ? "mm-4" : "1", {separation_axis(setting)},
        "pair correlation of the order, G(r) = <p(r0).p(r0 + r)>, averaged over r0 and over the directions of r; "
        "includes the square of the mean order",
        order_correlation);
}

void add_velocity_spectrum(const FieldSetting& setting, FieldRows& rows) {
    const Axis shells = shell_axis(setting);
    add(rows, "structure_factor_velocity_along", "mm4 s-2", {shells},
        "structure factor of the bead velocity along q (sound): area |q.v_q|^2/q^2, mean over a shell of |q|",
        by_shell(&ModePowers::velocity_along));
    add(rows, "structure_factor_velocity_across", "mm4 s-2", {shells},
        "structure factor of the bead velocity across q (shear): area |q x v_q|^2/q^2, mean over a shell of |q|",
        by_shell(&ModePowers::velocity_across));
}

/// Variance over the cell of components `first` to `first + count - 1`, and its part in the outer third of the kept
/// modes.
struct FieldVariance {
    double all = 0.0, tail = 0.0;
};
FieldVariance variance_of(const FieldMoment& moment, int first, int count) {
    const numerics::Grid& grid = moment.setting.grid;
    const int degree = moment.setting.degree;
    const std::size_t width = numerics::columns(grid);
    FieldVariance variance;
    for (std::size_t j = 0; j < moment.spectra.size / width; ++j)
        for (std::size_t i = j == 0 ? 1 : 0; i < width && numerics::is_kept(grid, degree, i, j); ++i) {
            double power = 0.0;
            for (int c = first; c < first + count; ++c) power += std::norm(moment.spectra[c][j * width + i]);
            power *= numerics::mode_weight(grid, i);
            variance.all += power;
            if (is_in_tail(grid, degree, i, j)) variance.tail += power;
        }
    return variance;
}

/// How much of each field a finer grid would still change.
void add_tails(const physics::Form& form, FieldRows& rows) {
    const auto add_one = [&](const std::string& name, const std::string& unit, int first, int count) {
        if (first < 0) return;
        add(rows, "spectral_tail_" + name, "1",
            "fraction of the variance of the " + name +
                " in modes beyond two thirds of the cut of the grid on either axis: small when it is resolved",
            [first, count](const FieldMoment& moment) {
                const FieldVariance variance = variance_of(moment, first, count);
                return variance.all != 0.0 ? variance.tail / variance.all : 0.0;  // NaN stays NaN
            });
        add(rows, "variance_" + name, unit, "variance of the " + name + " over the cell",
            [first, count](const FieldMoment& moment) { return variance_of(moment, first, count).all; });
    };
    add_one("bead_density", "mm-4", form.bead_density, 1);
    add_one("rod_density", "mm-4", form.rod_density, 1);
    add_one("bead_velocity", "mm2 s-2", form.bead_velocity, 2);
    add_one("polar_order", form.order_is_density ? "mm-4" : "1", form.polar_order, 2);
}

void add_energy(const FieldSetting& setting, FieldRows& rows) {
    const std::string order = setting.form.order_is_density ? "mm-2" : "mm2";
    add(rows, "energy_order", order, "energy of the order: integral of |p|^2/2",
        [](const FieldMoment& moment) { return moment.energy->order; });
    add(rows, "power_order", order + " s-1", {term_axis(setting)}, "power of each term on the energy of the order",
        [](const FieldMoment& moment) { return moment.energy->order_powers; });
    if (setting.form.bead_velocity < 0) return;
    add(rows, "energy_flow", "mg mm2 s-2", "kinetic energy of the bead flow: integral of m rho v^2/2",
        [](const FieldMoment& moment) { return moment.energy->kinetic; });
    add(rows, "power_flow", "mg mm2 s-3", {term_axis(setting)},
        "power of each term on the kinetic energy of the bead flow",
        [](const FieldMoment& moment) { return moment.energy->kinetic_powers; });
}

}  // namespace

Observables<FieldMoment> field_observables(const FieldSetting& setting) {
    const physics::Form& form = setting.form;
    const bool has_rods = form.rod_density >= 0, has_beads = form.bead_density >= 0, has_order = form.polar_order >= 0,
               has_velocity = form.velocity != physics::Velocity::absent;
    FieldRows rows;
    add_shared(has_order, has_velocity, rows);
    if (has_rods && has_order) add_rods_and_order(setting, rows);
    if (has_order) add_field_order(setting, rows);
    if (has_velocity) add_velocity_spectrum(setting, rows);
    if (has_rods) add_density(setting, "rod", "sigma", form.rod_density, &ModePowers::rods, rows);
    if (has_beads) add_density(setting, "bead", "rho", form.bead_density, &ModePowers::beads, rows);
    if (has_rods && has_beads)
        add(rows, "structure_factor_beads_rods", "mm-2", {shell_axis(setting)},
            "cross structure factor of beads and rods: area Re(rho_q^* sigma_q), mean over a shell of |q|",
            by_shell(&ModePowers::beads_rods));
    add_tails(form, rows);
    if (setting.watches_error)
        add(rows, "step_error", "1",
            "estimated error of the time steps so far: the largest of any field, relative to its deviation from its "
            "mean over the cell and time; with noise on the same path, without the direction of the mean order",
            [](const FieldMoment& moment) { return moment.step_error; });
    if (setting.terms) add_energy(setting, rows);
    std::erase_if(rows, [](const auto& row) { return size_of(row.axes) == 0; });  // a grid too small for any shell
    return rows;
}

}  // namespace drover::measure
