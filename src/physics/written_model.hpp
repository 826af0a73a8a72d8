// physics/written_model.hpp: the equations of a model of a model file, and what messages say of keys and tables.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drover/model/model.hpp"
#include "physics/compiled_model.hpp"
#include "physics/model_file.hpp"

namespace drover::physics {

/// A term of a scene, as texts or a function, in the notation of the model layer.
struct SceneTerm {
    std::string field;     ///< symbol of the field in whose equation it is
    std::string equation;  ///< readable
    model::WrittenTerm written;
};

/// The terms of a model.  Throws an input Error at the place of one that its form cannot have.
std::vector<SceneTerm> scene_terms(const CompiledModel& model);

/// Which equations are written.
enum class Written {
    right_sides,  ///< as if every mass were 1, and a field in balance had a rate
    solver        ///< with masses and balances
};

/// The equations of a model.
struct WrittenModel {
    model::Model model;
    std::vector<std::string> terms;  ///< names of the terms of all fields, in the order of the model
};
WrittenModel write_model(const CompiledModel& model, Written as);

/// What the terms of another model are of those of this one, by key where it is not 1: each term of the file is
/// proportional to its coefficient.  Nothing where more than constant coefficients differ.
std::optional<std::map<std::string, double>> ratios_of_terms(const CompiledModel& model, const CompiledModel& other);

/// The key of the coefficient of a term of the model file, whether a scene has the term or not: "diffusion.rods" of
/// "lap sigma" in the equation of "sigma"; "": there is no such term.
std::string key_of_term(const std::string& symbol, const std::string& factor);

/// Values of a scalar between which a table has nodes; beyond them, the values at its edge are held.
struct HeldRange {
    std::string symbol;
    double min = 0.0, max = 0.0;
};
/// None of a table that refuses others.
std::vector<HeldRange> held_ranges(const TableData& table);

}  // namespace drover::physics
