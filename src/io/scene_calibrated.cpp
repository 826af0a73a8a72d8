// io/scene_calibrated.cpp: numbers of a table into a model.
#include "io/scene_calibrated.hpp"

#include <algorithm>

#include "drover/calibrate/field_model.hpp"
#include "drover/io/calibration.hpp"

namespace drover::io {

namespace {
constexpr const char* local_section = "table";

bool gives(const Scene& scene, const std::string& key) { return scene.places.contains(key); }

bool gives_nodes(const physics::TableData& table) {
    return !table.relaxation_rate.empty() || !table.relaxation_saturation.empty() || !table.drag_coefficient.empty() ||
           !table.driving_strength.empty() || !table.weathercock_strength.empty();
}

/// Whether a number of the table has a field to act on.
bool has_field(const std::string& key, const physics::FieldChoice& fields) {
    const bool velocity = fields.bead_velocity != "absent";
    for (const char* section : {"drag.", "driving.", "viscosity.", "weathercock.", "stiffness."})
        if (key.starts_with(section) && !velocity) return false;
    if (key == "stiffness.beads" || key == "pressure.beads") return fields.bead_density;
    if (key == "stiffness.rods" || key == "pressure.rods" || key == "current.speed") return fields.rod_density;
    return true;
}

/// Keys that the table is to give.
std::vector<std::string> wanted_keys(const Scene& scene) {
    std::vector<std::string> wanted;
    for (const std::string& key : calibrate::calibrated_keys())
        if (!gives(scene, key) && has_field(key, scene.model.fields)) wanted.push_back(key);
    if (scene.calibrated.coefficients == "local" && !gives_nodes(scene.model.table)) wanted.emplace_back(local_section);
    return wanted;
}

std::size_t varied_of(const Scene& scene, const calibrate::Table& table) {
    const double varied = scene.calibrated.varied;
    // A resolved scene holds the key, also where there is nothing to choose from.
    const bool absent = varied == 0.0 && (table.varied_key.empty() || !gives(scene, "calibrated.varied"));
    return calibrate::varied_index(table, absent ? std::nullopt : std::optional(varied), "calibrated.varied",
                                   location_of(scene, "calibrated.varied"));
}

std::string number_text(const calibrate::Uncertain& number) {
    return number.error > 0.0 ? text("{:.4g} +- {:.2g}", number.value, number.error) : text("{:.4g}", number.value);
}

std::vector<std::string> expected_texts(const calibrate::Table& table, const calibrate::StatePoint& point) {
    const calibrate::MeanField field = calibrate::mean_field(table, point);
    return {"alignment = " + number_text(field.alignment),
            "effective_relaxation = " + number_text(field.effective_relaxation) + " 1/s",
            "order = " + number_text(field.order), "bead_velocity = " + number_text(field.bead_velocity) + " mm/s",
            "response_time = " + number_text(field.response_time) + " s"};
}

/// Beside the scene, or else where drover runs.
std::filesystem::path table_file(const Scene& scene) {
    const std::filesystem::path beside = std::filesystem::path(scene.file).parent_path() / scene.calibrated.table;
    std::error_code problem;
    return std::filesystem::exists(beside, problem) ? beside : std::filesystem::path(scene.calibrated.table);
}

/// What the equations can have; a number of few trials may come out on the other side of zero.
void check_range(const ModelNumber& number, const std::string& key, const calibrate::Uncertain& found) {
    const bool low = number.range.min_open ? found.value <= number.range.min : found.value < number.range.min;
    require(!low && found.value <= number.range.max, {},
            "{} comes out as {}; expected {} {}: measure more, or give it in the scene", key, number_text(found),
            number.range.min_open ? ">" : ">=", number.range.min);
}

/// Numbers that the mean field is made of: with one of them from the scene it is not that of the table.
bool expects(const Scene& scene) {
    for (const char* key : {"relaxation.rate", "weathercock.strength", "drag.coefficient", "driving.strength"})
        if (gives(scene, key) || !has_field(key, scene.model.fields)) return false;
    return true;
}

void fill(Scene& scene, const std::vector<std::string>& wanted) {
    CalibratedPlan& plan = scene.calibrated;
    const calibrate::Table table = read_calibration(table_file(scene));
    const calibrate::StatePoint point{.bead_fraction = plan.bead_area_fraction,
                                      .rod_fraction = plan.rod_area_fraction,
                                      .varied = varied_of(scene, table),
                                      .outside =
                                          plan.outside == "hold" ? physics::Outside::hold : physics::Outside::refuse};
    const auto kind =
        physics::form(scene.model).order_is_density ? calibrate::OrderKind::density : calibrate::OrderKind::orientation;
    // lambda_s = 2 lambda, of a scene that says so.
    const double lambdas = scene.model.weathercock.convention == "single-rod" ? 2.0 : 1.0;
    for (const std::string& key : wanted) {
        if (key == local_section) {
            scene.model.table = calibrate::density_table(table, point, kind);
            for (auto* numbers :
                 {&scene.model.table.weathercock_strength, &scene.model.table.weathercock_strength_error})
                for (double& number : *numbers) number *= lambdas;
            plan.filled.push_back(std::string(local_section) + ": at the nodes of the table");
            continue;
        }
        calibrate::FieldNumber found = calibrate::field_number(table, key, point, kind);
        if (key == "weathercock.strength") found.number.value *= lambdas, found.number.error *= lambdas;
        const ModelNumber number = model_number(key, {});
        check_range(number, key, found.number);
        number.in(scene.model) = found.number.value;
        plan.filled.push_back(key + ": " + calibrate::origin_name(found.origin) + ", " + number_text(found.number));
    }
    if (expects(scene)) plan.expected = expected_texts(table, point);
}
}  // namespace

std::string filled_name(const std::string& line) { return line.substr(0, line.find(':')); }

bool is_from_table(const Scene& scene, const std::string& key) {
    const auto& filled = scene.calibrated.filled;
    return std::any_of(filled.begin(), filled.end(), [&](const std::string& line) { return filled_name(line) == key; });
}

void fill_from_table(Scene& scene) {
    CalibratedPlan& plan = scene.calibrated;
    if (plan.table.empty()) return;
    for (const auto& [key, fraction] : {std::pair{"calibrated.bead_area_fraction", plan.bead_area_fraction},
                                        std::pair{"calibrated.rod_area_fraction", plan.rod_area_fraction}})
        require(fraction > 0.0, location_of(scene, key),
                "{} is not given; expected the area fraction of the scene, within those of {}", key, plan.table);
    const std::vector<std::string> wanted = wanted_keys(scene);
    if (wanted.empty()) return;
    try {
        fill(scene, wanted);
    } catch (const Error& error) {
        // A table is a file of its own; what it has not, this scene asked for.
        fail_input(location_of(scene, "calibrated.table"), "{}", error.what());
    }
}

}  // namespace drover::io

