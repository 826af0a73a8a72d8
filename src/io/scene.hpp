// io/scene.hpp: a scene (input file) as data: everything that defines a run.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calibrate/catalogue.hpp"
#include "calibrate/field_model.hpp"
#include "drover/base/schema.hpp"
#include "drover/dem/setup.hpp"
#include "drover/numerics/grid.hpp"
#include "io/declared_model.hpp"
#include "io/units.hpp"
#include "model/start.hpp"
#include "numerics/steppers/kept_modes.hpp"
#include "physics/model_keys.hpp"

namespace drover::io {

/// Time stepping.
struct TimeControl {
    double dt = 0.0;                 ///< step [s]; 0: run::with_chosen_step() finds it; particles: dt_of_particles
    double end = 1.0;                ///< [s]
    std::string stepper = "etdrk2";  ///< a row of numerics::stepper_tables()
    double tolerance = 0.0;          ///< local error relative to the field; 0: fixed steps dt
    double max_error = 0.01;         ///< estimated error of the fields above which a run warns; 0: no estimate

    static Rows<TimeControl> rows();
};

inline constexpr double dt_of_particles = 2e-5;

/// Output files and intervals.
struct Output {
    std::string file;                 ///< "": the scene's name with .h5, in the working folder
    double frame_every = 1.0;         ///< time between frames [s]; 0: the first and the last only
    double sample_every = 0.1;        ///< time between samples of the observables [s]
    double checkpoint_minutes = 5.0;  ///< wall time between checkpoints
    bool powers = false;              ///< samples include the energy and the power of each term

    static Rows<Output> rows();
};

/// Time averages.
struct Analysis {
    double warm_up = -1.0;  ///< time omitted at the start [s]; -1: estimated from the series

    static Rows<Analysis> rows();
};

/// What the equations leave out.
struct Approximation {
    bool quasi_linear = false;        ///< generalised: short waves interact with long ones only
    double quasi_linear_above = 0.0;  ///< the largest |q| of a long wave [1/mm]; 0: only the means are long
    bool counterterm = false;         ///< the saturation of the order without that by fluctuations of independent rods

    static Rows<Approximation> rows();
};

/// The errors of the results of a run.
struct Accuracy {
    double effort = 0.05;  ///< of the work of a run, to measure what the time step makes wrong; 0: no biases
    bool biases = true;    ///< whether those of the results are measured; not in runs that have none

    static Rows<Accuracy> rows();
};

/// Seed and threads.
struct RunControl {
    std::int64_t seed = 1;
    int threads = 0;  ///< 0: the available cores, capped where more would be slower

    static Rows<RunControl> rows();
};

enum class Ramp { none, up, up_down };
constexpr auto names_of(Ramp) { return std::array{"none", "up", "up-down"}; }

/// What a sweep keeps of its runs.
enum class Kept { archives, table };
constexpr auto names_of(Kept) { return std::array{"archives", "table"}; }

/// Many runs of one scene.
struct SweepPlan {
    std::vector<std::string> vary;  ///< "relaxation.rate = 1, 2, 3" or "relaxation.rate = 1:2:11"
    int seeds = 1;                  ///< runs at each point; with wanted errors the least number of them
    std::vector<std::string> want;  ///< "polar_order=2%"
    int max_seeds = 64;             ///< with wanted errors
    Ramp ramp = Ramp::none;
    std::vector<std::string> refine;  ///< "polar_order = 0.1"
    int refine_levels = 3;            ///< times that a cell is halved at most
    Kept keep = Kept::archives;
    int workers = 0;  ///< 0: the cores the process may use

    static Rows<SweepPlan> rows();
};

/// Input of drover stability.
struct StabilityPlan {
    int wavenumbers = 96;         ///< of the map, logarithmically spaced
    int angles = 46;              ///< of the map, from parallel to p0 to perpendicular
    double min_wavenumber = 0.0;  ///< |q| [1/mm]; 0: 1/1000 of the smallest of the cell
    double max_wavenumber = 0.0;  ///< |q| [1/mm]; 0: the largest of the grid
    double sound = 0.0;           ///< |q| of the dynamic structure factor [1/mm]; 0: the smallest of the cell
    int frequencies = 241;        ///< of the dynamic structure factor

