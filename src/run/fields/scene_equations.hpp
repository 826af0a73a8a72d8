// run/fields/scene_equations.hpp: the equations of a scene of fields, whatever they are.
#pragma once
#include "drover/theory/theory.hpp"
#include "io/scene.hpp"
#include "model/field_evolution.hpp"
#include "physics/written_model.hpp"

namespace drover::run {

/// What a run integrates, about the state of the references; a function of the calling program may be missing.
model::Integrated compiled_of(const io::Scene& scene);
/// The same.  Throws an input Error where a function is missing.
model::Integrated integrated_of(const io::Scene& scene);
/// Whether steps of the scene make less than half of slow changes about these means: see part_of_slow_change.
bool stands_still(const io::Scene& scene, const model::Equations& equations, const model::UniformState& means);
/// The same; a model of one's own about the means of its start where steps about the references stand still.
model::Integrated about_start(const io::Scene& scene, model::Integrated what);
/// What approximation.counterterm adds to the growth of order [1/s].
double counterterm_of(const io::Scene& scene);
/// What a run of the scene integrates: with that rate, about_start; theory is of the scene as it is.
model::Integrated integrated_in_run(const io::Scene& scene);
/// The equations alone: a function of the calling program may be missing.
model::Equations equations_of(const io::Scene& scene);

/// A term that depends on position or time, so that there is no uniform state; "": none.
std::string placed_term_of(const io::Scene& scene, const model::Equations& equations);

/// The references with the conserved means of a state, which a start may have set apart from them.
model::UniformState with_conserved_means(const model::Equations& equations, const model::UniformState& sample);
/// Those of the start of a scene: of its formulas, not of its file.
model::UniformState conserved_start(const io::Scene& scene, const model::Equations& equations);

/// Their uniform stationary states at the mean densities of the scene, without sources at points.
theory::StationaryStates uniform_states_of(const io::Scene& scene, const model::Equations& equations);
/// None where a term depends on position or time.
theory::StationaryStates stationary_states_of(const io::Scene& scene, const model::Equations& equations);

/// The coefficient that a key names, "coefficients.a" or "a".  Throws an input Error at `where`, which begins with
/// `list`, for any other key, and names `others`, which the list may have too.
std::string coefficient_of(const io::Scene& scene, const std::string& list, const std::string& key,
                           const SourceLocation& where, std::span<const std::string> others = {});

/// A number of its equations.
struct SceneNumber {
    std::string key;  ///< "relaxation.rate", "coefficients.a"
    std::string unit = "1";
    double value = 0.0;
};
/// list: what names it.  Throws an input Error at `where` for a key that is no number of the equations.
SceneNumber number_of(const io::Scene& scene, const std::string& list, const std::string& key,
                      const SourceLocation& where);
/// One for messages: the first coefficient that is not 0, or else a side of the cell.
SceneNumber example_number(const io::Scene& scene);
/// Its assignment in quotes.
std::string example_of_number(const io::Scene& scene);
/// An observable of the scene, for messages.
std::string example_observable(const io::Scene& scene);

/// The key of the coefficient of a term in the equation of a field, as "lap u" of u; "": there is none.
std::string key_of_term(const io::Scene& scene, const model::Equations& equations, const model::Field& field,
                        const std::string& factor);
/// The terms that have powers, in the order of model::EnergyBudget: by the keys of their coefficients, or as they are
/// written, after the symbol of their field where several fields have terms.
std::vector<std::string> names_of_terms(const io::Scene& scene, const model::Equations& equations);
/// Where tables of coefficients end that hold the values at their edges.
std::vector<physics::HeldRange> held_ranges(const io::Scene& scene);

/// The scene with another value of a number.
io::Scene scene_with(const io::Scene& scene, const std::string& key, double value);

}  // namespace drover::run
