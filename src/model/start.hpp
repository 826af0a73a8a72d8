// model/start.hpp: the fields of a model at the start of a run.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/base/threads.hpp"
#include "drover/model/equations.hpp"

namespace drover::model {

/// A component of a state, as files and figures have it.
struct StateComponent {
    std::string name, unit, meaning;
    std::size_t field = 0;
    int part = 0;  ///< 0 or 1: the first or second component of its field
};
/// In the order of Equations::state_components().
std::vector<StateComponent> components_of_state(const Equations& equations);
/// Those in balance, in the order of ExplicitPart::balanced().
std::vector<StateComponent> components_in_balance(const Equations& equations);

/// Whether a term reads a source at a point.
bool has_source(const Model& model, const TermSummary& term);

enum class StartKind { uniform, random, mode, stationary, formula, file };
constexpr auto names_of(StartKind) { return std::array{"uniform", "random", "mode", "stationary", "formula", "file"}; }

/// The initial state of a run: a perturbation of the references, or a frame of an archive.
struct Start {
    StartKind kind = StartKind::uniform;
    double amplitude = 0.0;  ///< of random or mode, in the unit of the field; formula: of added random noise
    std::string component;   ///< of mode; "": the first
    int mode_x = 1, mode_y = 0;
    double phase = 0.0;  ///< of mode [rad]
    /// Of formula, by component: in x, y and the sides of the cell, lx and ly [mm]; none: the reference.
    std::map<std::string, Text> formulas = {};
    std::string file = {};  ///< of file: an archive
    int frame = -1;         ///< of file: -1 is the last

    static Rows<Start> rows();
};

/// Throws an input Error, at the keys of [initial], for a component that the model does not have, a mode that the grid
/// does not keep, formulas with another kind, one that is not finite in every cell or of whose variance the grid cuts
/// more than half, a file without a name, and a stationary start of a state that has none.
void check(const Start& start, const Equations& equations, const numerics::Grid& grid, int degree,
           const Locate& locate);

/// The references with the means of formulas.  Those of a file are not known here.
UniformState means_of_start(const Start& start, const Equations& equations, const numerics::Grid& grid);

/// A start by formulas without one, formulas that the grid cuts or that jump at a periodic edge, and divergences that
/// are removed, each with a remedy.
std::vector<std::string> start_warnings(const Start& start, const Equations& equations, const numerics::Grid& grid,
                                        int degree);

/// Removes from divergence-free fields of a state what has a divergence, which pressure would do at once.
void remove_divergence(const Equations& equations, const numerics::Grid& grid, numerics::Spectra& state);

/// The fields of every kind except file, without divergence where a field is declared so.  Throws as check().
numerics::Spectra start_spectra(const Start& start, const Equations& equations, const numerics::System& system,
                                std::uint64_t seed, Threads& threads);

}  // namespace drover::model
