// files/archive_netcdf.cpp: dimension scales, CF attributes, chunks and filters; trajectories in H5MD 1.1: elements of
// step, time and value, a box, /h5md (de Buyl, Colberg & Höfling, Comput. Phys. Commun. 185, 1546 (2014)).
#include "files/archive_netcdf.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <set>

#include "base/mapped.hpp"
#include "drover/base/version.hpp"

namespace drover::files {

namespace {
constexpr std::size_t max_chunk_bytes = std::numeric_limits<std::uint32_t>::max();  // HDF5 counts them in 32 bits
constexpr unsigned deflate_level = 1;  // higher levels gain almost nothing on shuffled noise and take twice the time
constexpr unsigned in_order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;

Handle text_type(std::size_t size, H5T_str_t padding, H5T_cset_t letters, const Hdf5Errors& errors) {
    Handle type = errors.own(H5Tcopy(H5T_C_S1), H5Tclose, "creating a string type");
    errors.check(H5Tset_size(type, std::max<std::size_t>(size, 1)), "sizing a string type");
    errors.check(H5Tset_strpad(type, padding), "padding a string type");
    errors.check(H5Tset_cset(type, letters), "choosing the character set of a string type");
    return type;
}

Handle line_space(hsize_t count, const Hdf5Errors& errors) {
    return errors.own(H5Screate_simple(1, &count, nullptr), H5Sclose, "creating a dataspace");
}

void write_raw(hid_t object, const char* name, hid_t type, hid_t space, const void* value, const Hdf5Errors& errors) {
    const std::string doing = text("writing attribute {}", name);
    const Handle attribute =
        errors.own(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, doing);
    errors.check(H5Awrite(attribute, type, value), doing);
}

void write_text(hid_t object, const char* name, const std::string& value, H5T_str_t padding, const Hdf5Errors& errors) {
    const bool is_ascii = std::ranges::all_of(value, [](char c) { return static_cast<unsigned char>(c) < 128; });
    const std::size_t size = value.size() + (padding == H5T_STR_NULLTERM ? 1 : 0);
    const Handle type = text_type(size, padding, is_ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8, errors);
    const Handle space = errors.own(H5Screate(H5S_SCALAR), H5Sclose, "creating a dataspace");
    write_raw(object, name, type, space, value.c_str(), errors);
}

/// The two attributes that mark a scale; the HDF5 dimension scale specification (3.1) requires null-terminated strings.
void mark_as_scale(hid_t dataset, const std::string& name, const Hdf5Errors& errors) {
    write_text(dataset, "CLASS", "DIMENSION_SCALE", H5T_STR_NULLTERM, errors);
    write_text(dataset, "NAME", name, H5T_STR_NULLTERM, errors);
}

/// An entry of REFERENCE_LIST: the dataset that uses a scale, and for which of its axes.
struct ScaleUse {
    hobj_ref_t dataset = 0;
    int axis = 0;
    int padding = 0;  // H5DS leaves it uninitialised; a zero makes the file reproducible
};

hobj_ref_t reference_to(hid_t group, const std::string& name, const Hdf5Errors& errors) {
    hobj_ref_t reference{};
    errors.check(H5Rcreate(&reference, group, name.c_str(), H5R_OBJECT, -1), text("referencing {}", name));
    return reference;
}

void write_uses(hid_t scale, const std::vector<ScaleUse>& uses, const Hdf5Errors& errors) {
    if (uses.empty()) return;
    const Handle type = errors.own(H5Tcreate(H5T_COMPOUND, sizeof(ScaleUse)), H5Tclose, "creating a type");
    errors.check(H5Tinsert(type, "dataset", HOFFSET(ScaleUse, dataset), H5T_STD_REF_OBJ), "creating a type");
    errors.check(H5Tinsert(type, "dimension", HOFFSET(ScaleUse, axis), H5T_NATIVE_INT), "creating a type");
    const Handle space = line_space(uses.size(), errors);
    write_raw(scale, "REFERENCE_LIST", type, space, uses.data(), errors);
}

void write_axes_of(hid_t dataset, std::vector<hobj_ref_t> scales, const Hdf5Errors& errors) {
    const auto lists = mapped(scales, [](hobj_ref_t& scale) { return hvl_t{1, &scale}; });
    const Handle type = errors.own(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose, "creating a type");
    const Handle space = line_space(lists.size(), errors);
    write_raw(dataset, "DIMENSION_LIST", type, space, lists.data(), errors);
}

/// Links the quantities of a group to its scales, in both directions.
void attach_scales(hid_t group, const Recording& recording, const std::vector<Handle>& datasets,
                   const Hdf5Errors& errors) {
    std::vector<std::string> names;
    if (recording.rows_per_chunk > 0) names.emplace_back("time");
    for (const Axis& axis : recording.axes) names.push_back(axis.name);
    const auto references = mapped(names, [&](const auto& name) { return reference_to(group, name, errors); });
    std::vector<std::vector<ScaleUse>> uses(names.size());
    for (std::size_t k = 0; k < recording.quantities.size(); ++k) {
        const Quantity& quantity = recording.quantities[k];
        std::vector<std::string> axes = quantity.axes;
        if (recording.rows_per_chunk > 0) axes.insert(axes.begin(), "time");
        if (axes.empty()) continue;
        const hobj_ref_t itself = reference_to(group, quantity.name, errors);
        std::vector<hobj_ref_t> scales;
        for (std::size_t i = 0; i < axes.size(); ++i) {
            const auto scale = static_cast<std::size_t>(std::ranges::find(names, axes[i]) - names.begin());
            uses[scale].push_back({.dataset = itself, .axis = static_cast<int>(i)});
            scales.push_back(references[scale]);
        }
        write_axes_of(datasets[k], scales, errors);
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        const Handle scale =
            errors.own(H5Dopen2(group, names[i].c_str(), H5P_DEFAULT), H5Dclose, text("opening {}", names[i]));
        write_uses(scale, uses[i], errors);
    }
}

/// A cache of one chunk, so that each chunk is compressed once per commit instead of once per row.
Handle dataset_access(std::size_t chunk_bytes, const Hdf5Errors& errors) {
    constexpr std::size_t min_bytes = 1 << 16, slots = 5;
    Handle access = errors.own(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose, "creating a dataset access list");
    errors.check(H5Pset_chunk_cache(access, slots, std::max(min_bytes, chunk_bytes), 1.0), "sizing a chunk cache");
    return access;
}

/// Attributes: units; long_name, the name in words, for labels; comment, the meaning in full.
void write_description(hid_t dataset, const std::string& name, const std::string& unit, const std::string& meaning,
                       const Hdf5Errors& errors) {
    write_text(dataset, "units", unit, H5T_STR_NULLPAD, errors);
    write_text(dataset, "long_name", words_of(name), H5T_STR_NULLPAD, errors);
    write_text(dataset, "comment", meaning, H5T_STR_NULLPAD, errors);
}

void make_axis(hid_t group, const Axis& axis, const Hdf5Errors& errors) {
    const Handle dataset = make_dataset(group, axis.name, extent_of({axis.values.size()}, 0), false, errors);
    errors.check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, axis.values.data()),
                 text("writing axis {}", axis.name));
    write_description(dataset, axis.name, axis.unit, axis.meaning, errors);
    // Without the attribute `axis`, with which VTK and ParaView take x and y for longitude and latitude, on a sphere.
    mark_as_scale(dataset, axis.name, errors);
}

