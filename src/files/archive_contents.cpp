// files/archive_contents.cpp: walks the objects of an HDF5 file by hard links alone; reads attributes and axes.
#include "files/archive_contents.hpp"

#include <algorithm>

#include "base/mapped.hpp"

namespace drover::files {

bool leads_to(hid_t file, const std::string& path, H5O_type_t type, const Hdf5Errors& errors) {
    if (path.size() < 2 || path[0] != '/') return false;
    for (std::size_t slash = 0; slash != std::string::npos;) {
        slash = path.find('/', slash + 1);
        const std::string step = path.substr(0, slash);
        H5L_info_t link;
        if (errors.check(H5Lexists(file, step.c_str(), H5P_DEFAULT), text("looking up {}", step)) == 0) return false;
        errors.check(H5Lget_info(file, step.c_str(), &link, H5P_DEFAULT), text("inspecting {}", step));
        require(link.type == H5L_TYPE_HARD, {errors.file},
                "{} is a soft or external link; expected the data itself: links are not followed", step);
        H5O_info_t object;
        errors.check(H5Oget_info_by_name2(file, step.c_str(), &object, H5O_INFO_BASIC, H5P_DEFAULT),
                     text("inspecting {}", step));
        if (object.type != (slash == std::string::npos ? type : H5O_TYPE_GROUP)) return false;
    }
    return true;
}

std::optional<Attribute> read_attribute(hid_t object, const std::string& name, std::uint64_t file_bytes,
                                        const Hdf5Errors& errors) {
    const std::string doing = text("reading attribute {}", name);
    const Handle attribute = errors.own(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "opening " + name);
    const Handle type = errors.own(H5Aget_type(attribute), H5Tclose, doing);
    const Handle space = errors.own(H5Aget_space(attribute), H5Sclose, doing);
    if (H5Sget_simple_extent_npoints(space) != 1) return std::nullopt;
    const H5T_class_t kind = H5Tget_class(type);
    if (kind == H5T_INTEGER) {
        std::int64_t value = 0;
        errors.check(H5Aread(attribute, H5T_NATIVE_INT64, &value), doing);
        return Attribute{name, value};
    }
    if (kind == H5T_FLOAT) {
        double value = 0.0;
        errors.check(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), doing);
        return Attribute{name, value};
    }
    if (kind != H5T_STRING) return std::nullopt;
    if (H5Tis_variable_str(type) > 0) {  // by other programs
        char* words = nullptr;
        errors.check(H5Aread(attribute, type, &words), doing);
        Attribute found{name, std::string(words == nullptr ? "" : words)};
        H5free_memory(words);
        return found;
    }
    const std::size_t size = H5Tget_size(type);
    require(size <= file_bytes, {errors.file}, "attribute {} claims {}, more than the file contains; it is damaged",
            name, bytes_text(static_cast<double>(size)));
    std::string value(size, '\0');
    errors.check(H5Aread(attribute, type, value.data()), doing);
    if (H5Tget_strpad(type) == H5T_STR_NULLTERM) value.resize(std::min(value.size(), value.find('\0')));
    value.resize(value.find_last_not_of('\0') + 1);
    return Attribute{name, value};
}

std::vector<Attribute> attributes_of(hid_t object, std::uint64_t file_bytes, const Hdf5Errors& errors) {
    std::vector<Attribute> found;
    for (const std::string& name : attribute_names(object, errors))
        if (auto read = read_attribute(object, name, file_bytes, errors)) found.push_back(std::move(*read));
    return found;
}

