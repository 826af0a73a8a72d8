// python/archive.cpp: archives for Python: what a file holds, and rows of its arrays.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "files/archive_reader.hpp"
#include "python/bindings.hpp"

namespace drover::python {

namespace py = pybind11;

namespace {
py::dict attributes_dict(const std::vector<files::Attribute>& attributes) {
    py::dict found;
    // Names of files may be no UTF-8.
    const auto decoded = [](const std::string& words) {
        return py::reinterpret_steal<py::str>(
            PyUnicode_DecodeUTF8(words.data(), static_cast<Py_ssize_t>(words.size()), "replace"));
    };
    for (const auto& [name, value] : attributes) {
        const auto* words = std::get_if<std::string>(&value);
        found[decoded(name)] = words != nullptr ? py::object(decoded(*words)) : py::cast(value);
    }
    return found;
}

/// (attributes, groups, [(path, shape, is_integer, axes, attributes)]).
py::tuple contents_of(const files::ArchiveReader& reader) {
    const files::Contents all = reader.contents();
    py::list arrays;
    for (const files::StoredArray& one : all.arrays)
        arrays.append(py::make_tuple(one.path, py::tuple(py::cast(one.shape)), one.is_integer,
                                     py::tuple(py::cast(one.axes)), attributes_dict(one.attributes)));
    return py::make_tuple(attributes_dict(all.attributes), all.groups, arrays);
}

py::object read(const files::ArchiveReader& reader, const std::string& path,
                const std::optional<std::pair<std::size_t, std::size_t>>& rows) {
    files::Array array;
    {
        const py::gil_scoped_release release;
        array = rows ? reader.read(path, rows->first, rows->second) : reader.read(path);
    }
    return array_of(array.values, array.shape);
}
}  // namespace

void bind_archive(py::module_& module) {
    py::class_<files::ArchiveReader>(module, "Archive", "An archive open for reading; drover.open_run wraps it.")
        .def(py::init([](const std::filesystem::path& file) { return files::ArchiveReader(file); }), py::arg("file"))
        .def("contents", &contents_of)
        .def("read", &read, py::arg("path"), py::arg("rows") = py::none(), "All, or (first, count) rows.");
}

}  // namespace drover::python
