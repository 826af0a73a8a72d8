// measure/fields.cpp: bins, boxes and spectra from which the observables of fields are computed.
#include "drover/measure/fields.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/base/text.hpp"
#include "measure/field_axes.hpp"
#include "measure/shared_rows.hpp"

namespace drover::measure {

namespace {

using numerics::Complex;

double cell_width(const FieldSetting& setting) { return setting.grid.lx / setting.grid.nx; }
double cell_height(const FieldSetting& setting) { return setting.grid.ly / setting.grid.ny; }

/// Bins displacements on the grid by length, a cell wide, up to half the shorter side; r = 0 always has a bin.
void bin_separations(FieldSetting& setting) {
    const numerics::Grid& grid = setting.grid;
    const bool one_row = grid.ny == 1;  // then only displacements along x
    const double dx = cell_width(setting), dy = cell_height(setting), width = one_row ? dx : std::max(dx, dy);
    const double side = one_row ? grid.lx : std::min(grid.lx, grid.ly);
    const auto bins = std::max<std::size_t>(1, static_cast<std::size_t>(0.5 * side / width));
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

/// |component along q|^2 and |component across q|^2 of a vector, mode by mode.
void split_powers(const FieldSetting& setting, std::span<const Complex> x, std::span<const Complex> y,
                  std::vector<double>& along, std::vector<double>& across,
                  const std::function<void(std::size_t, Complex)>& see_along) {
    along.resize(x.size());
    across.resize(x.size());
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(setting.grid.ny); ++j)
        for (std::size_t i = 0; i < numerics::columns(setting.grid); ++i, ++mode) {
            const numerics::Wavevector q = numerics::wavevector(setting.grid, i, j);
            const double size = std::sqrt(q.x * q.x + q.y * q.y);
            const double cosine = size > 0.0 ? q.x / size : 1.0, sine = size > 0.0 ? q.y / size : 0.0;
            const Complex component = cosine * x[mode] + sine * y[mode];
            along[mode] = std::norm(component);
            across[mode] = std::norm(cosine * y[mode] - sine * x[mode]);
            if (see_along) see_along(mode, component);
        }
}

/// Shorter sides of long boxes; on the smallest grids the longer side is that of the cell.
std::vector<int> long_ladder(int n) {
    std::vector<int> sides = numerics::box_ladder(n / 4);
    if (sides.empty()) sides.push_back(1);
    return sides;
}

/// Sum over all modes in shells, at each sample, of the observables named: the total power.
std::vector<double> total_power(const FieldSetting& setting, const std::vector<RecordedSeries>& series,
                                const std::vector<std::string>& names) {
    const std::vector<double>& weight = setting.shells.weight;
    std::vector<double> total;
    for (const std::string& name : names) {
        const RecordedSeries* recorded = find_row(series, name);
        if (recorded == nullptr) continue;
        total.resize(recorded->values.size() / weight.size());
        for (std::size_t sample = 0; sample < total.size(); ++sample)
            for (std::size_t n = 0; n < weight.size(); ++n)
                total[sample] += weight[n] * recorded->values[sample * weight.size() + n];
    }
    return total;
}

}  // namespace

FieldSetting make_field_setting(const numerics::Grid& grid, const physics::Form& form, int degree,
                                std::optional<std::vector<std::string>> power_terms) {
    const int shorter = grid.ny == 1 ? grid.nx : std::min(grid.nx, grid.ny);
    FieldSetting setting{.grid = grid,
                         .form = form,
                         .shells = numerics::shells(grid, degree),
                         .sectors = numerics::sectors(grid, direction_sectors),
                         .boxes = numerics::box_ladder(shorter),
                         .long_boxes = long_ladder(shorter),
                         .degree = degree,
                         .separations = {},
                         .separation_bin = {},
                         .terms = std::move(power_terms)};
    bin_separations(setting);
    return setting;
}

bool is_in_tail(const numerics::Grid& grid, int degree, std::size_t column, std::size_t row) {
    const double cut = 2.0 / 3.0 / (degree + 1);
    return static_cast<double>(column) > cut * grid.nx || std::abs(numerics::mode_number_y(grid, row)) > cut * grid.ny;
}

ModePowers mode_powers(const FieldSetting& setting, const numerics::Spectra& spectra,
                       const numerics::Spectra* velocity) {
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

std::span<const BoxFamily> box_families() {
    static constexpr BoxFamily families[] = {{"", "square box", &FieldSetting::boxes, 1, 1},
                                             {"_long_x", "box four times longer along x", &FieldSetting::long_boxes, 4,
                                              1},
                                             {"_long_y", "box four times longer along y", &FieldSetting::long_boxes, 1,
                                              4}};
    return families;
}

Axis shell_axis(const FieldSetting& setting) {
    return {"wavenumber", "mm-1", "mean |q| of the shell", setting.shells.q};
}

Axis sector_axis(const FieldSetting& setting) {
    Axis axis{"direction", "degree", "angle of q from x; q and -q are equivalent", {}};
    for (int s = 0; s < setting.sectors.count; ++s) axis.values.push_back(180.0 / setting.sectors.count * s);
    return axis;
}

Axis separation_axis(const FieldSetting& setting) {
    return {"separation", "mm", "mean distance in the bin", setting.separations};
}

Axis term_axis(const FieldSetting& setting) {
    Axis axis{"term", "1", "number of the term: 0, 1, ... for " + joined(*setting.terms), {}};
    for (std::size_t i = 0; i < setting.terms->size(); ++i) axis.values.push_back(static_cast<double>(i));
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
    Axis axis{"long_box_side", "mm", "shorter side, in cells as wide as along x, of a box with the aspect ratio 4", {}};
    for (const int cells : setting.*family.sides) axis.values.push_back(cell_width(setting) * cells);
    return axis;
}

Recorded field_recording(const FieldSetting& setting, std::vector<RecordedSeries> series) {
    Recorded recorded{.series = std::move(series), .area = numerics::area(setting.grid)};
    const auto points = static_cast<double>(numerics::points(setting.grid));
    for (const BoxFamily& family : box_families())
        for (const char* what : {"rod", "bead"}) {
            const RecordedSeries* total = find_row(recorded.series, text("{}s_total", what));
            if (total == nullptr) continue;
            BoxSizes boxes{what, family.ending, family.shape, total->values.empty() ? 0.0 : total->values.front(), {}};
            for (const int side : setting.*family.sides) {
                const numerics::BoxCells box = numerics::box_cells(setting.grid, side, family.along_x, family.along_y);
                boxes.fractions.push_back(static_cast<double>(box.x) * box.y / points);
            }
            recorded.boxes.push_back(std::move(boxes));
        }
    for (const std::vector<std::string>& names : {std::vector<std::string>{"structure_factor_rods"},
                                                  {"structure_factor_beads"},
                                                  {"structure_factor_order_along", "structure_factor_order_across"}})
        recorded.indicators.push_back(total_power(setting, recorded.series, names));
    if (const RecordedSeries* order = find_row(recorded.series, "polar_order"))
        recorded.indicators.push_back(order->values);
    return recorded;
}

}  // namespace drover::measure