    static Rows<StabilityPlan> rows();
};

/// Input of drover boundary.
struct BoundaryPlan {
    std::string x, y;                                                                   ///< "driving.strength = 0.5:2"
    std::vector<std::string> lines{"onset", "phase-separation", "banding", "oblique"};  ///< run::line_names()
    std::vector<std::string> conventions;  ///< of lambda: "mean", "single-rod"; empty: the scene's
    std::vector<std::string> errors;       ///< "relaxation.rate = 0.02": standard errors
    int draws = 100;                       ///< of uncertain numbers, for the error bands; 0: no bands
    int cells = 64;                        ///< islands wider than 1/cells of the plane are found
    double chord = 1e-4;                   ///< distance between line and polyline, relative to the plane
    int map = 96;                          ///< cells along each side of the map of states; 0: no map

    static Rows<BoundaryPlan> rows();
};

/// Input of drover calibrate.
struct CalibrationPlan {
    std::vector<double> bead_area_fractions;  ///< ascending, each > 0
    std::vector<double> rod_area_fractions;   ///< the same, for assays that depend on rods
    std::string vary;                         ///< an additional key: "kick.strength = 0.01, 0.02"; "": none
    std::vector<std::string> assays;          ///< names; empty: all
    double relative_error = 0.1;              ///< target for every wanted quantity
    int round = 16;                           ///< trials between two evaluations of the error
    int max_trials = 512;                     ///< of one assay at one point
    double max_failed = 0.1;                  ///< fraction of the trials that may fail
    int single_rods = 1;                      ///< rods in the cell of an assay of single rods
    int workers = 0;                          ///< 0: the cores the process may use

    static Rows<CalibrationPlan> rows();
};

/// At the area fractions of the scene, or at the local densities.
enum class CoefficientsOf { uniform, local };
constexpr auto names_of(CoefficientsOf) { return std::array{"uniform", "local"}; }

/// A table of coefficients that replaces numbers of the model.
struct CalibratedPlan {
    std::string table;                                         ///< a file written by drover calibrate; "": none
    double bead_area_fraction = 0.0, rod_area_fraction = 0.0;  ///< of the scene; > 0 with a table
    double varied = 0.0;                                       ///< of the key that the table varies, when it has one
    CoefficientsOf coefficients = CoefficientsOf::uniform;
    numerics::Outside outside = numerics::Outside::refuse;

