// io/scene_text.cpp: scenes from their text and the files that it names: a model, a table of coefficients.
#include <dlfcn.h>

#include <algorithm>
#include <iterator>

#include "base/mapped.hpp"
#include "files/archive_reader.hpp"
#include "files/input_file.hpp"
#include "io/calibration.hpp"
#include "io/scene.hpp"
#include "io/scene_parts.hpp"
#include "physics/program_functions.hpp"

namespace drover::io {

namespace {
constexpr std::uint64_t max_scene_bytes = 1 << 20;

/// The folder share/drover/models below the prefix of this program or module, or models of the source tree in which it
/// was built; empty: neither is there.
std::filesystem::path installed_models() {
    namespace fs = std::filesystem;
    Dl_info here{};
    if (dladdr(reinterpret_cast<const void*>(&installed_models), &here) == 0 || here.dli_fname == nullptr) return {};
    std::error_code none;
    fs::path code = here.dli_fname;  // of a program it may be the name by which it was called
    if (code.is_relative()) code = fs::read_symlink("/proc/self/exe", none);
    constexpr int levels = 5;  // a Python module is four folders below the prefix
    fs::path folder = fs::weakly_canonical(code, none).parent_path();
    for (int level = 0; level < levels; ++level, folder = folder.parent_path()) {
        const fs::path installed = folder / "share" / "drover" / "models";
        if (fs::is_directory(installed, none)) return installed;
        if (fs::exists(folder / "src" / "physics" / "rod_bead.toml", none)) return folder / "models";
    }
    return {};
}

/// The file that model.file names: in the folder of the scene, else among the installed models.
std::filesystem::path place_of_model(const std::string& file, const std::string& scene) {
    const std::filesystem::path beside = std::filesystem::path(scene).parent_path() / file;
    std::error_code none;
    if (std::filesystem::exists(beside, none)) return beside;
    const std::filesystem::path installed = installed_models();
    return !installed.empty() && std::filesystem::exists(installed / file, none) ? installed / file : beside;
}

/// The model that a scene names.  Of a whole scene, with a grid, it is the model alone.
LocatedTables model_file(const LocatedValue& named, const std::string& scene) {
    const auto* file = std::get_if<std::string>(&named.value);
    require(file != nullptr, named.where, "model.file = {}; expected the name of a file in quotes",
            toml_text(named.value));
    const std::filesystem::path path = place_of_model(*file, scene);
    std::string content;
    try {
        content = files::read_text(path, "a model: [[field]], [equations], [define], [coefficients]", max_scene_bytes);
    } catch (const Error& error) {
        const std::filesystem::path installed = installed_models();
        throw Error(error.fault(), named.where,
                    text("model.file: {}{}", error.what(),
                         installed.empty() ? "" : "; nor is it among the installed models, " + installed.string()));
    }
    LocatedTables tables = read_tables(content, path.string());
    if (tables.contains("grid"))
        std::erase_if(tables, [](const auto& table) { return !is_declared_table(table.first); });
    for (const auto& [name, table] : tables) {
        require(is_declared_table(name), table.where,
                "[{}] in a model that a scene names; expected [model], [[field]], [[white_noise]], [[tabulated]], "
                "[equations], [define] and [coefficients] alone",
                name);
        require(name != "model" || !table.values.contains("file"), table.where,
                "model.file in a model that a scene names; expected the model itself");
    }
    return tables;
}

/// Takes the fields and equations of the file that model.file names, in the folder of the scene.  The fields of the
/// scene follow those of the file; of all else what the scene has counts.  The resolved scene has all of it.
void include_model(LocatedTables& tables, const std::string& scene) {
    const auto model = tables.find("model");
    if (model == tables.end()) return;
    const auto named = model->second.values.find("file");
    if (named == model->second.values.end()) return;
    const LocatedValue found = named->second;
    model->second.values.erase(named);
    if (found.value == Value{std::string{}}) return;
    LocatedTables whole = model_file(found, scene);
    for (auto& [name, table] : tables) {
        if (is_in_declared_list(name)) continue;
        for (auto& [key, value] : table.values) whole[name].values.insert_or_assign(key, std::move(value));
        whole[name].where = table.where;
    }
    for (const char* list : declared_lists) {
        std::size_t before = 0;
        while (whole.contains(text("{}[{}]", list, before + 1))) ++before;
        for (std::size_t n = 1; tables.contains(text("{}[{}]", list, n)); ++n)
            whole.emplace(text("{}[{}]", list, before + n), std::move(tables.at(text("{}[{}]", list, n))));
    }
    tables = std::move(whole);
}

bool is_given(const Scene& scene, const std::string& key) { return scene.places.contains(key); }

/// With one of the numbers of the mean field from the scene it is not that of the table.
bool has_mean_field_of_table(const Scene& scene, const std::vector<std::string>& missing) {
    for (const char* key : {"relaxation.rate", "weathercock.strength", "drag.coefficient", "driving.strength"})
        if (std::ranges::find(missing, key) == missing.end()) return false;
    return !is_given(scene, "relaxation.contact");
}

calibrate::StatePoint point_of(const Scene& scene, const calibrate::Table& table) {
    const CalibratedPlan& plan = scene.calibrated;
    // A resolved scene holds the key, also where there is nothing to choose from.
    const bool absent = plan.varied == 0.0 && (table.varied_key.empty() || !is_given(scene, "calibrated.varied"));
    return {.bead_fraction = plan.bead_area_fraction,
            .rod_fraction = plan.rod_area_fraction,
            .varied = calibrate::varied_index(table, absent ? std::nullopt : std::optional(plan.varied),
                                              "calibrated.varied", locate(scene, "calibrated.varied")),
            .outside = plan.outside};
}

/// use(table, point) of a scene.  A table is a file of its own; what it has not, this scene asked for.
template <class Use>
auto with_table(const Scene& scene, Use use) try {
    const calibrate::Table table = read_calibration(beside(scene.file, scene.calibrated.table));
    return use(table, point_of(scene, table));
} catch (const Error& error) {
    throw Error(error.fault(), locate(scene, "calibrated.table"), error.what());
}

/// Gives the model those numbers of the table that the scene does not give itself, and notes them in Scene::found.
/// A scene that gives all of them, such as a resolved one, needs no file.  Throws an input Error at its place for a
/// table or a state that will not do.
void fill_from_table(Scene& scene) {
    CalibratedPlan& plan = scene.calibrated;
    if (plan.table.empty()) return;
    for (const auto& [key, fraction] : {std::pair{"calibrated.bead_area_fraction", plan.bead_area_fraction},
                                        std::pair{"calibrated.rod_area_fraction", plan.rod_area_fraction}})
        require(fraction > 0.0, locate(scene, key),
                "{} is not given; expected the area fraction of the scene, within those of {}", key, plan.table);
    const std::vector<std::string> missing =
        calibrate::missing_keys(scene.model, plan.coefficients == CoefficientsOf::local,
                                [&](const std::string& key) { return is_given(scene, key); });
    if (missing.empty()) return;
    with_table(scene, [&](const calibrate::Table& table, const calibrate::StatePoint& point) {
        std::ranges::move(calibrate::fill_model(table, point, missing, scene.model),
                          std::back_inserter(scene.found.filled));
        if (has_mean_field_of_table(scene, missing)) scene.found.expected = calibrate::expected_texts(table, point);
    });
}

/// needs_functions: a scene whose terms are functions that this program does not have is an error.
Scene scene_in(const std::string& toml, const std::string& name, std::span<const std::string> overrides,
               const physics::TermFunctions& functions, bool needs_functions) {
    LocatedTables tables = read_tables(toml, name);
    include_model(tables, name);
    Scene scene = scene_of(std::move(tables), name, overrides);
    for (const auto& [number, function] : functions) {
        require(number >= 1 && number <= scene.model.text_terms.size(), {.file = name},
                "a function for terms[{}], and the scene has {} terms; expected one of these", number,
                scene.model.text_terms.size());
        scene.model.text_terms[number - 1].call = function;
    }
    fill_from_table(scene);
    if (needs_functions || physics::missing_function(scene.model).empty()) check(scene);
    return scene;
}
}  // namespace

Scene parse_scene(const std::string& toml, const std::string& name, std::span<const std::string> overrides,
                  const physics::TermFunctions& functions) {
    return scene_in(toml, name, overrides, functions, true);
}

Scene changed(const Scene& scene, const std::vector<std::string>& overrides) {
    Scene result = scene_of(tables_of(scene), scene.file, overrides);
    for (std::size_t n = 0; n < scene.model.text_terms.size(); ++n)  // tables have no functions
        result.model.text_terms[n].call = scene.model.text_terms[n].call;
    fill_from_table(result);
    check(result);
    return result;
}

Scene archived_scene(const std::string& toml, const std::string& name) { return scene_in(toml, name, {}, {}, false); }

Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides) {
    require(!files::is_hdf5(file), {.file = file.string()},
            "an archive (HDF5); expected a scene (input file in TOML): drover restart continues a run, and drover info "
            "--scene prints its scene");
    const std::string content =
        files::read_text(file, "a scene (input file in TOML), such as models/isotropic.toml", max_scene_bytes);
    return parse_scene(content, file.string(), overrides);
}

