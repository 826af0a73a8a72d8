// io/scene.hpp: a scene: the whole of a run as data, read from TOML text.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/calibrate/catalogue.hpp"
#include "drover/dem/setup.hpp"
#include "drover/numerics/grid.hpp"
#include "drover/physics/initial_state.hpp"
#include "drover/physics/model.hpp"

namespace drover::io {

/// How time advances.
struct TimeControl {
    double dt = 0.01;                ///< step [s]; of particles dt_of_particles when it is not given
    double end = 1.0;                ///< [s]
    std::string stepper = "etdrk2";  ///< a row of numerics::stepper_tables()
    double tolerance = 0.0;          ///< error of a step beside the size of its field, adaptive; 0: steps of dt
};

inline constexpr double dt_of_particles = 2e-5;

/// What is written and when.
struct Output {
    std::string file;                 ///< "" : the scene's name with .h5, in the folder where drover runs
    double frame_every = 1.0;         ///< time between frames [s]; 0: the first and the last alone
    double sample_every = 0.1;        ///< time between samples of the observables [s]
    double checkpoint_minutes = 5.0;  ///< wall time between checkpoints
    bool powers = false;              ///< the energy of each sample, and the power of each term
};

/// How means are taken.
struct Analysis {
    double warm_up = -1.0;  ///< time left out at the start [s]; -1: found from the series
};

/// What does not change the physics, but the seed.
struct RunControl {
    std::int64_t seed = 1;
    int threads = 0;  ///< 0: as many as the process may use and the grid can feed
};

/// Many runs of one scene.
struct SweepPlan {
    std::vector<std::string> vary;  ///< "relaxation.rate = 1, 2, 3" or "relaxation.rate = 1:2:11"
    int seeds = 1;                  ///< runs at each point
    std::string ramp = "none";      ///< none, up, up-down
    int workers = 0;                ///< 0: the cores the process may use
};

/// What drover stability looks at.
struct StabilityPlan {
    int wavenumbers = 96;   ///< of the map, evenly by their logarithm
    int angles = 46;        ///< of the map, from along p0 to across it
    double min_wavenumber = 0.0;   ///< |q| [1/mm]; 0: a thousandth of the cell's longest wave
    double max_wavenumber = 0.0;    ///< |q| [1/mm]; 0: the shortest wave of the grid
    double sound = 0.0;     ///< |q| of the dynamic structure factor [1/mm]; 0: the cell's longest wave
    int frequencies = 241;  ///< of the dynamic structure factor
};

/// What drover boundary traces.
struct BoundaryPlan {
    std::string x, y;                                                                   ///< "driving.strength = 0.5:2"
    std::vector<std::string> lines{"onset", "phase-separation", "banding", "oblique"};  ///< names of physics::Limit
    std::vector<std::string> conventions;  ///< of lambda, each traced: "mean", "single-rod"; empty: that of the scene
    std::vector<std::string> errors;       ///< "relaxation.rate = 0.02": standard errors
    int cells = 64;                        ///< an island wider than 1/cells of the plane is found
    double chord = 1e-4;                   ///< distance between line and polyline, beside the plane's sides
    int map = 96;                          ///< cells on each side of the map of states; 0: none
};

/// What drover calibrate measures, and how well.
struct CalibrationPlan {
    std::vector<double> bead_area_fractions;  ///< ascending, each > 0
    std::vector<double> rod_area_fractions;   ///< the same, for assays that depend on them
    std::string vary;                         ///< one key more: "kick.strength = 0.01, 0.02"; "": none
    std::vector<std::string> assays;          ///< names; empty: all
    double relative_error = 0.1;              ///< of every wanted quantity
    int round = 16;                           ///< trials between looks
    int max_trials = 512;                     ///< of one assay at one point
    double max_failed = 0.1;                  ///< part of the trials that may fail
    int single_rods = 1;                      ///< rods in the cell of an assay of single rods
    int workers = 0;                          ///< 0: the cores the process may use
};

/// A table of coefficients in place of numbers of the model.
struct CalibratedPlan {
    std::string table;                                         ///< a file that drover calibrate made; "": none
    double bead_area_fraction = 0.0, rod_area_fraction = 0.0;  ///< of the scene; > 0 with a table
    double varied = 0.0;                                       ///< of the key that the table varies, when it has one
    std::string coefficients =
        "uniform";                      ///< uniform: at these area fractions everywhere; local: at those of each place
    std::string outside = "refuse";     ///< refuse or hold: what to do beyond the table
    std::vector<std::string> filled;    ///< written by drover: "drag.coefficient: measured, 3.1 +- 0.2"
    std::vector<std::string> expected;  ///< written by drover: what the mean field of the table expects
};

/// What a scene is made of: one that has a section of particles ([cell], [plates], [beads], [rods], ...) is one of particles.
enum class SceneKind { fields, particles };

struct Scene {
    SceneKind kind = SceneKind::fields;
    std::string file;                              ///< where it came from, for messages
    std::map<std::string, SourceLocation> places;  ///< of the keys that were given: "time.dt"
    physics::Model model;  // of fields, as are grid, dealiasing, initial, stability boundary and calibrated
    numerics::Grid grid;
    physics::Dealiasing dealiasing;
    dem::Setup particles;
    TimeControl time;
    physics::InitialState initial;
    Output output;
    Analysis analysis;
    RunControl run;
    SweepPlan sweep;
    StabilityPlan stability;
    BoundaryPlan boundary;
    CalibratedPlan calibrated;
    CalibrationPlan calibration;  // of particles, as are the plans of its assays
    calibrate::Plans plans;
};

/// Throws an input Error, which says what the command is for, when the scene is not of this kind.
void require_kind(const Scene& scene, SceneKind kind, const std::string& command);

/// Whether a number of the model came from the table of calibrated.table.
bool is_from_table(const Scene& scene, const std::string& key);

/// Where a key was given, or the scene's file when it holds its default.
SourceLocation location_of(const Scene& scene, const std::string& key);

/// Throws an input Error, at its place, when keys do not fit each other.
void check(const Scene& scene);

/// A duration in steps of time.dt; throws an input Error at the place of `key` when it is not a whole number of them.
std::int64_t whole_steps(const Scene& scene, const std::string& key, double duration);

/// A number of the model, by its key.
struct ModelNumber {
    std::string unit;
    Range range;
    std::function<double&(physics::Model&)> in;
};
/// Throws an input Error at `where`, with "did you mean", when no number of the model is called so.
ModelNumber model_number(const std::string& key, const SourceLocation& where);

/// Reads a scene file, then "section.key=value" of each override.  Throws an input Error with file:line:column and a remedy.
Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from a text; `name` stands for the file in messages.
Scene parse_scene(const std::string& toml, const std::string& name, std::span<const std::string> overrides = {});

/// Every key of the scene's kind with its value, as TOML that reads back as the same scene.
std::string resolved_text(const Scene& scene);

/// All that scenes may say; of one kind, with its defaults.
struct SectionDescription {
    std::string name;
    std::string doc;
    std::vector<Description> rows;
    std::string kind;  ///< of the scenes that it belongs to: "fields", "particles", "" for both
};
std::vector<SectionDescription> scene_schema();
std::vector<SectionDescription> scene_schema(SceneKind kind);

}  // namespace drover::io

namespace drover {
template <>
const std::vector<Row<io::TimeControl>>& schema<io::TimeControl>();
template <>
const std::vector<Row<io::Output>>& schema<io::Output>();
template <>
const std::vector<Row<io::Analysis>>& schema<io::Analysis>();
template <>
const std::vector<Row<io::RunControl>>& schema<io::RunControl>();
template <>
const std::vector<Row<io::SweepPlan>>& schema<io::SweepPlan>();
template <>
const std::vector<Row<io::StabilityPlan>>& schema<io::StabilityPlan>();
template <>
const std::vector<Row<io::BoundaryPlan>>& schema<io::BoundaryPlan>();
template <>
const std::vector<Row<io::CalibratedPlan>>& schema<io::CalibratedPlan>();
template <>
const std::vector<Row<io::CalibrationPlan>>& schema<io::CalibrationPlan>();
}  // namespace drover
