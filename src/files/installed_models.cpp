// files/installed_models.cpp: from the place of the code to the folder of the models.
#include "files/installed_models.hpp"

#include <dlfcn.h>

namespace drover::files {

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

}  // namespace drover::files
