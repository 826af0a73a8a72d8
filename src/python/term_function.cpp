// python/term_function.cpp: Python functions as terms of the equations.
#include <pybind11/numpy.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

#include "drover/base/error.hpp"
#include "drover/base/threads.hpp"
#include "python/bindings.hpp"

namespace drover::python {

namespace py = pybind11;

namespace {
/// A function, given back with the GIL, and the lock that lets one thread at a time call it.
struct Held {
    explicit Held(py::object the_function) : function(std::move(the_function)) {}
    ~Held() {
        const py::gil_scoped_acquire acquire;
        function = py::object();
        if (lock_.load()->forks == fork_count()) delete lock_.load();
    }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

    /// A lock that threads of a parent hold is not that of its child.
    std::mutex& mutex() {
        Lock* now = lock_;
        if (now->forks != fork_count()) {
            auto made = std::make_unique<Lock>();
            if (lock_.compare_exchange_strong(now, made.get())) now = made.release();
        }
        return now->mutex;
    }

    py::object function;

private:
    struct Lock {
        std::mutex mutex;
        std::uint64_t forks = fork_count();
    };
    std::atomic<Lock*> lock_ = new Lock;
};

/// Whoever holds the mutex waits for the GIL: it must not be waited for with the GIL.
std::unique_lock<std::mutex> locked(std::mutex& mutex) {
    if (PyGILState_Check() == 0) return std::unique_lock(mutex);
    const py::gil_scoped_release release;
    return std::unique_lock(mutex);
}

/// The thread state that Python has of a thread of the library, kept from its first call of a function until it ends.
/// To make one for each call maps and unmaps memory, and takes longer than a small function.
class ThreadState {
public:
    /// With the GIL, in a thread whose state pybind11 has just made.
    ThreadState() : state_(PyThreadState_Get()) {
        for (PyThreadState* const one : ended()) {
            PyThreadState_Clear(one);
            PyThreadState_Delete(one);
        }
        ++state_->gilstate_counter;
    }
    /// Whoever waits for the thread may hold the GIL: the state is freed when the next one is kept.
    ~ThreadState() {
        const std::lock_guard lock(mutex_);
        if (forks_ == fork_count()) ended_.push_back(state_);
    }
    ThreadState(const ThreadState&) = delete;
    ThreadState& operator=(const ThreadState&) = delete;

private:
    /// Python itself frees those of its parent in a child.
    static std::vector<PyThreadState*> ended() {
        const std::lock_guard lock(mutex_);
        if (std::exchange(ended_forks_, fork_count()) != fork_count()) ended_.clear();
        return std::exchange(ended_, {});
    }

    static inline std::mutex& mutex_ = new_mutex_over_forks();
    static inline std::vector<PyThreadState*> ended_;
    static inline std::uint64_t ended_forks_ = 0;
    PyThreadState* state_;
    std::uint64_t forks_ = fork_count();
};

/// One component of a result: a number for all points, or an array of them.
void read_component(py::handle given, std::size_t size, double* out) {
    const py::array array = py::module_::import("numpy").attr("asarray")(given);
    require(std::string("fiub").find(array.dtype().kind()) != std::string::npos, {},
            "it returns numbers of the type {}; expected real numbers", std::string(py::str(array.dtype())));
    const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
    if (!numbers) throw py::error_already_set();
    if (numbers.ndim() == 0) {
        std::fill_n(out, size, *numbers.data());
        return;
    }
    require(numbers.ndim() == 1 && static_cast<std::size_t>(numbers.size()) == size, {},
            "it returns an array of shape {} for arguments of shape ({},); expected the x and y components, each an "
            "array of the shape of the arguments, or a number",
            std::string(py::str(array.attr("shape"))), size);
    std::copy_n(numbers.data(), size, out);
}

void call(const py::object& function, std::size_t size, std::span<const physics::PointArgument> arguments,
          std::span<double* const> out) {
    py::tuple given(arguments.size());
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        // A copy: the function may keep it or write to it.
        if (arguments[i].values) given[i] = py::array_t<double>(static_cast<py::ssize_t>(size), arguments[i].values);
        else given[i] = py::float_(arguments[i].number);
    }
    const py::object result = function(*given);
    const bool is_list = py::isinstance<py::sequence>(result) || py::isinstance<py::array>(result);
    require(is_list && py::len(result) == out.size(), {}, "it returns {}; expected two arrays, the x and y components",
            is_list ? text("{} items", py::len(result)) : std::string(py::str(py::type::of(result).attr("__name__"))));
    for (std::size_t c = 0; c < out.size(); ++c) read_component(result[py::int_(c)], size, out[c]);
}
}  // namespace

physics::TermFunctions term_functions(const py::dict& given) {
    physics::TermFunctions functions;
    for (const auto& [number, function] : given)
        functions[number.cast<std::size_t>()] = std::make_shared<const physics::PointFunction>(
            [held = function.cast<std::shared_ptr<Held>>()](std::size_t size,
                                                            std::span<const physics::PointArgument> arguments,
                                                            std::span<double* const> out) {
                const auto lock = locked(held->mutex());
                const bool is_new = PyGILState_GetThisThreadState() == nullptr;
                const py::gil_scoped_acquire acquire;
                if (is_new) thread_local const ThreadState kept;
                call(held->function, size, arguments, out);
            });
    return functions;
}

void bind_term_function(py::module_& module) {
    py::class_<Held, std::shared_ptr<Held>>(module, "TermFunction", "A function that one thread at a time calls.")
        .def(py::init<py::object>(), py::arg("function"))
        .def_readonly("function", &Held::function);
}

}  // namespace drover::python