namespace {
constexpr std::size_t max_objects = 5000, max_path = 1000;  // hard links may form a cycle

struct Names {
    std::vector<std::pair<std::int64_t, std::string>> found;  ///< with the order of their creation, if the file has it
    std::size_t left = max_objects;
};

/// The names in a group, in the order of their creation or of the alphabet.  HDF5 1.10 sorts names in a table, which it
/// frees before it is filled if a read fails; so they are sorted here.
std::vector<std::string> names_in(hid_t file, const std::string& group, std::size_t left, const Hdf5Errors& errors) {
    Names names{.left = left};
    const auto add = [](hid_t, const char* name, const H5L_info_t* link, void* to) -> herr_t {
        auto& all = *static_cast<Names*>(to);
        if (all.left-- == 0) return 1;
        all.found.emplace_back(link->corder_valid ? link->corder : 0, name);
        return 0;
    };
    const herr_t is_cut = errors.check(H5Literate_by_name(file, group.c_str(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
                                                          add, &names, H5P_DEFAULT),
                                       "listing " + group);
    require(is_cut == 0 && group.size() <= max_path, {errors.file},
            "has more than {} objects; expected at most that many: drover wrote fewer", max_objects);
    std::ranges::sort(names.found);
    return mapped(names.found, &std::pair<std::int64_t, std::string>::second);
}

void add_objects(hid_t file, const std::string& group, Objects& to, const Hdf5Errors& errors) {
    for (const std::string& name : names_in(file, group, max_objects - to.datasets.size() - to.groups.size(), errors)) {
        const std::string path = group + name;
        if (leads_to(file, path, H5O_TYPE_DATASET, errors)) {
            to.datasets.push_back(path);
        } else if (leads_to(file, path, H5O_TYPE_GROUP, errors)) {
            to.groups.push_back(path);
            add_objects(file, path + "/", to, errors);
        }
    }
}

std::string last_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

bool is_axis(hid_t dataset, std::uint64_t file_bytes, const Hdf5Errors& errors) {
    if (H5Aexists(dataset, "CLASS") <= 0) return false;
    const auto found = read_attribute(dataset, "CLASS", file_bytes, errors);
    const auto* words = found ? std::get_if<std::string>(&found->second) : nullptr;
    return words != nullptr && *words == "DIMENSION_SCALE";
}
}  // namespace

Objects objects_of(hid_t file, const Hdf5Errors& errors) {
    Objects objects;
    add_objects(file, "/", objects, errors);
    return objects;
}

NamesOfReferences names_of_references(hid_t file, const std::vector<std::string>& datasets, const Hdf5Errors& errors) {
    NamesOfReferences names;
    for (const std::string& path : datasets) {
        hobj_ref_t reference{};
        errors.check(H5Rcreate(&reference, file, path.c_str(), H5R_OBJECT, -1), "reading the axes of " + path);
        names.emplace(reference, last_name(path));
    }
    return names;
}

std::vector<std::string> axes_of(hid_t dataset, const std::string& path, std::size_t rank, std::uint64_t file_bytes,
                                 const NamesOfReferences& datasets, const Hdf5Errors& errors) {
    if (rank == 1 && is_axis(dataset, file_bytes, errors)) return {last_name(path)};
    if (H5Aexists(dataset, "DIMENSION_LIST") <= 0) return {};
    const std::string doing = "reading the axes of " + path;
    const Handle attribute = errors.own(H5Aopen(dataset, "DIMENSION_LIST", H5P_DEFAULT), H5Aclose, doing);
    const Handle stored = errors.own(H5Aget_type(attribute), H5Tclose, doing);
    const Handle space = errors.own(H5Aget_space(attribute), H5Sclose, doing);
    const Handle type = errors.own(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose, doing);
    if (H5Tequal(stored, type) <= 0 || H5Sget_simple_extent_npoints(space) != static_cast<hssize_t>(rank)) return {};
    std::vector<hvl_t> lists(rank);
    errors.check(H5Aread(attribute, type, lists.data()), doing);
    std::vector<std::string> names;
    for (const hvl_t& list : lists) {
        const auto found = list.len == 1 ? datasets.find(*static_cast<const hobj_ref_t*>(list.p)) : datasets.end();
        if (found != datasets.end()) names.push_back(found->second);
    }
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, lists.data());
    if (names.size() != rank) return {};
    return names;
}

}  // namespace drover::files