/// The unit is "s", or as the scene calls it: xarray converts "seconds since ..." and "seconds" to dates and durations.
Handle make_time(hid_t group, const Recording& recording, const Hdf5Errors& errors) {
    const std::size_t rows = std::max(time_rows_per_chunk, static_cast<std::size_t>(recording.rows_per_chunk));
    Handle dataset = make_dataset(group, "time", extent_of({}, rows), false, errors);
    write_description(dataset, "time", recording.time_unit, "time since the start of the run", errors);
    write_text(dataset, "axis", "T", H5T_STR_NULLPAD, errors);
    mark_as_scale(dataset, "time", errors);
    return dataset;
}

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

/// Creates the groups and datasets of a trajectory, and /h5md if it does not exist.
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
}  // namespace

Extent extent_of(const std::vector<std::size_t>& shape, std::size_t rows_per_chunk) {
    Extent extent;
    if (rows_per_chunk > 0) extent = {{0}, {H5S_UNLIMITED}, {rows_per_chunk}};
    for (const std::size_t size : shape)
        for (std::vector<hsize_t>* sizes : {&extent.now, &extent.max, &extent.chunk}) sizes->push_back(size);
    return extent;
}

bool is_compact(const Extent& extent) {
    constexpr std::size_t max_bytes = 1 << 14;  // bytes: a header has 64 KB, for attributes too
    return extent.max == extent.now && bytes_of(extent.now) <= max_bytes;
}

