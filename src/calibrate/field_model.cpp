// calibrate/field_model.cpp: coefficients of the equations from measured ones, with errors; numbers of a table into a
// model, in the units and conventions of the model.
#include "calibrate/field_model.hpp"

#include <algorithm>
#include <cmath>

#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/alignment.hpp"
#include "calibrate/closures.hpp"
#include "calibrate/table.hpp"
#include "physics/model_keys.hpp"

namespace drover::calibrate {

namespace {
/// The rows of a table that closures need, interpolated.
class Interpolated {
public:
    Interpolated(const Table& table, const std::vector<Input>& of, const StatePoint& point) {
        for (const Input input : of)
            if (!may_be_absent(input) || find_row(table, name_of(input)) != nullptr)
                rows_.emplace_back(input, SmoothCoefficient(table, name_of(input), point.varied, point.outside));
    }
    ClosureNumbers at(double bead_fraction, double rod_fraction) const {
        ClosureNumbers measured{.bead_fraction = bead_fraction, .rod_fraction = rod_fraction};
        for (const auto& [input, row] : rows_) {
            const Uncertain found = row.at(bead_fraction, rod_fraction);
            put(measured, input, found.value, found.error);
        }
        return measured;
    }

private:
    std::vector<std::pair<Input, SmoothCoefficient>> rows_;
};

/// A wanted number needs its divisors to be significantly different from 0; `give`: the scene key that can replace it.
void check_divisors(const ClosureNumbers& measured, const std::vector<Input>& under, const std::string& what,
                    const std::string& give) {
    for (const Input input : under) {
        const std::string why = divisor_refusal(input, measured[input], measured.errors[input]);
        require(why.empty(), {}, "{}: {}; expected a smaller error: run more trials, or set {} in the scene", what, why,
                give);
    }
}

/// The one or two nodes of an axis around a position: the first, and one past the last.
std::pair<std::size_t, std::size_t> nodes_around(const std::vector<double>& axis, double position) {
    const auto above = std::ranges::lower_bound(axis, position) - axis.begin();
    const auto last = std::min<std::size_t>(static_cast<std::size_t>(above), axis.size() - 1);
    return {axis[last] > position && last > 0 ? last - 1 : last, last + 1};
}

/// Whether a row has a larger error than requested at a node around this point.
bool is_short_around(const Table& table, const TableRow& row, const StatePoint& point) {
    const auto beads = nodes_around(table.bead_fractions, point.bead_fraction);
    const auto rods =
        row.by_rods ? nodes_around(table.rod_fractions, point.rod_fraction) : std::pair<std::size_t, std::size_t>{0, 1};
    for (std::size_t bead = beads.first; bead < beads.second; ++bead)
        for (std::size_t rod = rods.first; rod < rods.second; ++rod)
            if (row.entries[entry_index(table, row, point.varied, bead, rod)].origin == Origin::measured_short)
                return true;
    return false;
}

/// Origin of a number, which its inputs may lower.
Origin origin_of(const Closure& closure, const Table& table, const ClosureNumbers& measured, const StatePoint& point) {
    if (!closure.of.empty() && closure.value(measured) == 0.0) return Origin::set;
    bool all_set = !closure.of.empty(), any_short = false;
    for (const Input input : closure.of) {
        const TableRow* found = find_row(table, name_of(input));
        if (may_be_absent(input) && found == nullptr) continue;
        const TableRow& row = *found;
        all_set = all_set && row.entries.front().origin == Origin::set;
        any_short = any_short || is_short_around(table, row, point);
        if (input == response && measured[response] <= measured.errors[response]) return Origin::closure;
    }
    if (all_set) return Origin::set;
    return any_short && closure.origin == Origin::measured ? Origin::measured_short : closure.origin;
}

/// Half of the distance from 16 to 84 % of formulas over redrawn tables, in which c follows from the other rows.
class DrawnInputs {
public:
    DrawnInputs(const Table& table, const std::vector<Input>& of, const StatePoint& point) {
        const auto rows = mapped(of, [](Input input) { return std::string(name_of(input)); });
        for (const Table& redrawn : redrawn_tables(table, rows, error_draws))
            drawn_.push_back(Interpolated(redrawn, of, point).at(point.bead_fraction, point.rod_fraction));
    }
    double error_of(const Formula& formula) const { return half_width(mapped(drawn_, formula)); }

private:
    std::vector<ClosureNumbers> drawn_;
};

/// The closures of these keys for p of this kind.
std::vector<Closure> closures_for(const std::vector<std::string>& keys, OrderKind kind) {
    return mapped(keys, [&](const std::string& key) {
        const auto found = std::ranges::find(closures(), key, &Closure::key);
        require(!key.empty() && found != closures().end(), {}, "{} is not a key that a table of coefficients provides",
                key);
        if (kind == OrderKind::orientation) return *found;
        return scaled(*found, {rod_area}, [](const ClosureNumbers& at) { return at.rod_density(); });
    });
}

/// The inputs of all these closures.
std::vector<Input> inputs_of(const std::vector<Closure>& closures) {
    std::vector<Input> inputs;
    for (const Closure& closure : closures)
        for (const Input input : closure.of)
            if (std::ranges::find(inputs, input) == inputs.end()) inputs.push_back(input);
    return inputs;
}

const std::vector<std::string> node_keys{"uniform.bead_density",  "uniform.rod_density",  "relaxation.rate",
                                         "relaxation.contact",    "weathercock.strength", "driving.strength",
                                         "relaxation.saturation", "drag.coefficient"};

constexpr const char* all_nodes = "table";

/// Nodes of an axis of a table for each of its intervals.  The measured coefficients are splines through the nodes of
/// the table; what is formed from them is none: alpha is a product, and alpha/Gamma a ratio.  With four nodes,
/// alpha/Gamma differs from that of a uniform state by (1/4)^4 of what it does with one, and by (1/4)^2 in the
/// outermost intervals, where natural splines are of that order.
constexpr int nodes_per_interval = 4;

std::vector<double> refined(const std::vector<double>& axis) {
    std::vector<double> positions;
    for (std::size_t i = 0; i + 1 < axis.size(); ++i)
        for (int k = 0; k < nodes_per_interval; ++k)
            positions.push_back(axis[i] + (axis[i + 1] - axis[i]) * k / nodes_per_interval);
    positions.push_back(axis.back());
    return positions;
}

std::string number_text(const Uncertain& number) {
    return number.error > 0.0 ? text("{:.4g} +- {:.2g}", number.value, number.error) : text("{:.4g}", number.value);
}

bool has_field(const std::string& key, const physics::ModelValues& model) {
    const auto& rows = model.file->coefficients;
    const auto row = std::ranges::find(rows, key, &physics::CoefficientRow::key);
    return row == rows.end() || physics::has_fields(model, row->needs);
}

OrderKind order_kind(const physics::ModelValues& model) {
    return physics::order_is_density(model) ? OrderKind::density : OrderKind::orientation;
}

/// The table has lambda; a scene may want lambda_s.
double lambda_factor(const physics::ModelValues& model, const std::string& key) {
    const bool single = key == "weathercock.strength" && word(model, "weathercock.convention") == "single-rod";
    return single ? single_rod_factor : 1.0;
}

std::vector<std::string> without_nodes(std::vector<std::string> keys) {
    std::erase(keys, all_nodes);
    return keys;
}

void fill_nodes(const Table& table, const StatePoint& point, physics::ModelValues& model) {
    model.table = density_table(table, point, order_kind(model));
    const std::string key = "weathercock.strength";
    for (double& number : model.table.columns[key].values) number *= lambda_factor(model, key);
}

/// But for the rounding of a scene in text.
bool is_close(double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); }

bool has_nodes_of(const Table& table, const StatePoint& point, const physics::ModelValues& model) {
    physics::ModelValues filled = model;
    fill_nodes(table, point, filled);
    for (const auto& [key, column] : filled.table.columns) {
        const std::vector<double>& values = model.table.column(key).values;
        if (!std::equal(values.begin(), values.end(), column.values.begin(), column.values.end(), is_close))
            return false;
    }
    return true;
}

void set_number(const std::string& key, const Uncertain& number, physics::ModelValues& model) {
    const physics::ModelKey* place = physics::find_key(key);
    require(place != nullptr, {}, "{} is not a number of the model", key);
    // A number of few trials may lie beyond zero, where the equations have no meaning.
    const Range& range = place->description.range;
    const bool low = range.min_open ? number.value <= range.min : number.value < range.min;
    require(!low && number.value <= range.max, {},
            "{} = {} from the table; expected {} {}: measure more, or set it in the scene", key, number_text(number),
            range.min_open ? ">" : ">=", range.min);
    place->set(model, number.value);
}

/// Throws an input Error where a divisor at a node is not significantly different from 0.
void check_nodes(const Table& table, const StatePoint& point, OrderKind kind) {
    const std::vector<Closure> wanted = closures_for(node_keys, kind);
    const Interpolated rows(table, inputs_of(wanted), point);
    for (const double bead : table.bead_fractions)
        for (const double rod : table.rod_fractions)
            for (std::size_t i = 0; i < wanted.size(); ++i)
                check_divisors(rows.at(bead, rod), wanted[i].under, node_keys[i], node_keys[i]);
}

/// Keys of a model that a table can fill in, in the order of a scene, such as "uniform.bead_density".
std::vector<std::string> calibrated_keys() {
    std::vector<std::string> keys;
    for (const Closure& one : closures())
        if (!one.key.empty()) keys.push_back(one.key);
    return keys;
}
}  // namespace

