// files/installed_models.cpp: from the place of the code to the folder of the models.
#include "files/installed_models.hpp"

#include <dlfcn.h>

namespace drover::files {

std::filesystem::path installed_models() {
    namespace fs = std::filesystem;
    Dl_info here{};
    if (dladdr(reinterpret_cast<const void*>(&installed_models), &here) == 0 || here.dli_fname == nullptr) return {};
    std::error_code none;
    fs::path program = fs::read_symlink("/proc/self/exe", none);
    const fs::path object = fs::weakly_canonical(here.dli_fname, none);
    if (fs::exists(object, none)) program = object;  // of a program it may be the name by which it was called
    constexpr int levels = 5;                        // a Python module is four folders below the prefix
    fs::path folder = program.parent_path();
    for (int level = 0; level < levels; ++level, folder = folder.parent_path()) {
        const fs::path installed = folder / "share" / "drover" / "models";
        if (fs::is_directory(installed, none)) return installed;
        if (fs::exists(folder / "src" / "physics" / "rod_bead.toml", none)) return folder / "models";
    }
    return {};
}

}  // namespace drover::files
