// calibrate/field_model.cpp: coefficients of the equations from measured ones, with errors.
#include "drover/calibrate/field_model.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/closures.hpp"
#include "calibrate/redraw.hpp"
#include "drover/calibrate/alignment.hpp"

namespace drover::calibrate {

namespace {
const Closure& closure_of(const std::string& key) {
    const auto found = std::find_if(closures().begin(), closures().end(),
                                    [&](const Closure& one) { return !key.empty() && one.key == key; });
    require(found != closures().end(), {}, "{} is not a key that a table of coefficients provides", key);
    return *found;
}

/// For messages: the wanted number, and the scene key that can replace it.
struct Wanted {
    std::string what, give;
};

/// The interpolated rows of the table at a point; those `under` the wanted number are its divisors.
Measured measured_at(const Table& table, const std::vector<Input>& of, const std::vector<Input>& under,
                     const StatePoint& point, const Wanted& wanted) {
    Measured measured{.bead_fraction = point.bead_fraction, .rod_fraction = point.rod_fraction};
    for (const Input input : of) {
        if (may_be_absent(input) && find_row(table, row_name(input)) == nullptr) continue;
        const Uncertain found = SmoothCoefficient(table, row_name(input), point.varied, point.outside)
                                    .at(point.bead_fraction, point.rod_fraction);
        const bool divides = std::find(under.begin(), under.end(), input) != under.end();
        const std::string why = divides ? divisor_refusal(input, found.value, found.error) : "";
        require(why.empty(), {}, "{}: {}; expected a smaller error: run more trials, or set {} in the scene",
                wanted.what, why, wanted.give);
        put(measured, input, found.value, found.error);
    }
    return measured;
}

/// The one or two nodes of an axis around a position: the first, and one past the last.
std::pair<std::size_t, std::size_t> nodes_around(const std::vector<double>& axis, double position) {
    const auto above = std::lower_bound(axis.begin(), axis.end(), position) - axis.begin();
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
Origin origin_of(const Closure& closure, const Table& table, const Measured& measured, const StatePoint& point) {
    if (!closure.of.empty() && closure.value(measured) == 0.0) return Origin::set;
    bool all_set = !closure.of.empty(), any_short = false;
    for (const Input input : closure.of) {
        const TableRow* found = find_row(table, row_name(input));
        if (may_be_absent(input) && found == nullptr) continue;
        const TableRow& row = *found;
        all_set = all_set && row.entries.front().origin == Origin::set;
        any_short = any_short || is_short_around(table, row, point);
        if (input == response && measured[response] <= measured.errors[response]) return Origin::closure;
    }
    if (all_set) return Origin::set;
    return any_short && closure.origin == Origin::measured ? Origin::measured_short : closure.origin;
}

/// Half of the distance from 16 to 84 % of a formula over redrawn tables, in which c follows from the other rows.
class RedrawnInputs {
public:
    RedrawnInputs(const Table& table, const std::vector<Input>& of, const StatePoint& point, const Wanted& wanted) {
        constexpr int draws = 200;
        std::vector<std::string> rows;
        for (const Input input : of) rows.emplace_back(row_name(input));
        for (const Table& redrawn : redrawn_tables(table, rows, draws))
            drawn_.push_back(measured_at(redrawn, of, {}, point, wanted));
    }
    double error_of(const Formula& formula) const {
        std::vector<double> values;
        for (const Measured& one : drawn_) values.push_back(formula(one));
        const auto [low, middle, high] = quantiles_of(std::move(values));
        return 0.5 * (high - low);
    }

private:
    std::vector<Measured> drawn_;
};

/// Whether c follows from other rows anywhere.
bool derives_contact(const Table& table, std::size_t varied) {
    bool derives = false;
    for (std::size_t bead = 0; bead < table.bead_fractions.size(); ++bead)
        derives = derives || contact_slopes(table, varied, bead);
    return derives;
}

/// The closure of a key for p of this kind.
Closure closure_for(const std::string& key, OrderKind kind) {
    const Closure& closure = closure_of(key);
    if (kind == OrderKind::orientation) return closure;
    return scaled(closure, {rod_area}, [](const Measured& at) { return at.rod_density(); });
}

/// A number with the error of independent inputs.
Uncertain number_at(const Table& table, const std::string& key, const StatePoint& point, OrderKind kind) {
    const Closure closure = closure_for(key, kind);
    const Measured measured = measured_at(table, closure.of, closure.under, point, {.what = key, .give = key});
    return evaluated(measured, closure.of, closure.value);
}
}  // namespace

double power_of_density(const std::string& key) { return closure_of(key).order_power; }

const std::vector<std::string>& calibrated_keys() {
    static const std::vector<std::string> keys = [] {
        std::vector<std::string> names;
        for (const Closure& one : closures())
            if (!one.key.empty()) names.push_back(one.key);
        return names;
    }();
    return keys;
}

FieldNumber field_number(const Table& table, const std::string& key, const StatePoint& point, OrderKind kind) {
    const Closure closure = closure_for(key, kind);
    const Wanted wanted{.what = key, .give = key};
    const Measured measured = measured_at(table, closure.of, closure.under, point, wanted);
    FieldNumber result{.number = evaluated(measured, closure.of, closure.value),
                       .origin = origin_of(closure, table, measured, point)};
    const auto takes = [&](Input input) {
        return std::find(closure.of.begin(), closure.of.end(), input) != closure.of.end();
    };
    if (takes(contact) && takes(relaxation) && derives_contact(table, point.varied))
        result.number.error = RedrawnInputs(table, closure.of, point, wanted).error_of(closure.value);
    return result;
}

physics::TableData density_table(const Table& table, const StatePoint& point, OrderKind kind) {
    require(!table.rod_fractions.empty(), {}, "the table has no area fractions of rods; expected a table that has");
    physics::TableData data;
    const auto number = [&](const char* key, double beads, double rods) {
        StatePoint node = point;
        node.bead_fraction = beads;
        node.rod_fraction = rods;
        return number_at(table, key, node, kind);
    };
    const double beads = table.bead_fractions.front(), rods = table.rod_fractions.front();
    for (const double fraction : table.bead_fractions)
        data.bead_density.push_back(number("uniform.bead_density", fraction, rods).value);
    for (const double fraction : table.rod_fractions)
        data.rod_density.push_back(number("uniform.rod_density", beads, fraction).value);
    const auto add = [&](const std::string& key, const Uncertain& found) {
        data.columns[key].values.push_back(found.value);
        data.columns[key].errors.push_back(found.error);
    };
    for (const double bead : table.bead_fractions)
        for (const double rod : table.rod_fractions) {
            // A column replaces a and c: it is a - c sigma.
            const Uncertain a = number("relaxation.rate", bead, rod), c = number("relaxation.contact", bead, rod);
            const double sigma = number("uniform.rod_density", bead, rod).value;
            add("relaxation.rate", {.value = a.value - c.value * sigma, .error = std::hypot(a.error, c.error * sigma)});
            add("weathercock.strength", number("weathercock.strength", bead, rod));
            for (const char* key : {"relaxation.saturation", "drag.coefficient"})
                data.columns[key].values.push_back(number(key, bead, rod).value);
            // alpha/Gamma is measured as one: its error is with alpha.
            const Uncertain ratio = SmoothCoefficient(table, row_name(drag), point.varied).at(bead, rod);
            const double driving = number("driving.strength", bead, rod).value;
            add("driving.strength", {.value = driving, .error = std::abs(driving / ratio.value) * ratio.error});
        }
    data.outside = point.outside == physics::Outside::hold ? "hold" : "refuse";
    return data;
}

MeanField mean_field(const Table& table, const StatePoint& point) {
    const std::vector<Input> all{relaxation, weathercock, drag, cubic, response, contact, rod_area};
    const Wanted wanted{.what = "the order of the mean field", .give = "relaxation.rate"};
    const Measured measured = measured_at(table, all, {relaxation, rod_area}, point, wanted);
    // c follows from the others, and P has zero slope below g = 2 and an infinite one just above it.
    const RedrawnInputs redrawn(table, all, point, wanted);
    const auto of = [&](const Formula& formula) {
        return Uncertain{.value = formula(measured), .error = redrawn.error_of(formula)};
    };
    using M = const Measured&;
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
        SmoothCoefficient(table, row_name(rod_area), point.varied, point.outside).at(point.bead_fraction, 0.0).value;
    const int rods = static_cast<int>(std::lround(point.rod_fraction * cell_area / area));
    require(rods >= 2, {}, "a cell of {} mm^2 holds {} rods at the rod area fraction {}; expected at least 2",
            cell_area, rods, point.rod_fraction);
    const MeanField field = mean_field(table, point);
    const Uncertain g = field.alignment;
    const auto order_at = [&](double alignment) {
        return order_of_rods(rods, alignment, 0.0, field.alignment_cubic.value);
    };
    const RodsOrder order = order_at(g.value);
    return {.rods = rods,
            .alignment = g,
            .order = order.mean,
            .low = order_at(g.value - g.error).mean,
            .high = order_at(g.value + g.error).mean,
            .deviation = order.deviation,
            .line = order_at(2.0).mean};
}

}  // namespace drover::calibrate
