// files/archive_h5md.cpp: trajectories in H5MD 1.1: elements of step, time and value, a box, /h5md (de Buyl, Colberg &
// Höfling, Comput. Phys. Commun. 185, 1546 (2014)).
#include <algorithm>
#include <cstdlib>

#include "base/mapped.hpp"
#include "drover/base/version.hpp"
#include "files/archive_netcdf.hpp"

namespace drover::files {
namespace {

constexpr std::array<std::int64_t, 2> h5md_version{1, 1};

/// Creates a group with its missing parents: "/a" and "/a/b" of "/a/b/c".
Handle make_path(hid_t file, const std::string& path, const Hdf5Errors& errors) {
    for (std::size_t slash = path.find('/', 1); slash != std::string::npos; slash = path.find('/', slash + 1))
        group_handle(file, path.substr(0, slash), true, errors);
    return group_handle(file, path, true, errors);
}

std::string author() {
    for (const char* variable : {"USER", "LOGNAME"})
        if (const char* name = std::getenv(variable); name != nullptr && *name != '\0') return name;
    return "unknown";
}

void make_head(hid_t file, const Hdf5Errors& errors) {
    if (errors.check(H5Lexists(file, "/h5md", H5P_DEFAULT), "looking up /h5md") > 0) return;
    const Handle head = make_path(file, "/h5md", errors);
    write_list(head, "version", h5md_version, errors);
    const Handle by = make_path(file, "/h5md/author", errors), with = make_path(file, "/h5md/creator", errors);
    write_attribute(by, {"name", author()}, errors);
    write_attribute(with, {"name", std::string("drover")}, errors);
    write_attribute(with, {"version", version().version}, errors);
}

void write_fixed(hid_t group, const FixedArray& array, const Hdf5Errors& errors) {
    std::vector<std::size_t> shape{array.values.size() / array.components};
    if (array.components > 1) shape.push_back(array.components);
    const Handle dataset = make_dataset(group, array.name, extent_of(shape, 0), array.is_integer, errors);
    errors.check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()),
                 text("writing {}", array.name));
    write_description(dataset, array.name, array.unit, array.meaning, errors);
}

void make_box(hid_t file, const Recording& recording, const Hdf5Errors& errors) {
    const Handle box = make_path(file, path_in(recording.group, "box"), errors);
    write_attribute(box, {"dimension", std::int64_t{3}}, errors);
    const auto word = [](bool periodic) { return std::string(periodic ? "periodic" : "none"); };
    write_list(box, "boundary", mapped(recording.trajectory->periodic, word), errors);
}

void link(hid_t file, const std::string& from, const std::string& to, const Hdf5Errors& errors) {
    errors.check(H5Lcreate_hard(file, from.c_str(), file, to.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                 text("linking {}", to));
}

}  // namespace

GroupDatasets make_trajectory(hid_t file, const Recording& recording, const Hdf5Errors& errors) {
    make_head(file, errors);
    const Handle group = make_path(file, recording.group, errors);
    if (recording.trajectory->has_box) make_box(file, recording, errors);
    GroupDatasets created;
    const auto rows = static_cast<std::size_t>(recording.rows_per_chunk);
    const std::string first = path_in(recording.group, recording.quantities.front().name);
    for (const Quantity& quantity : recording.quantities) {
        const std::string path = path_in(recording.group, quantity.name);
        const Handle element = make_path(file, path, errors);
        if (path == first) {
            const Extent extent = extent_of({}, std::max(time_rows_per_chunk, rows));
            created.time = make_dataset(element, "time", extent, false, errors);
            write_description(created.time, "time", "s", "time since the start of the run", errors);
            created.step = make_dataset(element, "step", extent, true, errors);
            write_description(created.step, "step", "1", "steps since the start of the run", errors);
        } else {
            for (const char* shared : {"/time", "/step"}) link(file, first + shared, path + shared, errors);
        }
        created.quantities.push_back(make_dataset(element, "value", extent_of(shape_of(recording, quantity), rows),
                                                  quantity.is_integer, errors));
        write_description(created.quantities.back(), quantity.name, quantity.unit, quantity.meaning, errors);
    }
    for (const FixedArray& array : recording.trajectory->fixed) write_fixed(group, array, errors);
    return created;
}

}  // namespace drover::files
