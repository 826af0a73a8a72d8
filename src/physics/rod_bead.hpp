// physics/rod_bead.hpp: the equations of rod_bead.toml, and those of a model of it.
#pragma once
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

/// Which equations are written.
enum class Written {
    forces,  ///< with the velocity as a field whose rate is the force
    solver   ///< with its inertia or its balance
};

/// The equations of a model.  only: names of the terms that are written; nullptr: all.
struct WrittenModel {
    model::Model model;
    struct Name {
        std::string name, equation;
    };
    std::vector<Name> terms;  ///< of all fields, in the order of the model
};
WrittenModel write_model(const CompiledModel& model, Written as, const std::vector<std::string>* only);

}  // namespace drover::physics