namespace drover {

template <>
const std::vector<Row<io::CalibratedPlan>>& schema<io::CalibratedPlan>() {
    using Plan = io::CalibratedPlan;
    static const std::vector<Row<Plan>> rows{
        {.name = "table",
         .member = &Plan::table,
         .doc = "a file that drover calibrate made, beside the scene or where drover runs: it gives the numbers of the "
                "model that the scene leaves out"},
        {.name = "bead_area_fraction",
         .member = &Plan::bead_area_fraction,
         .range = {.min = 0.0, .max = 0.95},
         .doc = "Phi_b of the scene"},
        {.name = "rod_area_fraction",
         .member = &Plan::rod_area_fraction,
         .range = {.min = 0.0, .max = 0.95},
         .doc = "Phi_r of the scene"},
        {.name = "varied",
         .member = &Plan::varied,
         .doc = "the value of the key that the table varies, one of its own; of a table that has such a key"},
        {.name = "coefficients",
         .member = &Plan::coefficients,
         .choices = {"uniform", "local"},
         .doc = "uniform: those of these area fractions everywhere; local: a, b, Gamma, alpha and lambda follow "
                "the densities of each place, and a boundary has error bands"},
        {.name = "outside",
         .member = &Plan::outside,
         .choices = {"refuse", "hold"},
         .doc = "densities beyond the table: refuse, or hold the value of its edge"},
        {.name = "filled",
         .member = &Plan::filled,
         .doc = "written by drover: what came from the table, its origin and its error; leave it out"},
        {.name = "expected",
         .member = &Plan::expected,
         .doc = "written by drover: what the mean field of the table expects; leave it out"}};
    return rows;
}

}  // namespace drover
