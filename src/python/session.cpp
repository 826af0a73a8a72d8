// python/session.cpp: a run in memory for Python.
#include "run/session_state.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>

#include "drover/measure/statistics.hpp"
#include "python/bindings.hpp"

namespace drover::python {

namespace py = pybind11;

namespace {
using Session = Guarded<run::SessionState>;

/// Lets Python handle signals now and then; an exception from a handler ends the caller between two steps.
class SignalPoll {
public:
    void operator()() {
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < std::chrono::milliseconds(50)) return;
        last_ = now;
        const py::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// In a thread of its own, where Python raises no KeyboardInterrupt inside a function, in the middle of a step.
void advance_with_functions(Session& guarded, std::int64_t steps) {
    struct Stopped {};
    std::atomic<bool> stops = false;
    run_interruptibly(
        [&] {
            guarded.held.advance(steps, [&] {
                if (stops) throw Stopped{};
            });
        },
        [&] { stops = true; });
}

void advance_session(Session& guarded, std::int64_t steps) {
    require(steps >= 0, {}, "steps = {}; expected 0 or more: a run does not go back", steps);
    const Use use(guarded);
    const std::vector<physics::TextTerm>& terms = guarded.held.scene.model.text_terms;
    if (std::ranges::any_of(terms, [](const physics::TextTerm& term) { return term.call != nullptr; }))
        return advance_with_functions(guarded, steps);
    const py::gil_scoped_release release;
    SignalPoll poll;
    guarded.held.advance(steps, std::ref(poll));
}

/// Each frame as {group, axes, arrays: {name: (unit, meaning, axes, view)}, fixed: {...}}.
py::list frames_of_session(const py::object& self, bool is_writable) {
    Session& guarded = self.cast<Session&>();
    const Use use(guarded);
    py::list frames;
    for (std::size_t f = 0; f < guarded.held.frames().size(); ++f) {
        const files::Recording& recording = guarded.held.frames()[f].recording;
        const std::vector<std::span<const double>> now = guarded.held.frames()[f].observe();
        py::dict fixed,
            frame = group_dict(recording.axes, recording.quantities, [&](std::size_t i) {
                return array_of(now[i], shape_of(recording.axes, recording.quantities[i]), self, is_writable);
            });
        if (recording.trajectory)
            for (const files::FixedArray& one : recording.trajectory->fixed) {
                std::vector<std::size_t> shape{one.values.size() / one.components};
                if (one.components > 1) shape.push_back(one.components);
                fixed[py::str(one.name)] = py::make_tuple(one.unit, one.meaning, array_of(one.values, shape, self));
            }
        frame["group"] = recording.group;
        frame["fixed"] = fixed;
        frames.append(frame);
    }
    return frames;
}

/// {axes, times, arrays: {name: (unit, meaning, axes, values)}}, with time as the first axis.
py::dict series_of(Session& guarded) {
    const Use use(guarded);
    const files::Recording& recording = guarded.held.observables();
    const std::vector<double>& times = guarded.held.sample_times();
    py::dict result = group_dict(recording.axes, recording.quantities, [&](std::size_t i) {
        const files::Array& samples = guarded.held.samples_of(recording.quantities[i]);
        return array_of(samples.values, samples.shape);
    });
    result["times"] = array_of(times, {times.size()});
    return result;
}

/// (mean, standard error or None, integrated autocorrelation time) of a series at equal times, from sample `skip` on.
py::tuple mean_of(std::vector<double> values, double spacing, std::size_t skip) {
    const measure::Estimate found =
        measure::estimate_mean({.series = {std::move(values)}, .spacing = spacing, .skip = skip}, 0);
    return py::make_tuple(found.mean, found.error, found.autocorrelation_time);
}
}  // namespace

void bind_session(py::module_& module) {
    module.def("mean_of", &mean_of, py::arg("values"), py::arg("spacing"), py::arg("skip"));
    py::class_<Session, std::shared_ptr<Session>>(module, "Session", "A run in memory; drover.Simulation wraps it.")
        .def(py::init(
            [](const io::Scene& scene) { return interruptibly([&] { return std::make_shared<Session>(scene); }); }))
        .def_property_readonly("scene", [](const Session& self) { return self.held.scene; })
        .def_property_readonly("step", [](const Session& self) { return self.held.step; })
        .def_property_readonly("steps", [](const Session& self) { return self.held.simulation->steps; })
        .def_property_readonly("time", [](const Session& self) { return self.held.time(); })
        .def_property_readonly("dt", [](const Session& self) { return self.held.scene.time.dt; })
        .def_property_readonly("threads", [](const Session& self) { return self.held.simulation->threads; })
        .def_property_readonly("frame_every",
                               [](const Session& self) { return self.held.simulation->recordings.front().every; })
        .def_property_readonly("time_unit", [](const Session& self) { return self.held.observables().time_unit; })
        .def_property_readonly("was_changed", [](const Session& self) { return self.held.was_changed; })
        .def("advance", &advance_session, py::arg("steps"))
        .def("frames", &frames_of_session, py::arg("writable") = false)
        .def("series", &series_of)
        .def("summary",
             [](Session& self) {
                 const Use use(self);
                 return table_dict(run::result_table(interruptibly([&] { return self.held.report(); })));
             })
        .def("warnings",
             [](Session& self) {
                 const Use use(self);
                 return interruptibly([&] { return self.held.report().warnings; });
             })
        .def("accept", [](Session& self) {
            const Use use(self);
            self.held.accept();
        });
}

}  // namespace drover::python
