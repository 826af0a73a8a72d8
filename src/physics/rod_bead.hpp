// physics/rod_bead.hpp: the equations of rod_bead.toml, and those of a model of it.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drover/model/model.hpp"
#include "drover/physics/compiled_model.hpp"

namespace drover::physics {

/// The file, as it is compiled into the library.
struct RodBead {
    struct Field {
        std::string symbol, name, left;
        int spin = 0;
        std::string mass;
        bool conserved = false;
        std::string noise;                                       ///< key of its strength
        std::vector<std::pair<std::string, std::string>> terms;  ///< key and formula
    };
    std::vector<Field> fields;
    std::vector<std::pair<std::string, std::string>> currents;  ///< of the rods, by kind
};
const RodBead& rod_bead();
/// All of it, as JSON.
const char* model_file();

/// Which equations are written.
enum class Written {
    forces,  ///< with the velocity as a field whose rate is the force
    solver   ///< with its inertia or its balance
};

/// The equations of a model.  only: names of the terms that are written; nullptr: all.
struct WrittenModel {
    model::Model model;
    std::vector<std::string> terms;  ///< names of the terms of all fields, in the order of the model
};
WrittenModel write_model(const CompiledModel& model, Written as, const std::vector<std::string>* only);

/// "d_t p: K3 lap p, K3 = 0.5 mm^2/s" for each of these terms.
std::vector<std::string> described_terms(const CompiledModel& model, const std::vector<std::string>& names);

/// What the terms of another model are of those of this one, by key where it is not 1: each term of the file is
/// proportional to its coefficient.  Nothing where more than constant coefficients differ.
std::optional<std::map<std::string, double>> ratios_of_terms(const CompiledModel& model, const CompiledModel& other);

}  // namespace drover::physics
