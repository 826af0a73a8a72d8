// run/session.cpp: a run in memory and its samples, and the same for programs in C++.
#include "drover/run/session.hpp"

#include "base/mapped.hpp"
#include "io/scene.hpp"
#include "io/trajectory.hpp"
#include "run/fields/field_problem.hpp"
#include "run/run_scene.hpp"
#include "run/session_state.hpp"
#include "run/simulation_type.hpp"
#include "run/step_choice.hpp"

namespace drover::run {

namespace {
io::Scene ready(const io::Scene& scene) {
    check_memory(scene);
    check_result_names(scene);
    io::Scene chosen = with_chosen_step(scene, true);
    chosen.accuracy.biases = false;  // they are results of runs that end
    return chosen;
}
}  // namespace

SessionState::SessionState(const io::Scene& given)
    : scene(ready(given)),
      threads(std::make_unique<Threads>(simulation_type_of(scene).threads(scene))),
      simulation(simulation_type_of(scene).make(scene, *threads, {})) {
    simulation->check_health(0);
    append_row(simulation->recordings.back(), 0.0, samples);
}

std::span<const ScheduledRecording> SessionState::frames() const {
    return std::span(simulation->recordings).first(simulation->recordings.size() - 1);
}

void SessionState::advance(std::int64_t more, const std::function<void()>& poll) {
    require(more >= 0, {}, "steps = {}; expected 0 or more: a run does not go back", more);
    require(!failed, {}, "the run has failed at t = {} s; start another one", time());
    const ScheduledRecording& observables = simulation->recordings.back();
    for (const std::int64_t end = step + more; step < end;) {
        poll();
        // The sample of time.end may be off the schedule of a run that goes on.
        if (step == simulation->steps && step > 0 && observables.every > 0 && !is_due(observables, step))
            remove_last_row(observables, samples);
        failed = true;  // unless the step succeeds
        simulation->advance(step);
        ++step;
        if (is_checked(*simulation, step) || step == end) simulation->check_health(step);
        if (step == simulation->steps || is_due(observables, step)) append_row(observables, time(), samples);
        failed = false;
    }
}

Report SessionState::report() const {
    require(step > 0, {}, "the run has taken no steps yet, so there are no means; advance it first");
    io::Scene until_now = scene;
    until_now.time.end = time();
    until_now.output.frame_every = 0.0;
    if (was_changed) until_now.initial.kind = io::default_start(scene.kind).kind;  // no longer stationary
    return make_report(files::ArchiveReader(samples), until_now, Theory::included);
}

void SessionState::accept() {
    simulation->accept(step);
    was_changed = true;
}

Session::Session(const std::filesystem::path& scene_file) : Session(io::read_scene(scene_file)) {}
Session::Session(const std::string& scene, const std::string& name) : Session(io::parse_scene(scene, name)) {}
Session::Session(const io::Scene& scene) : state_(std::make_unique<SessionState>(scene)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

double Session::time() const { return state_->time(); }
double Session::dt() const { return state_->scene.time.dt; }
std::int64_t Session::step() const { return state_->step; }
std::int64_t Session::steps() const { return state_->simulation->steps; }
void Session::advance(std::int64_t steps, const std::function<void()>& poll) { state_->advance(steps, poll); }
void Session::accept() { state_->accept(); }
std::span<const double> Session::sample_times() const { return state_->sample_times(); }

std::vector<FrameArray> Session::frame() const {
    std::vector<FrameArray> arrays;
    for (std::size_t f = 0; f < state_->frames().size(); ++f) {
        const files::Recording& recording = state_->frames()[f].recording;
        if (recording.group == io::spheres_group) continue;  // they follow from the bodies
        const std::string group = recording.group.substr(recording.group.rfind('/') + 1);
        const std::vector<std::span<const double>> now = state_->frames()[f].observe();
        for (std::size_t i = 0; i < now.size(); ++i) {
            const files::Quantity& quantity = recording.quantities[i];
            arrays.push_back({group.empty() ? quantity.name : group + "/" + quantity.name,
                              quantity.unit,
                              quantity.meaning,
                              shape_of(recording.axes, quantity),
                              {const_cast<double*>(now[i].data()), now[i].size()}});  // arrays of the simulation
        }
    }
    return arrays;
}

std::vector<ObservedSeries> Session::series() const {
    const files::Recording& recording = state_->observables();
    return mapped(recording.quantities, [&](const files::Quantity& quantity) {
        return ObservedSeries{quantity.name, quantity.unit, quantity.meaning, shape_of(recording.axes, quantity),
                              state_->samples_of(quantity).values};
    });
}

std::vector<SessionResult> Session::results() const {
    const Report report = state_->report();
    return mapped(report.summary.rows, [&](const measure::SummaryRow& row) {
        SessionResult result{row};
        if (const Prediction* theory = measure::find_row(report.predictions, row.name)) result.theory = theory->values;
        return result;
    });
}

}  // namespace drover::run