std::vector<double> field_values(const Table& table, const std::vector<std::string>& keys, const StatePoint& point,
                                 OrderKind kind) {
    const std::vector<Closure> wanted = closures_for(keys, kind);
    const ClosureNumbers measured =
        Interpolated(table, inputs_of(wanted), point).at(point.bead_fraction, point.rod_fraction);
    return mapped(wanted, [&](const Closure& closure) { return closure.value(measured); });
}

std::vector<FieldNumber> field_numbers(const Table& table, const std::vector<std::string>& keys,
                                       const StatePoint& point, OrderKind kind) {
    const std::vector<Closure> wanted = closures_for(keys, kind);
    const std::vector<Input> inputs = inputs_of(wanted);
    const ClosureNumbers measured = Interpolated(table, inputs, point).at(point.bead_fraction, point.rod_fraction);
    for (std::size_t i = 0; i < keys.size(); ++i) check_divisors(measured, wanted[i].under, keys[i], keys[i]);
    const DrawnInputs drawn(table, inputs, point);
    return mapped(wanted, [&](const Closure& closure) {
        return FieldNumber{.number = {.value = closure.value(measured), .error = drawn.error_of(closure.value)},
                           .origin = origin_of(closure, table, measured, point)};
    });
}

physics::TableData density_table(const Table& table, const StatePoint& point, OrderKind kind) {
    require(!table.rod_fractions.empty(), {}, "the table has no area fractions of rods; expected a table with them");
    const std::vector<Closure> wanted = closures_for(node_keys, kind);
    const Interpolated rows(table, inputs_of(wanted), point);
    const auto values_at = [&](double bead, double rod) {
        const ClosureNumbers measured = rows.at(bead, rod);
        return mapped(wanted, [&](const Closure& closure) { return closure.value(measured); });
    };
    physics::TableData data;
    const std::vector<double> beads = refined(table.bead_fractions), rods = refined(table.rod_fractions);
    for (const double bead : beads) data.nodes[0].push_back(values_at(bead, rods.front())[0]);
    for (const double rod : rods) data.nodes[1].push_back(values_at(beads.front(), rod)[1]);
    for (const double bead : beads)
        for (const double rod : rods) {
            std::vector<double> values = values_at(bead, rod);
            values[2] -= values[3] * values[1];  // a column replaces a and c: it is a - c sigma
            for (std::size_t i = 2; i < values.size(); ++i)
                if (node_keys[i] != "relaxation.contact") data.columns[node_keys[i]].values.push_back(values[i]);
        }
    data.outside = point.outside;
    return data;
}

