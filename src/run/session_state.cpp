// run/session_state.cpp: a run in memory and its samples.
#include "run/session_state.hpp"

#include <algorithm>
#include <map>

#include "run/kind.hpp"
#include "run/run_scene.hpp"
#include "run/step_choice.hpp"

namespace drover::run {

namespace {
io::Scene ready(const io::Scene& scene) {
    check_memory(scene);
    io::Scene chosen = with_chosen_step(scene, true);
    chosen.accuracy.biases = false;  // they are results of runs that end
    return chosen;
}
}  // namespace

SessionState::SessionState(const io::Scene& scene)
    : scene_(ready(scene)),
      threads_(std::make_unique<Threads>(kind_of(scene_).threads(scene_))),
      simulation_(kind_of(scene_).make(scene_, *threads_, {})) {
    series_.values.resize(simulation_->recordings.back().recording.quantities.size());
    simulation_->check_health(0);
    if (is_due(simulation_->recordings.back(), 0)) sample();
}

std::span<const ScheduledRecording> SessionState::frames() const {
    return std::span(simulation_->recordings).first(simulation_->recordings.size() - 1);
}

void SessionState::sample() {
    series_.times.push_back(time());
    const std::vector<std::span<const double>> row = simulation_->recordings.back().observe();
    for (std::size_t i = 0; i < row.size(); ++i)
        series_.values[i].insert(series_.values[i].end(), row[i].begin(), row[i].end());
}

void SessionState::advance(std::int64_t steps, const std::function<void()>& poll) {
    require(!failed_, {}, "the run has failed at t = {} s; start another one", time());
    for (const std::int64_t end = step_ + steps; step_ < end;) {
        poll();
        failed_ = true;  // unless the step succeeds
        simulation_->advance(step_);
        ++step_;
        if (is_checked(*simulation_, step_) || step_ == end) simulation_->check_health(step_);
        if (step_ == simulation_->steps || is_due(simulation_->recordings.back(), step_)) sample();
        failed_ = false;
    }
}

Report SessionState::report() const {
    require(step_ > 0, {}, "the run is at its start, of which there are no means; advance it first");
    const files::Recording& recording = observables();
    std::map<std::string, files::Array> arrays{
        {recording.group + "/time", {.shape = {series_.times.size()}, .values = series_.times}}};
    for (std::size_t q = 0; q < series_.values.size(); ++q) {
        files::Array array{.shape = {series_.times.size()}, .values = series_.values[q]};
        for (const std::size_t size : files::shape_of(recording.axes, recording.quantities[q]))
            array.shape.push_back(size);
        arrays[recording.group + "/" + recording.quantities[q].name] = std::move(array);
    }
    io::Scene until_now = scene_;
    until_now.time.end = time();
    until_now.output.frame_every = 0.0;
    return make_report(files::ArchiveReader(std::move(arrays)), until_now, Theory::included);
}

void SessionState::accept() {
    simulation_->accept(step_);
    was_changed_ = true;
}

}  // namespace drover::run
