// python/bindings.hpp: what the parts of the module drover._drover share.
#pragma once
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/base/variant.hpp"
#include "files/archive_layout.hpp"
#include "physics/text_term.hpp"

namespace pybind11::detail {
template <class... Types>
struct type_caster<drover::Variant<Types...>> : variant_caster<drover::Variant<Types...>> {};
}  // namespace pybind11::detail

namespace drover::python {

void bind_archive(pybind11::module_& module);
void bind_model(pybind11::module_& module);
void bind_session(pybind11::module_& module);
void bind_term_function(pybind11::module_& module);

/// The functions of {number of a term: TermFunction}.
physics::TermFunctions term_functions(const pybind11::dict& given);

/// Runs work without the GIL, in a thread of its own, while this thread lets Python handle signals.  A handler that
/// raises, as that of Ctrl-C does, calls `stop`, and its exception follows when the work has stopped.
void run_interruptibly(const std::function<void()>& work, const std::function<void()>& stop);
/// The same for work that stops at run::request_stop().
void run_interruptibly(const std::function<void()>& work);

/// Calls run_interruptibly and returns the value of the work.
template <class Work>
auto interruptibly(Work work) {
    std::optional<decltype(work())> value;
    run_interruptibly([&] { value.emplace(work()); });
    return std::move(*value);
}

/// A NumPy array of these numbers: a copy or, with an owner that keeps them in place, a view.
pybind11::object array_of(std::span<const double> values, const std::vector<std::size_t>& shape,
                          pybind11::handle owner = {}, bool is_writable = false);

/// (name, unit, meaning, values) of each.
pybind11::list axes_list(const std::vector<files::Axis>& axes);

/// {group, axes, arrays: {name: (unit, meaning, axes, values)}}.
pybind11::dict table_dict(const files::ResultTable& table);

}  // namespace drover::python
