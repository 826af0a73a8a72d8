// io/scene_text.cpp: scenes from their text and the files that it names: a model, a table of coefficients.
#include "io/scene_text.hpp"

#include <dlfcn.h>

#include <algorithm>

#include "files/archive_reader.hpp"
#include "files/input_file.hpp"
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

}  // namespace drover::io