    static Rows<CalibratedPlan> rows();
};

/// By what time.dt was chosen: not at all, since it was given; the error of the fields, of time means; a linear model.
enum class ChosenBy { given, fields, means, linear };
constexpr auto names_of(ChosenBy) { return std::array{"", "fields", "means", "linear"}; }

/// How a time step was found.
struct StepChoice {
    ChosenBy by = ChosenBy::given;
    std::string pilot;  ///< the error and the pilot runs that chose dt
};

/// What drover found for a scene, and writes among the inputs of a resolved one: time.chosen, time.pilot,
/// calibrated.filled and calibrated.expected.
struct Found {
    StepChoice step;
    std::vector<calibrate::FilledNumber> filled;  ///< numbers that the table gave to the model
    std::vector<std::string> expected;            ///< mean-field predictions of the table
};

/// A scene with a section of particles ([cell], [plates], [beads], [rods], ...) is a scene of particles, one that
/// declares fields ([[field]]) is a scene of a model of one's own.
enum class SceneKind { fields, particles, model };
constexpr auto names_of(SceneKind) { return std::array{"fields", "particles", "model"}; }

inline bool has_grid(SceneKind kind) { return kind != SceneKind::particles; }

struct Scene {
    SceneKind kind = SceneKind::fields;
    std::string file;                              ///< its origin, for messages
    std::map<std::string, SourceLocation> places;  ///< of the given keys: "time.dt"
    physics::ModelValues model;  // of fields, as are grid, dealiasing, initial, stability, boundary, calibrated
    numerics::Grid grid;
    numerics::Dealiasing dealiasing;
    Approximation approximation;  // of fields and models
    dem::Setup particles;
    DeclaredModel declared;  // of a model, which also has grid, dealiasing, initial
    TimeControl time;
    model::Start initial;  // file: relative to the scene
    Output output;
    Analysis analysis;
    Accuracy accuracy;  // of fields
    Units units;        // of fields and models
    RunControl run;
    SweepPlan sweep;
    StabilityPlan stability;
    BoundaryPlan boundary;
    CalibratedPlan calibrated;
    CalibrationPlan calibration;  // of particles, as are the plans of its assays
    calibrate::Plans plans;
    Found found;  // all others are inputs
};

/// The kind of that name.  Throws an input Error for another name.
SceneKind kind_of_name(const std::string& name);

/// Throws an input Error when the scene is not of the kind that the command needs.
void require_kind(const Scene& scene, SceneKind kind, const std::string& command);
/// The same for a command on fields of any model.
void require_grid(const Scene& scene, const std::string& command);

/// The initial state where a scene has no [initial].
model::Start default_start(SceneKind kind);
/// The degree that decides which modes of a model of one's own are kept.
int kept_degree(const Scene& scene, const model::Equations& equations);

/// Whether a number of the model came from the table of calibrated.table.
bool is_from_table(const Scene& scene, const std::string& key);

/// The model with its calibrated numbers drawn within their errors, and all that follows from them; `count` copies of
/// a model without such numbers.  Fewer where draws are out of the range of their keys.  Throws an input Error at
/// calibrated.table if that file is no more there.
std::vector<physics::ModelValues> drawn_models(const Scene& scene, int count);

/// Where a key was given, or the scene's file for a default.
SourceLocation locate(const Scene& scene, const std::string& key);

/// A file that the file of a scene names: in its folder if it exists there, else as given.
std::filesystem::path beside(const std::string& scene_file, const std::string& given);

/// Throws an input Error, at the key, when keys are inconsistent.
void check(const Scene& scene);

/// Whether some field of a scene of fields has noise.
bool has_noise(const Scene& scene);

/// A duration in steps of time.dt; throws an input Error at `key` when it is not an integer number of steps.
std::int64_t whole_steps(const Scene& scene, const std::string& key, double duration);
/// The same in seconds: steps times time.dt, from which the decimals of the scene may differ by rounding.
double whole_interval(const Scene& scene, const std::string& key, double duration);

/// The longest step of which the end and the intervals of the outputs are whole numbers.  Throws an input Error when
/// there is none of at least a thousandth of the shortest.
double longest_step(const Scene& scene);
/// With the longest step where the scene leaves its choice to a run.
Scene with_step(Scene scene);

/// A number of the model, by its key.
struct ModelNumber {
    std::string unit;
    Range range;
    std::function<double&(physics::ModelValues&)> in;
};
/// Throws an input Error at `where`, with "did you mean", when the model has no number of this name.
/// Of the parameters of terms it knows those that `model` has: "terms.W".
ModelNumber model_number(const std::string& key, const SourceLocation& where, const physics::ModelValues& model);

/// What drover found, of the tables of a resolved scene.
Found found_in(const LocatedTables& tables);
/// The scene of these tables, with defaults for absent keys; not yet filled from a calibrated table, nor checked.
/// Throws an input Error for an unknown key or table, a value out of range, or tables of both kinds.
Scene scene_of(const LocatedTables& tables, const std::string& file);

/// Every key of the scene's kind with its value, as tables that read back as the same scene.
LocatedTables tables_of(const Scene& scene);
/// The same as TOML.
std::string resolved_text(const Scene& scene);
/// The chosen part of it, by section and key: "sweep" and "sweep.keep"; without the model.
std::string chosen_text(const Scene& scene, const std::function<bool(const std::string& section_or_key)>& is_chosen);

/// A section of the schema; of one kind, with its defaults.
struct SectionDescription {
    std::string name;
    std::string doc;
    std::vector<Description> rows;
    std::vector<SceneKind> kinds;  ///< of the scenes that have it; empty: all
};
std::vector<SectionDescription> scene_schema(const physics::ModelFile& file = physics::shipped_model());
std::vector<SectionDescription> scene_schema(SceneKind kind);
/// UDUNITS text of a key of a scene; "1" for a pure number and for a coefficient of a model of one's own.
std::string unit_of(SceneKind kind, const std::string& key);
/// A unit of a key in results: [p] is that of the order, "mm^2/s" of "[p]^2 mm^2/s" where it has none, and others have
/// the names of the scene.
std::string unit_in_results(const Scene& scene, const std::string& unit);

/// Reads a scene file, applies "section.key=value" of each override, fills in the calibrated table and checks the
/// result. Throws an input Error with file:line:column and a suggested fix.
Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from a text; messages call it `name`.  `functions`: those that its terms name.
Scene parse_scene(const std::string& toml, const std::string& name, std::span<const std::string> overrides = {},
                  const physics::TermFunctions& functions = {});

/// A scene with "section.key=value" of each change, checked as one that is read.
Scene changed(const Scene& scene, const std::vector<std::string>& overrides);

/// The scene in an archive, to read the archive: its terms may be functions that this program does not have.
Scene archived_scene(const std::string& toml, const std::string& name);

}  // namespace drover::io