Handle make_dataset(hid_t group, const std::string& name, const Extent& extent, bool is_integer,
                    const Hdf5Errors& errors) {
    const std::string doing = text("creating dataset {}", name);
    const Handle creation = creation_list(H5P_DATASET_CREATE, errors);
    const int rank = static_cast<int>(extent.now.size());
    if (is_compact(extent)) {
        errors.check(H5Pset_layout(creation, H5D_COMPACT), doing);
    } else if (rank > 0) {
        errors.check(H5Pset_chunk(creation, rank, extent.chunk.data()), doing);
        errors.check(H5Pset_shuffle(creation), doing);
        errors.check(H5Pset_deflate(creation, deflate_level), doing);
        errors.check(H5Pset_fletcher32(creation), doing);
    }
    const hid_t created =
        rank > 0 ? H5Screate_simple(rank, extent.now.data(), extent.max.data()) : H5Screate(H5S_SCALAR);
    const Handle space = errors.own(created, H5Sclose, doing);
    const Handle access = dataset_access(static_cast<std::size_t>(bytes_of(extent.chunk)), errors);
    return errors.own(H5Dcreate2(group, name.c_str(), is_integer ? H5T_STD_I64LE : H5T_IEEE_F64LE, space, H5P_DEFAULT,
                                 creation, access),
                      H5Dclose, doing);
}

Handle group_handle(hid_t file, const std::string& group, bool is_new, const Hdf5Errors& errors) {
    const std::string doing = text("{} group {}", is_new ? "creating" : "opening", group);
    const bool is_there = group == "/" || H5Lexists(file, group.c_str(), H5P_DEFAULT) > 0;
    if (!is_new || is_there) return errors.own(H5Gopen2(file, group.c_str(), H5P_DEFAULT), H5Gclose, doing);
    const Handle creation = creation_list(H5P_GROUP_CREATE, errors);
    return errors.own(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose, doing);
}

std::string path_in(const std::string& group, const std::string& name) {
    return group == "/" ? "/" + name : group + "/" + name;
}

std::string time_path(const Recording& recording) {
    return recording.trajectory ? path_in(recording.group, recording.quantities.front().name + "/time")
                                : path_in(recording.group, "time");
}

std::string value_path(const Recording& recording, const Quantity& quantity) {
    return path_in(recording.group, recording.trajectory ? quantity.name + "/value" : quantity.name);
}

void check(const Recording& recording, const std::string& file) {
    const SourceLocation where{file};
    std::set<std::string> names{"time"};
    const auto add_name = [&](const std::string& name) {
        require(names.insert(name).second, where, "group {} has two datasets named {}; expected each name once",
                recording.group, name);
    };
    if (recording.trajectory)
        for (const FixedArray& array : recording.trajectory->fixed) add_name(array.name);
    for (const Axis& axis : recording.axes) add_name(axis.name);
    for (const Quantity& quantity : recording.quantities) {
        add_name(quantity.name);
        const std::size_t rows = static_cast<std::size_t>(std::max(recording.rows_per_chunk, 1));
        require(count_of(recording, quantity) <= max_chunk_bytes / sizeof(double) / rows, where,
                "{} rows of {} are more than the {} of a chunk; expected fewer rows in a chunk or a smaller grid", rows,
                path_in(recording.group, quantity.name), bytes_text(static_cast<double>(max_chunk_bytes)));
    }
}

std::vector<std::size_t> shape_of(const std::vector<Axis>& axes, const Quantity& quantity) {
    std::vector<std::size_t> shape;
    for (const std::string& name : quantity.axes)
        for (const Axis& axis : axes)
            if (axis.name == name) shape.push_back(axis.values.size());
    return shape;
}

std::size_t count_of(const Recording& recording, const Quantity& quantity) {
    std::size_t count = 1;
    for (const std::size_t size : shape_of(recording, quantity)) count *= size;
    return count;
}

