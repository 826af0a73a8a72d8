// calibrate/fill_model.cpp: numbers of a table into a model, in the units and conventions of the model.
#include "calibrate/fill_model.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/closures.hpp"
#include "calibrate/redraw.hpp"
#include "physics/model_keys.hpp"

namespace drover::calibrate {

namespace {
constexpr const char* all_nodes = "table";

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
}  // namespace

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
