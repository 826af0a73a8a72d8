// measure/fields.cpp: bins, boxes and spectra from which the observables of fields are computed.
#include "measure/fields.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/base/text.hpp"
#include "measure/summary.hpp"
#include "model/start.hpp"

namespace drover::measure {

namespace {

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

void add_fields(const model::Equations& equations, const std::vector<model::StateComponent>& components,
                FieldSetting& setting) {
    int first = setting.of_state + setting.in_balance;
    for (const model::StateComponent& component : components) {
        if (component.part == 0) {
            const model::Field& field = equations.model().fields[component.field];
            setting.fields.push_back({field, model::short_name(field), model::counted_by(field),
                                      model::dataset_names(field), component.field, first});
        }
        ++first;
    }
}

std::vector<MeasuredEnergy> measured_energies(const model::Equations& equations) {
    std::vector<MeasuredEnergy> result;
    for (const model::Energy& energy : model::energies_of(equations)) {
        const model::Field& field = equations.model().fields[energy.fields[0]];
        const std::size_t part = energy.fields.size() == 1 ? 0 : std::string_view("_re").size();
        const std::string mass = field.mass.text.empty() ? "" : "(" + field.mass.text + ") ";
        result.push_back({.name = energy.name,
                          .unit = unit_product({field.observed.mass_unit, field.unit, field.unit, "mm2"}),
                          .of = words_of(field.name.substr(0, field.name.size() - part)),
                          .formula = text("{}|{}|^2/2", mass, field.symbol.substr(0, field.symbol.size() - part))});
    }
    return result;
}

/// Vectors of bodies, the flow by its unit.
void add_body_vectors(FieldSetting& setting) {
    for (const MeasuredField& one : setting.fields) {
        const std::string& density = one.observed.of;
        if (density.empty()) continue;
        BodyVector vector{.first = one.first};
        for (const MeasuredField& other : setting.fields)
            if (other.symbol == density) {
                vector.density = other.first;
                vector.is_sum = other.unit == one.unit;
            }
        (one.unit == "mm s-1" ? setting.flow : setting.order) = vector;
    }
}

/// Sum over all modes in shells, at each sample, of the structure factors of a field.
std::vector<double> total_power(const FieldSetting& setting, const std::vector<RecordedSeries>& series,
                                const MeasuredField& field) {
    const std::vector<double>& weight = setting.shells.weight;
    std::vector<double> total;
    for (const char* part : {"", "_along", "_across"}) {
        const RecordedSeries* recorded = find_row(series, "structure_factor_" + field.short_name + part);
        if (recorded == nullptr) continue;
        total.resize(recorded->values.size() / weight.size());
        for (std::size_t sample = 0; sample < total.size(); ++sample)
            for (std::size_t n = 0; n < weight.size(); ++n)
                total[sample] += weight[n] * recorded->values[sample * weight.size() + n];
    }
    return total;
}

}  // namespace

FieldSetting make_field_setting(const model::Equations& equations, const numerics::Grid& grid, int degree) {
    const int shorter = grid.ny == 1 ? grid.nx : std::min(grid.nx, grid.ny);
    FieldSetting setting{.grid = grid,
                         .shells = numerics::shells(grid, degree),
                         .sectors = numerics::sectors(grid, direction_sectors),
                         .boxes = numerics::box_ladder(shorter),
                         .long_boxes = numerics::box_ladder(shorter / 4),
                         .degree = degree,
                         .energies = measured_energies(equations)};
    if (setting.long_boxes.empty()) setting.long_boxes.push_back(1);  // the longer side is that of the cell
    bin_separations(setting);
    const auto state = model::components_of_state(equations), balanced = model::components_in_balance(equations);
    add_fields(equations, state, setting);
    setting.of_state = static_cast<int>(state.size());
    add_fields(equations, balanced, setting);
    setting.in_balance = static_cast<int>(balanced.size());
    std::ranges::stable_sort(setting.fields, {}, [](const MeasuredField& field) { return field.observed.drawn; });
    add_body_vectors(setting);
    return setting;
}

std::string name_of(const FieldSetting& setting, const std::optional<BodyVector>& vector) {
    for (const MeasuredField& field : setting.fields)
        if (vector && field.first == vector->first) return field.name;
    return "";
}

bool is_in_tail(const numerics::Grid& grid, int degree, std::size_t column, std::size_t row) {
    const double cut = 2.0 / 3.0 / (degree + 1);
    return static_cast<double>(column) > cut * grid.nx || std::abs(numerics::mode_number_y(grid, row)) > cut * grid.ny;
}

double tail_of(const numerics::Grid& grid, int degree, const numerics::Spectra& state, int first, int count) {
    const std::size_t width = numerics::columns(grid);
    double tail = 0.0, all = 0.0;
    for (int c = first; c < first + count; ++c)
        for (std::size_t m = 1; m < state.size; ++m) {
            const double power = numerics::mode_weight(grid, m % width) * std::norm(state[c][m]);
            all += power;
            if (is_in_tail(grid, degree, m % width, m / width)) tail += power;
        }
    return all > 0.0 ? tail / all : 0.0;
}

std::span<const BoxFamily> box_families() {
    static constexpr BoxFamily families[] = {
        {"", "box with equal numbers of cells along x and y", &FieldSetting::boxes, 1, 1},
        {"_long_x", "box with four times as many cells along x as along y", &FieldSetting::long_boxes, 4, 1},
        {"_long_y", "box with four times as many cells along y as along x", &FieldSetting::long_boxes, 1, 4}};
    return families;
}

std::string shape_of(const BoxFamily& family, const FieldSetting& setting) {
    if (setting.grid.ny == 1)
        return family.along_x > family.along_y   ? "segment of the line, four times as long as long_box_side"
               : family.along_x < family.along_y ? "segment of the line, as long as long_box_side"
                                                 : "segment of the line";
    if (family.along_x != family.along_y) return family.shape;
    return cell_width(setting) == cell_height(setting) ? "square box" : family.shape;
}

/// Whether a mean has forgotten its start, and does not wander, as that of a growing interface: then what is left after
/// its warm-up has more autocorrelation times than 99 of 100 random walks show.
static bool settles(std::span<const double> mean) {
    constexpr double times = 40.0;
    const std::span<const double> rest = mean.subspan(warm_up_length(mean));
    return times * autocorrelation_time(rest) <= static_cast<double>(rest.size());
}

Recorded field_recording(const FieldSetting& setting, std::vector<RecordedSeries> series) {
    Recorded recorded{.series = std::move(series), .area = numerics::area(setting.grid)};
    const auto values = [&](const std::string& name) { return values_of(recorded.series, name); };
    const auto points = static_cast<double>(numerics::points(setting.grid));
    recorded.indicators.push_back(values(name_of(setting, setting.order)));
    if (setting.order) recorded.orders.push_back(name_of(setting, setting.order));
    for (const MeasuredField& field : setting.fields)
        if (!setting.order && field.spin > 0) recorded.orders.push_back("size_mean_" + field.name);
    for (const MeasuredField& a : setting.fields)
        for (const MeasuredField& b : setting.fields)
            recorded.products.push_back(
                {.name = cross_name(a, b),
                 .squares = {"structure_factor_" + a.short_name, "structure_factor_" + b.short_name}});
    for (const MeasuredField& field : setting.fields) {
        if (field.first >= setting.of_state) continue;  // what is in balance follows the others
        if (field.short_name == field.name) {
            recorded.indicators.push_back(values("variance_" + field.name));
            recorded.indicators.push_back(values("size_mean_" + field.name));
            if (const std::vector<double> mean = values("mean_" + field.name); settles(mean))
                recorded.indicators.push_back(mean);
        } else if (!setting.flow || setting.flow->first != field.first) {  // which follows the order
            recorded.indicators.push_back(total_power(setting, recorded.series, field));
        }
        if (field.counted.empty()) continue;
        std::vector<double> total = values(total_name(field));
        if (total.empty())
            for (const double mean : values(statistic_name(field, "mean"))) total.push_back(mean * recorded.area);
        if (total.empty()) continue;
        for (const BoxFamily& family : box_families()) {
            BoxSizes boxes{field.counted, family.ending, shape_of(family, setting), total, {}};
            for (const int side : setting.*family.sides) {
                const numerics::BoxCells box = numerics::box_cells(setting.grid, side, family.along_x, family.along_y);
                boxes.fractions.push_back(static_cast<double>(box.x) * box.y / points);
            }
            recorded.boxes.push_back(std::move(boxes));
        }
    }
    return recorded;
}

}  // namespace drover::measure