bool is_from_table(const Scene& scene, const std::string& key) {
    return std::ranges::find(scene.found.filled, key, &calibrate::FilledNumber::key) != scene.found.filled.end();
}

std::vector<physics::ModelValues> drawn_models(const Scene& scene, int count) {
    if (scene.found.filled.empty())
        return std::vector<physics::ModelValues>(static_cast<std::size_t>(count), scene.model);
    require(
        std::filesystem::exists(beside(scene.file, scene.calibrated.table)), locate(scene, "calibrated.table"),
        "no file {}; expected the table of the calibrated numbers, from which their errors are drawn: put it there, "
        "or leave the errors out by boundary.draws = 0",
        scene.calibrated.table);
    const auto keys = mapped(scene.found.filled, &calibrate::FilledNumber::key);
    return with_table(scene, [&](const calibrate::Table& table, const calibrate::StatePoint& point) {
        return calibrate::redrawn_models(table, point, keys, scene.model, count);
    });
}

Rows<CalibratedPlan> CalibratedPlan::rows() {
    using Plan = CalibratedPlan;
    return Rows<CalibratedPlan>{
        {"table", &Plan::table,
         "a file that drover calibrate made, beside the scene or where drover runs: it gives the numbers of the "
         "model that the scene leaves out"},
        {"bead_area_fraction", &Plan::bead_area_fraction, "Phi_b of the scene", "", within(0.0, 0.95)},
        {"rod_area_fraction", &Plan::rod_area_fraction, "Phi_r of the scene", "", within(0.0, 0.95)},
        {"varied", &Plan::varied,
         "the value of the key that the table varies, one of its own; of a table that has such a key"},
        {"coefficients", &Plan::coefficients,
         "uniform: those of these area fractions everywhere; local: a, b, Gamma, alpha and lambda follow "
         "the densities of each place, and a boundary has error bands"},
        {"outside", &Plan::outside, "densities beyond the table: refuse, or hold the value of its edge"},
    };
}

}  // namespace drover::io
