// python/bindings.hpp: what the parts of the module drover._drover share.
#pragma once
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/base/schema.hpp"
#include "drover/base/threads.hpp"
#include "files/archive_layout.hpp"
#include "physics/model_values.hpp"

namespace pybind11::detail {
template <class... Types>
struct type_caster<drover::Variant<Types...>> : variant_caster<drover::Variant<Types...>> {};
}  // namespace pybind11::detail

namespace drover::python {

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

/// What one thread uses at a time: others get an error instead of a data race.
template <class Held>
struct Guarded {
    template <class... Arguments>
    explicit Guarded(const Arguments&... arguments) : held(arguments...) {}
    Held held;
    std::atomic_flag busy;
    std::atomic<std::uint64_t> forks = fork_count();  // those before its last use began
};

/// While it lives, no other thread uses what is guarded.
template <class Held>
class Use {
public:
    explicit Use(Guarded<Held>& guarded) : guarded_(guarded) {
        const bool was_busy = guarded.busy.test_and_set();
        require(
            !was_busy || guarded.forks == fork_count(), {},
            "another thread was advancing this run when the process forked, and the child has it in the middle of a "
            "step; start a run of your own, or fork before the run begins");
        require(!was_busy, {},
                "another thread advances or reads this run; expected one at a time: use a lock, or start a run of your "
                "own");
        guarded.forks = fork_count();
    }
    ~Use() { guarded_.busy.clear(); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    Held* operator->() const { return &guarded_.held; }

private:
    Guarded<Held>& guarded_;
};

/// A NumPy array of these numbers: a copy or, with an owner that keeps them in place, a view.
pybind11::object array_of(std::span<const double> values, const std::vector<std::size_t>& shape,
                          pybind11::handle owner = {}, bool is_writable = false);

/// (name, unit, meaning, values) of each.
pybind11::list axes_list(const std::vector<files::Axis>& axes);

/// {axes, arrays: {name: (unit, meaning, axes, array)}}, with the array of each quantity from its index.
template <class ArrayOf>
pybind11::dict group_dict(const std::vector<files::Axis>& axes, const std::vector<files::Quantity>& quantities,
                          ArrayOf array_of_index) {
    pybind11::dict group, arrays;
    for (std::size_t i = 0; i < quantities.size(); ++i) {
        const files::Quantity& one = quantities[i];
        arrays[pybind11::str(one.name)] = pybind11::make_tuple(one.unit, one.meaning, one.axes, array_of_index(i));
    }
    group["axes"] = axes_list(axes);
    group["arrays"] = arrays;
    return group;
}

/// {group, axes, arrays: {name: (unit, meaning, axes, values)}}.
pybind11::dict table_dict(const files::ResultTable& table);

}  // namespace drover::python