GroupDatasets make_group(hid_t file, const Recording& recording, const Hdf5Errors& errors) {
    if (recording.trajectory) return make_trajectory(file, recording, errors);
    const Handle group = group_handle(file, recording.group, true, errors);
    GroupDatasets created;
    const bool has_time = recording.rows_per_chunk > 0;
    if (has_time) created.time = make_time(group, recording, errors);
    for (const Axis& axis : recording.axes) make_axis(group, axis, errors);
    for (const Quantity& quantity : recording.quantities) {
        const Extent extent =
            extent_of(shape_of(recording, quantity), static_cast<std::size_t>(recording.rows_per_chunk));
        created.quantities.push_back(make_dataset(group, quantity.name, extent, quantity.is_integer, errors));
        write_description(created.quantities.back(), quantity.name, quantity.unit, quantity.meaning, errors);
    }
    attach_scales(group, recording, created.quantities, errors);
    return created;
}

GroupDatasets open_group(hid_t file, const Recording& recording, const Hdf5Errors& errors) {
    const auto open = [&](const std::string& path, std::size_t chunk_bytes) {
        const Handle access = dataset_access(chunk_bytes, errors);
        return errors.own(H5Dopen2(file, path.c_str(), access), H5Dclose, text("opening {}", path));
    };
    GroupDatasets opened{open(time_path(recording), 0), {}, {}};
    if (recording.trajectory)
        opened.step = open(path_in(recording.group, recording.quantities.front().name + "/step"), 0);
    for (const Quantity& quantity : recording.quantities) {
        const std::size_t rows = static_cast<std::size_t>(recording.rows_per_chunk);
        opened.quantities.push_back(
            open(value_path(recording, quantity), sizeof(double) * rows * count_of(recording, quantity)));
    }
    return opened;
}

Handle creation_list(hid_t kind, const Hdf5Errors& errors) {
    Handle creation = errors.own(H5Pcreate(kind), H5Pclose, "creating a creation list");
    if (kind != H5P_DATASET_CREATE) errors.check(H5Pset_link_creation_order(creation, in_order), "tracking link order");
    errors.check(H5Pset_attr_creation_order(creation, in_order), "tracking attribute order");
    errors.check(H5Pset_obj_track_times(creation, false), "disabling timestamps");
    return creation;
}

void write_attribute(hid_t object, const Attribute& attribute, const Hdf5Errors& errors) {
    const char* name = attribute.first.c_str();
    if (const auto* words = std::get_if<std::string>(&attribute.second))
        return write_text(object, name, *words, H5T_STR_NULLPAD, errors);
    const Handle space = errors.own(H5Screate(H5S_SCALAR), H5Sclose, "creating a dataspace");
    if (const auto* number = std::get_if<std::int64_t>(&attribute.second))
        write_raw(object, name, H5T_STD_I64LE, space, number, errors);
    else write_raw(object, name, H5T_IEEE_F64LE, space, &std::get<double>(attribute.second), errors);
}

void write_list(hid_t object, const char* name, std::span<const std::int64_t> values, const Hdf5Errors& errors) {
    const Handle space = line_space(values.size(), errors);
    write_raw(object, name, H5T_STD_I64LE, space, values.data(), errors);
}

void write_list(hid_t object, const char* name, std::span<const std::string> values, const Hdf5Errors& errors) {
    std::size_t longest = 1;
    for (const std::string& value : values) longest = std::max(longest, value.size());
    std::string letters;
    for (const std::string& value : values) letters += value + std::string(longest - value.size(), '\0');
    const Handle type = text_type(longest, H5T_STR_NULLPAD, H5T_CSET_ASCII, errors);
    const Handle space = line_space(values.size(), errors);
    write_raw(object, name, type, space, letters.data(), errors);
}

void write_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors) {
    const Handle root = errors.own(H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose, "opening the root group");
    const auto write = [&](const Attribute& attribute) {
        const char* name = attribute.first.c_str();
        if (errors.check(H5Aexists(root, name), "looking up an attribute") > 0)
            errors.check(H5Adelete(root, name), "removing an attribute");
        write_attribute(root, attribute, errors);
    };
    write({"Conventions", std::string("CF-1.8")});
    for (const Attribute& attribute : attributes) write(attribute);
}

void replace_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors) {
    std::set<std::string> kept{"Conventions", run_id_name};
    for (const Attribute& attribute : attributes) kept.insert(attribute.first);
    for (const std::string& name : attribute_names(file, errors))
        if (!kept.contains(name)) errors.check(H5Adelete(file, name.c_str()), "removing an attribute");
    write_root_attributes(file, attributes, errors);
}

}  // namespace drover::files
