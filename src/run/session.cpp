// run/session.cpp: a run in memory for programs in C++.
#include "drover/run/session.hpp"

#include "io/scene_text.hpp"
#include "io/trajectory.hpp"
#include "run/session_state.hpp"

namespace drover::run {

Session::Session(const std::filesystem::path& scene_file) : Session(io::read_scene(scene_file)) {}
Session::Session(const std::string& scene, const std::string& name) : Session(io::parse_scene(scene, name)) {}
Session::Session(const io::Scene& scene) : state_(std::make_unique<SessionState>(scene)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

double Session::time() const { return state_->time(); }
double Session::dt() const { return state_->scene().time.dt; }
std::int64_t Session::step() const { return state_->step(); }
std::int64_t Session::steps() const { return state_->steps(); }
void Session::advance(std::int64_t steps, const std::function<void()>& poll) { state_->advance(steps, poll); }
void Session::accept() { state_->accept(); }
std::span<const double> Session::sample_times() const { return state_->sample_times(); }

std::vector<FrameArray> Session::frame() const {
    std::vector<FrameArray> arrays;
    for (std::size_t f = 0; f < state_->frames().size(); ++f) {
        const files::Recording& recording = state_->frames()[f].recording;
        if (recording.group == io::spheres_group) continue;  // they follow from the bodies
        const std::string group = recording.group.substr(recording.group.rfind('/') + 1);
        const std::vector<std::span<const double>> now = state_->observe(f);
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
    std::vector<ObservedSeries> found;
    for (const files::Quantity& quantity : recording.quantities)
        found.push_back({quantity.name, quantity.unit, quantity.meaning, shape_of(recording.axes, quantity),
                         state_->samples_of(quantity).values});
    return found;
}

std::vector<SessionResult> Session::results() const {
    const Report report = state_->report();
    std::vector<SessionResult> rows;
    for (const measure::SummaryRow& row : report.summary.rows) {
        rows.push_back({row});
        if (const Prediction* theory = find_prediction(report, row.name)) rows.back().theory = theory->values;
    }
    return rows;
}

}  // namespace drover::run
