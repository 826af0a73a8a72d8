// python/module.cpp: the module drover._drover: scenes, theory, archives, tables.  Its results are texts, JSON and
// NumPy arrays, from which the package makes xarray objects.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <csignal>
#include <future>
#include <nlohmann/json.hpp>

#include "analysis/lagged_waves.hpp"
#include "analysis/onset.hpp"
#include "analysis/stability.hpp"
#include "analysis/states.hpp"
#include "analysis/wave_fit.hpp"
#include "base/duration.hpp"
#include "base/log.hpp"
#include "base/mapped.hpp"
#include "drover/base/version.hpp"
#include "files/archive.hpp"
#include "files/archive_reader.hpp"
#include "io/export.hpp"
#include "io/scene.hpp"
#include "jobs/boundary_shares.hpp"
#include "jobs/calibration/calibration.hpp"
#include "jobs/campaign/slurm_script.hpp"
#include "jobs/sweep/sweep.hpp"
#include "jobs/tradeoff/tradeoff.hpp"
#include "physics/model_keys.hpp"
#include "python/bindings.hpp"
#include "report/shown.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/provenance.hpp"
#include "run/loop/signals.hpp"
#include "run/run_scene.hpp"
#include "run/step_choice.hpp"

namespace drover::python {

namespace py = pybind11;

void run_interruptibly(const std::function<void()>& work, const std::function<void()>& stop) {
    std::future<void> done = std::async(std::launch::async, work);
    std::optional<py::error_already_set> raised;
    for (;;) {
        {
            const py::gil_scoped_release release;
            if (done.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready) break;
        }
        if (raised || PyErr_CheckSignals() == 0) continue;
        raised.emplace();
        stop();
    }
    if (!raised) return done.get();
    throw *raised;
}

void run_interruptibly(const std::function<void()>& work) {
    struct Stop {
        bool asked = false;
        ~Stop() {
            if (asked) run::request_stop(0);
        }
    } stop;
    run_interruptibly(work, [&stop] {
        stop.asked = true;
        run::request_stop(SIGINT);
    });
}

py::object array_of(std::span<const double> values, const std::vector<std::size_t>& shape, py::handle owner,
                    bool is_writable) {
    if (!owner) return py::array_t<double>(shape, values.data());
    py::array_t<double> view(shape, values.data(), owner);
    if (!is_writable) view.attr("setflags")(py::arg("write") = false);
    return view;
}

py::list axes_list(const std::vector<files::Axis>& axes) {
    py::list list;
    for (const files::Axis& axis : axes)
        list.append(py::make_tuple(axis.name, axis.unit, axis.meaning, array_of(axis.values, {axis.values.size()})));
    return list;
}

py::dict table_dict(const files::ResultTable& table) {
    py::dict one = group_dict(table.axes, table.quantities, [&](std::size_t i) {
        return array_of(table.values[i], shape_of(table.axes, table.quantities[i]));
    });
    one["group"] = table.group;
    return one;
}

namespace {
/// drover.Error(message, place, fault); messages of the library name the option of the commands.
void raise(std::string message, const std::string& place, Fault fault) {
    constexpr std::string_view option = "--overwrite";
    if (const std::size_t at = message.find(option); at != std::string::npos)
        message.replace(at, option.size(), "overwrite=True");
    const py::object type = py::module_::import("drover.error").attr("Error");
    const py::object value = type(message, place, name_of(fault));
    PyErr_SetObject(type.ptr(), value.ptr());
}

void translate(std::exception_ptr failure) {
    try {
        if (failure) std::rethrow_exception(failure);
    } catch (const Error& error) {
        raise(error.message(), error.place(), error.fault());
    } catch (const std::system_error& error) {
        raise(text("the operating system reports: {}; check the disk and the limits of this user", error.what()), "",
              Fault::environment);
    }
}

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

void bind_archive(py::module_& module) {
    py::class_<files::ArchiveReader>(module, "Archive", "An archive open for reading; drover.open_run wraps it.")
        .def(py::init([](const std::filesystem::path& file) { return files::ArchiveReader(file); }), py::arg("file"))
        .def("contents", &contents_of)
        .def("read", &read, py::arg("path"), py::arg("rows") = py::none(), "All, or (first, count) rows.");
}

/// The result of a theory with the scene that it is of.
struct Computed {
    run::Result result;
    io::Scene scene;
    std::string what;
    int threads = 1;
};

py::list tables_of(const Computed& computed) {
    py::list tables;
    for (const files::ResultTable& table : run::result_tables(computed.result)) tables.append(table_dict(table));
    return tables;
}

/// The fields of the states of drover states: {axes, arrays}, with the number of the state as the first axis.
py::object frames_of(const Computed& computed) {
    if (!computed.result.frames) return py::none();
    const files::Recording& recording = computed.result.frames->recording;
    const auto& rows = computed.result.frames->rows;
    return group_dict(recording.axes, recording.quantities, [&](std::size_t i) {
        std::vector<double> values;
        for (const std::vector<std::vector<double>>& row : rows)
            values.insert(values.end(), row[i].begin(), row[i].end());
        std::vector<std::size_t> shape = shape_of(recording.axes, recording.quantities[i]);
        shape.insert(shape.begin(), rows.size());
        return array_of(values, shape);
    });
}

void bind_theory(py::module_& module) {
    py::class_<Computed>(module, "Computed", "A result of linear theory; drover.Theory wraps it.")
        .def_property_readonly("text", [](const Computed& self) { return run::result_text(self.result); })
        .def_property_readonly("json", [](const Computed& self) { return run::result_json(self.result).dump(); })
        .def_property_readonly("kind", [](const Computed& self) { return self.what; })
        .def_property_readonly("scene", [](const Computed& self) { return self.scene; })
        .def_property_readonly("attributes", [](const Computed& self) { return run::result_attributes(self.result); })
        .def("tables", &tables_of)
        .def("frames", &frames_of)
        .def("write", [](const Computed& self, const std::filesystem::path& file, bool overwrite) {
            report::write_result(self.result, file, self.what, self.scene, self.threads, overwrite);
        });
    module.def(
        "stability",
        [](const io::Scene& scene, int threads) {
            io::require_grid(scene, "stability");
            return interruptibly([&] {
                Threads team(threads > 0 ? threads : run::choose_threads(scene));
                return Computed{run::with_units(analysis::make_stability(scene, &team), scene.units), scene,
                                "stability", team.count()};
            });
        },
        py::arg("scene"), py::arg("threads") = 0);
    module.def("lagged_waves", [](const io::Scene& scene, const std::map<std::string, double>& means,
                                  const std::string& component, const std::vector<std::pair<double, double>>& waves,
                                  double interval, std::size_t lags) {
        const auto at = mapped(waves, [](const auto& q) { return numerics::Wavevector{q.first, q.second}; });
        const analysis::LaggedWaves found =
            interruptibly([&] { return analysis::lagged_waves(scene, means, component, at, interval, lags); });
        const std::size_t rows = lags == 0 ? 0 : found.values.size() / lags;
        return py::make_tuple(found.state, py::array_t<std::complex<double>>({rows, lags}, found.values.data()),
                              found.why_none.value_or(""));
    });
    module.def(
        "boundary",
        [](const io::Scene& scene, int threads, const std::string& collected) {
            io::require_grid(scene, "boundary");
            return interruptibly([&] {
                Threads team(threads > 0 ? threads : scene.run.threads > 0 ? scene.run.threads : usable_cores());
                run::Result result =
                    collected.empty()
                        ? analysis::make_boundary(scene, team)
                        : *jobs::make_boundary_in_shares(scene, {.folder = collected, .collect = true}, team);
                return Computed{run::with_units(std::move(result), scene.units), scene, "boundary", team.count()};
            });
        },
        py::arg("scene"), py::arg("threads") = 0, py::arg("collected") = "");
    module.def("boundary_status", &jobs::boundary_status);
    module.def("onset",
               [](const std::filesystem::path& table, const std::optional<double>& varied,
                  const std::optional<double>& cell, const std::vector<analysis::AreaFractions>& points, int draws) {
                   analysis::TableOnset onset = analysis::make_onset(table, varied, draws);
                   if (cell) analysis::add_cells(onset, *cell, points);
                   return Computed{std::move(onset.result), std::move(onset.scene), "onset", 1};
               });
    module.def(
        "states",
        [](const io::Scene& scene, std::optional<double> speed, std::optional<double> settle, const std::string& follow,
           int points, int threads) {
            io::require_grid(scene, "states");
            return interruptibly([&] {
                Threads team(std::max(threads, 1));
                const analysis::StatesOptions options{.speed = speed,
                                                      .settle = settle,
                                                      .follow = follow,
                                                      .max_points = points};
                return Computed{run::with_units(analysis::make_states(scene, options, team), scene.units), scene,
                                "states", team.count()};
            });
        },
        py::arg("scene"), py::arg("speed") = py::none(), py::arg("settle") = py::none(), py::arg("follow") = "",
        py::arg("points") = analysis::StatesOptions{}.max_points, py::arg("threads") = 0);
    module.def("fit", [](const std::string& archive, const std::vector<std::string>& keys,
                         const std::optional<io::Scene>& scene, std::optional<double> max_wavenumber, double begin,
                         std::optional<double> end, int every) {
        const analysis::WaveFitOptions options{
            .archive = archive,
            .keys = keys,
            .choice = {.max_wavenumber = max_wavenumber, .begin = begin, .end = end, .every = every}};
        return interruptibly([&] {
            const io::Scene model = scene ? *scene : analysis::fitted_scene(archive, "", {});
            return run::result_json(analysis::make_wave_fit(model, options)).dump();
        });
    });
}

/// Of fields: shipped, or of the scene's own.
model::Equations equations_of(const io::Scene& scene) {
    io::require_grid(scene, "equations");
    return run::equations_of(scene);
}

void bind_scene(py::module_& module) {
    py::class_<io::Scene>(module, "Scene", "A valid scene; drover.Scene wraps it.")
        .def_static(
            "parse",
            [](const std::string& text, const std::string& name, const std::vector<std::string>& settings,
               const py::dict& functions) { return io::parse_scene(text, name, settings, term_functions(functions)); },
            py::arg("text"), py::arg("name"), py::arg("settings"), py::arg("functions") = py::dict())
        .def_static("read", [](const std::filesystem::path& file,
                               const std::vector<std::string>& settings) { return io::read_scene(file, settings); })
        .def_property_readonly("kind", [](const io::Scene& self) { return name_of(self.kind); })
        .def_property_readonly("text", &io::resolved_text)
        .def_property_readonly("equations", &equations_of)
        .def_property_readonly("archive", &run::archive_path);
    module.def("model_file", &physics::model_file_text);
    module.def("check", &report::check_scene);
    module.def("explain", [](const io::Scene& scene) {
        return interruptibly([&] {
            const run::Result found = report::explain(run::with_chosen_step(scene, true));
            return run::result_json(run::with_units(found, scene.units)).dump();
        });
    });
    module.def(
        "schema",
        [](const std::string& kind) {
            if (kind.empty()) return report::schema_json(io::scene_schema()).dump();
            return report::schema_json(io::scene_schema(io::kind_of_name(kind))).dump();
        },
        py::arg("kind") = "");
    module.def("coefficients", [] { return physics::coefficient_documentation(); });
}

py::dict outcome_dict(const run::RunOutcome& outcome) {
    py::dict result;
    result["archive"] = outcome.archive;
    result["steps"] = outcome.loop.step;
    result["signal"] = outcome.loop.signal;
    result["wall_seconds"] = outcome.loop.wall_seconds;
    return result;
}

std::string calibrate(const io::Scene& scene, const std::filesystem::path& folder, int share, int shares, bool collect,
                      const std::vector<std::string>& want, const std::string& budget, bool quiet) {
    require(budget.empty() || !want.empty(), {}, "budget = \"{}\" without want; expected both, or neither", budget);
    require(1 <= share && share <= shares, {}, "share = ({}, {}); expected (i, n) with i from 1 to n", share, shares);
    const jobs::CalibrationOutcome outcome = jobs::run_calibration(
        scene, jobs::target_options(
                   {.folder = folder, .share = {.number = share, .count = shares}, .collect = collect, .quiet = quiet},
                   want, budget.empty() ? INFINITY : seconds_of(budget, "budget")));
    nlohmann::json result{{"file", outcome.file.string()},
                          {"units", outcome.units},
                          {"trials_run", outcome.trials},
                          {"trials_found", outcome.already},
                          {"failed", outcome.failed},
                          {"unfinished", outcome.unfinished},
                          {"unmet", outcome.unmet_targets},
                          {"stopped", outcome.stopped},
                          {"text", outcome.table ? report::text_of(*outcome.table) : ""}};
    if (outcome.table) result["coefficients"] = report::json_of(*outcome.table);
    if (outcome.want) {
        result["want"] = run::result_json(*outcome.want);
        result["text"] = result["text"].get<std::string>() + "\n" + run::result_text(*outcome.want);
    }
    return result.dump();
}

std::string tradeoff(const io::Scene& scene, const std::vector<std::string>& want, const std::string& budget,
                     const std::filesystem::path& folder, int workers, bool collect, bool quiet) {
    const jobs::Tradeoff found = jobs::study_tradeoff(
        scene, jobs::target_options({.folder = folder, .workers = workers, .collect = collect, .quiet = quiet}, want,
                                    seconds_of(budget, "budget")));
    if (found.stopped) fail_run("stopped by a signal; every trial is kept: the same call resumes");
    const nlohmann::json result{{"found", run::result_json(found.result)},
                                {"text", run::result_text(found.result)},
                                {"reasons", found.reasons},
                                {"refusal", found.why_none},
                                {"recommended", found.recommended_text},
                                {"seconds", found.expected_seconds}};
    return result.dump();
}

/// The recommended scene, as TOML.
std::string with_accuracy(const io::Scene& scene, const std::vector<std::string>& want, bool quiet) {
    const auto found = jobs::with_accuracy(scene, jobs::parse_accuracy_targets(want), quiet);
    if (!found) fail_run("stopped by a signal; every trial is kept: the same call resumes");
    return nlohmann::json{{"scene", io::resolved_text(*found)}}.dump();
}

std::string sweep(const io::Scene& scene, const std::filesystem::path& folder, int share, int shares, bool collect,
                  bool quiet) {
    const jobs::SweepOutcome outcome = jobs::run_sweep(
        scene, {.folder = folder, .share = {.number = share, .count = shares}, .collect = collect, .quiet = quiet});
    const jobs::SweepTable table = outcome.table.value_or(jobs::SweepTable{});
    const nlohmann::json result{
        {"keys", table.keys},         {"rows", report::json_of(table)}, {"text", report::text_of(table)},
        {"warnings", table.warnings}, {"failed", outcome.failed},       {"failures", outcome.failures},
        {"missing", outcome.missing}, {"stopped", outcome.stopped}};
    return result.dump();
}

std::string calibration_status(const io::Scene& scene, const std::filesystem::path& folder,
                               const std::vector<std::string>& want, const std::string& budget) {
    return jobs::calibration_status(scene,
                                    jobs::target_options({.folder = folder}, want,
                                                         budget.empty() ? INFINITY : seconds_of(budget, "budget")));
}

void bind_runs(py::module_& module) {
    module.def(
        "run_scene",
        [](const io::Scene& scene, bool overwrite, bool quiet) {
            return outcome_dict(
                interruptibly([&] { return run::run_scene(scene, {.overwrite = overwrite, .quiet = quiet}); }));
        },
        py::arg("scene"), py::arg("overwrite"), py::arg("quiet"));
    module.def(
        "restart_run",
        [](const std::filesystem::path& archive, const std::vector<std::string>& settings, const py::dict& functions,
           bool quiet) {
            const run::RunOptions options{.quiet = quiet, .functions = term_functions(functions)};
            return outcome_dict(interruptibly([&] { return run::restart_run(archive, settings, options); }));
        },
        py::arg("archive"), py::arg("settings"), py::arg("functions"), py::arg("quiet"));
    // These start processes: drover/worker.py calls them in a process without threads.
    module.def("tradeoff", &tradeoff, py::arg("scene"), py::arg("want"), py::arg("budget"), py::arg("folder"),
               py::arg("workers"), py::arg("collect"), py::arg("quiet"));
    module.def("tradeoff_status", &jobs::tradeoff_status);
    module.def("with_accuracy", &with_accuracy, py::arg("scene"), py::arg("want"), py::arg("quiet"));
    module.def("sweep", &sweep, py::arg("scene"), py::arg("folder"), py::arg("share"), py::arg("shares"),
               py::arg("collect"), py::arg("quiet"));
    module.def("sweep_status", &jobs::sweep_status);
    module.def("calibration_status", &calibration_status);
    module.def("calibrate", &calibrate, py::arg("scene"), py::arg("folder"), py::arg("share"), py::arg("shares"),
               py::arg("collect"), py::arg("want"), py::arg("budget"), py::arg("quiet"));
    module.def("leave_signals_to_python", &run::leave_signals_to_host);
    module.def("leave_hdf5_open", &files::leave_hdf5_open);
    module.def("slurm_script", [](const std::string& command, const std::filesystem::path& scene,
                                  const std::vector<std::string>& settings, const std::filesystem::path& folder,
                                  int shares, const std::vector<std::string>& options) {
        return jobs::slurm_script({.command = command,
                                   .scene = scene,
                                   .overrides = settings,
                                   .folder = folder,
                                   .shares = shares,
                                   .options = options});
    });
    module.def("differences", [](const std::filesystem::path& one, const std::filesystem::path& other) {
        py::dict rows;
        for (const files::TextDifference& row : run::scene_differences(one, other))
            rows[py::str(row.key)] = py::make_tuple(row.one, row.other);
        return rows;
    });
    module.def("info", [](const std::filesystem::path& file) {
        return report::info_json(file).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    });
    module.def("export_fields", [](const std::filesystem::path& archive, const std::filesystem::path& output,
                                   std::int64_t frame, std::int64_t every, bool overwrite) {
        return io::write_fields(files::ArchiveReader(archive), archive.string(), {.frame = frame, .every = every},
                                output, overwrite);
    });
    module.def("export_xyz", [](const std::filesystem::path& archive, const std::filesystem::path& output,
                                std::int64_t frame, std::int64_t every, bool bodies, bool overwrite) {
        return io::write_xyz(files::ArchiveReader(archive), archive.string(), {.frame = frame, .every = every}, bodies,
                             output, overwrite);
    });
}
}  // namespace

PYBIND11_MODULE(_drover, module) {
    module.doc() = "The library of drover; use the package drover instead.";
    run::leave_signals_to_host();
    py::register_exception_translator(&translate);
    bind_term_function(module);
    bind_archive(module);
    bind_model(module);
    bind_scene(module);
    bind_session(module);
    bind_theory(module);
    bind_runs(module);
    module.def("version", [] {
        const Version built = version();
        return py::make_tuple(built.version, built.git_hash, built.dirty);
    });
}

}  // namespace drover::python