MeanField mean_field(const Table& table, const StatePoint& point) {
    const std::vector<Input> all{relaxation, weathercock, drag, cubic, response, contact, rod_area};
    const ClosureNumbers measured = Interpolated(table, all, point).at(point.bead_fraction, point.rod_fraction);
    check_divisors(measured, {relaxation, rod_area}, "the order of the mean field", "relaxation.rate");
    const DrawnInputs redrawn(table, all, point);
    const auto of = [&](const Formula& formula) {
        return Uncertain{.value = formula(measured), .error = redrawn.error_of(formula)};
    };
    using M = const ClosureNumbers&;
    const auto order_of = [](M m) { return order_of_alignment(m.alignment(), m.alignment_cubic()); };
    return {.alignment = of([](M m) { return m.alignment(); }),
            .alignment_cubic = of([](M m) { return m.alignment_cubic(); }),
            .effective_relaxation = of([](M m) { return m[relaxation] * (1.0 - 0.5 * m.alignment()); }),
            .order = of(order_of),
            .bead_velocity = of([=](M m) {
                const double order = order_of(m);
                return (m[drag] + m[cubic] * order * order) * order;
            }),
            .response_time = {.value = measured[response], .error = measured.errors[response]}};
}

CellPrediction predict_cell(const Table& table, const StatePoint& point, double cell_area) {
    const double area =
        SmoothCoefficient(table, name_of(rod_area), point.varied, point.outside).at(point.bead_fraction, 0.0).value;
    const int rods = static_cast<int>(std::lround(point.rod_fraction * cell_area / area));
    require(rods >= 2, {}, "a cell of {} mm^2 holds {} rods at the rod area fraction {}; expected at least 2",
            cell_area, rods, point.rod_fraction);
    const MeanField field = mean_field(table, point);
    const Uncertain g = field.alignment;
    const auto order_at = [&](double alignment) { return order_of_rods(rods, alignment, field.alignment_cubic.value); };
    const RodsOrder order = order_at(g.value);
    return {.rods = rods,
            .alignment = g,
            .order = order.mean,
            .low = order_at(g.value - g.error).mean,
            .high = order_at(g.value + g.error).mean,
            .deviation = order.deviation,
            .line = order_at(2.0).mean};
}

