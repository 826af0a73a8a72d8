// files/archive_root.cpp: writes and replaces the root attributes of archives.
#include "files/archive_root.hpp"

#include <set>

#include "files/archive_netcdf.hpp"

namespace drover::files {

namespace {

constexpr const char* conventions = "CF-1.8";

/// All but the run id and those of these names.
void remove_other_root_attributes(hid_t file, const std::vector<Attribute>& kept, const Hdf5Errors& errors) {
    H5O_info_t about;
    errors.check(H5Oget_info2(file, &about, H5O_INFO_NUM_ATTRS), "counting attributes");
    std::set<std::string> names{"Conventions", run_id_name}, others;
    for (const Attribute& attribute : kept) names.insert(attribute.first);
    for (hsize_t i = 0; i < about.num_attrs; ++i) {
        const Handle one =
            errors.own(H5Aopen_by_idx(file, "/", H5_INDEX_NAME, H5_ITER_INC, i, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                       "listing attributes");
        const auto name_into = [&](char* to, std::size_t size) {
            return static_cast<std::size_t>(errors.check(H5Aget_name(one, size, to), "listing attributes"));
        };
        std::string name(name_into(nullptr, 0), '\0');
        name_into(name.data(), name.size() + 1);
        if (!names.contains(name)) others.insert(std::move(name));
    }
    for (const std::string& name : others) errors.check(H5Adelete(file, name.c_str()), "removing an attribute");
}

}  // namespace

void write_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors) {
    const Handle root = errors.own(H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose, "opening the root group");
    const auto write = [&](const Attribute& attribute) {
        const char* name = attribute.first.c_str();
        if (errors.check(H5Aexists(root, name), "looking up an attribute") > 0)
            errors.check(H5Adelete(root, name), "removing an attribute");
        write_attribute(root, attribute, errors);
    };
    write({"Conventions", std::string(conventions)});
    for (const Attribute& attribute : attributes) write(attribute);
}

void replace_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors) {
    remove_other_root_attributes(file, attributes, errors);
    write_root_attributes(file, attributes, errors);
}

}  // namespace drover::files
