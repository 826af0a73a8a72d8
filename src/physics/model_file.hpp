// physics/model_file.hpp: the fields and equations of rod_bead.toml.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "drover/model/model.hpp"

namespace drover::physics {

/// The file, as it is compiled into the library, without its coefficients.
struct RodBead {
    struct Field {
        std::string symbol, name, left;
        std::string unit;  ///< UDUNITS text, or "[p]"
        std::string meaning;
        int spin = 0;
        std::string mass;
        bool conserved = false;
        bool perturbed = false;  ///< its first component is the default of initial.field
        std::string noise;       ///< key of its strength
        model::Observed observed;
        std::vector<std::pair<std::string, std::string>> terms;  ///< key and formula
    };
    std::vector<Field> fields;
    std::vector<std::pair<std::string, std::string>> currents;  ///< of the rods, by kind
};
const RodBead& rod_bead();
/// All of it, as JSON.
const char* model_file();

/// J of a current.kind: "u p".
const std::string& current_of(const std::string& kind);
/// order_is_density: the order is sigma times the mean orientation.
std::string unit_of(const RodBead::Field& field, bool order_is_density);

}  // namespace drover::physics