std::vector<std::string> missing_keys(const physics::ModelValues& model, bool local,
                                      const std::function<bool(const std::string& key)>& is_given) {
    std::vector<std::string> missing;
    for (const std::string& key : calibrated_keys())
        // With local coefficients c is in the table of the rate.
        if (!is_given(key) && has_field(key, model) && !(local && key == "relaxation.contact")) missing.push_back(key);
    if (local && !model.table.has_values()) missing.emplace_back(all_nodes);
    return missing;
}

std::vector<FilledNumber> fill_model(const Table& table, const StatePoint& point, const std::vector<std::string>& keys,
                                     physics::ModelValues& model) {
    const std::vector<std::string> numbers = without_nodes(keys);
    const std::vector<FieldNumber> found = field_numbers(table, numbers, point, order_kind(model));
    std::vector<FilledNumber> filled;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const double factor = lambda_factor(model, numbers[i]);
        const Uncertain number{.value = factor * found[i].number.value, .error = factor * found[i].number.error};
        set_number(numbers[i], number, model);
        filled.push_back({numbers[i], text("{}, {}", found[i].origin, number_text(number))});
    }
    if (numbers.size() < keys.size()) {
        check_nodes(table, point, order_kind(model));
        fill_nodes(table, point, model);
        filled.push_back({all_nodes, "at the nodes of the table"});
    }
    return filled;
}

std::vector<physics::ModelValues> redrawn_models(const Table& table, const StatePoint& point,
                                                 const std::vector<std::string>& keys,
                                                 const physics::ModelValues& model, int count) {
    std::vector<std::string> numbers = without_nodes(keys);
    // A resolved scene may have been changed since: numbers that are not those of the table have no error from it.
    const auto is_of_table = [&](const std::string& key) {
        const double value = field_values(table, {key}, point, order_kind(model)).front() * lambda_factor(model, key);
        const physics::ModelKey* place = physics::find_key(key);
        if (place == nullptr) return false;
        const Value held = place->get(model);
        const auto* number = std::get_if<double>(&held);
        return number != nullptr && is_close(*number, value);
    };
    std::erase_if(numbers, [&](const std::string& key) { return !is_of_table(key); });
    const bool has_nodes = std::ranges::find(keys, all_nodes) != keys.end() && has_nodes_of(table, point, model);
    std::vector<physics::ModelValues> models;
    for (const Table& redrawn : redrawn_tables(table, all_names<Input>(), count)) try {
            physics::ModelValues one = model;
            const std::vector<double> values = field_values(redrawn, numbers, point, order_kind(model));
            for (std::size_t i = 0; i < numbers.size(); ++i)
                set_number(numbers[i], {.value = lambda_factor(model, numbers[i]) * values[i]}, one);
            if (has_nodes) fill_nodes(redrawn, point, one);
            models.push_back(std::move(one));
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;
        }
    return models;
}

std::vector<std::string> expected_texts(const Table& table, const StatePoint& point) {
    const MeanField field = mean_field(table, point);
    std::vector<std::string> texts{"alignment = " + number_text(field.alignment),
                                   "effective_relaxation = " + number_text(field.effective_relaxation) + " 1/s",
                                   "order = " + number_text(field.order),
                                   "bead_velocity = " + number_text(field.bead_velocity) + " mm/s",
                                   "response_time = " + number_text(field.response_time) + " s"};
    if (field.alignment_cubic.value != 0.0)
        texts.insert(texts.begin() + 1, "alignment_cubic = " + number_text(field.alignment_cubic));
    return texts;
}

}  // namespace drover::calibrate
