// calibrate/fill_model.cpp: numbers of a table into a model, in the units and conventions of the model.
#include "drover/calibrate/fill_model.hpp"

#include <algorithm>

#include "drover/physics/coefficient_registry.hpp"

namespace drover::calibrate {

namespace {
constexpr const char* all_nodes = "table";

std::string number_text(const Uncertain& number) {
    return number.error > 0.0 ? text("{:.4g} +- {:.2g}", number.value, number.error) : text("{:.4g}", number.value);
}

/// The number of a model under a key; nullptr where it has none.
const physics::ModelKey* find_key(const std::vector<physics::ModelSection>& sections, const std::string& key) {
    for (const physics::ModelSection& section : sections)
        for (const physics::ModelKey& one : section.keys)
            if (section.name + "." + one.description.name == key) return &one;
    return nullptr;
}

bool has_field(const std::string& key, const physics::FieldChoice& fields) {
    const auto& rows = physics::coefficient_registry();
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& one) { return one.key() == key; });
    return row == rows.end() || physics::has_fields(fields, row->needs);
}

/// A number of few trials may lie beyond zero, where the equations have no meaning.
void check_range(const Range& range, const std::string& key, const Uncertain& found) {
    const bool low = range.min_open ? found.value <= range.min : found.value < range.min;
    require(!low && found.value <= range.max, {},
            "{} = {} from the table; expected {} {}: measure more, or set it in the scene", key, number_text(found),
            range.min_open ? ">" : ">=", range.min);
}

void scale(double factor, physics::TableColumn& column) {
    for (std::vector<double>* numbers : {&column.values, &column.errors})
        for (double& number : *numbers) number *= factor;
}
}  // namespace

std::vector<std::string> missing_keys(const physics::Model& model, bool local,
                                      const std::function<bool(const std::string& key)>& is_given) {
    std::vector<std::string> missing;
    for (const std::string& key : calibrated_keys())
        // With local coefficients c is in the table of the rate.
        if (!is_given(key) && has_field(key, model.fields) && !(local && key == "relaxation.contact"))
            missing.push_back(key);
    if (local && !model.table.has_values()) missing.emplace_back(all_nodes);
    return missing;
}

FilledModel fill_model(const Table& table, const StatePoint& point, const std::vector<std::string>& keys,
                       physics::Model& model) {
    const OrderKind kind = physics::form(model).order_is_density ? OrderKind::density : OrderKind::orientation;
    // The table has lambda; a scene may want lambda_s.
    const double lambda_factor = model.weathercock.convention == "single-rod" ? physics::single_rod_factor : 1.0;
    const std::vector<physics::ModelSection> sections = physics::model_sections();
    FilledModel result;
    for (const std::string& key : keys) {
        if (key == all_nodes) {
            model.table = density_table(table, point, kind);
            scale(lambda_factor, model.table.columns["weathercock.strength"]);
            result.filled.push_back(std::string(all_nodes) + ": at the nodes of the table");
            continue;
        }
        FieldNumber found = field_number(table, key, point, kind);
        if (key == "weathercock.strength") {
            found.number.value *= lambda_factor;
            found.number.error *= lambda_factor;
        }
        const physics::ModelKey* place = find_key(sections, key);
        require(place != nullptr, {}, "{} is not a number of the model", key);
        check_range(place->description.range, key, found.number);
        place->set(model, found.number.value);
        result.filled.push_back(key + ": " + origin_name(found.origin) + ", " + number_text(found.number));
    }
    return result;
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
