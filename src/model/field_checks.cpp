// model/field_checks.cpp: numbers, ranks and left sides of fields.
#include "model/field_checks.hpp"

#include <cmath>

#include "model/algebra.hpp"

namespace drover::model {

void check_fields(const Model& model) {
    constexpr std::size_t max_fields = 64;  // symbols are dense matrices
    require(model.fields.size() <= max_fields, model.fields.empty() ? SourceLocation{} : model.fields.back().where,
            "the model has {} fields; expected at most {}", model.fields.size(), max_fields);
    for (const auto& [name, value] : model.coefficients)
        require(std::isfinite(value), {}, "the coefficient {} is {}; expected a finite number", name, value);
    for (const Field& field : model.fields) {
        require(std::isfinite(field.noise) && field.noise >= 0.0, field.where,
                "the noise of {} is {}; expected a finite number >= 0", field.name, field.noise);
        require(std::isfinite(field.reference), field.where, "the reference of {} is {}; expected a finite number",
                field.name, field.reference);
        require(field.reference == 0.0 || (field.spin == 0 && !field.odd), field.where,
                "the reference of {}, which is {}, is {}; expected 0, the isotropic state", field.name,
                rank_text({0, field.spin}, field.odd ? Parity::odd : Parity::even), field.reference);
        const bool is_held = field.left == LeftSide::balance;
        require(!is_held || (field.noise == 0.0 && field.mass.text.empty()), field.where,
                "{} is in balance and has a {}; expected none, since it has no rate", field.name,
                field.noise != 0.0 ? "noise" : "mass");
        require(!field.solenoidal || field.spin == 1, field.where,
                "{} is declared as solenoidal, and is {}; expected a vector", field.name,
                rank_text({0, field.spin}, field.odd ? Parity::odd : Parity::even));
        require(!field.solenoidal || field.further.empty(), field.where,
                "{} is declared as solenoidal, and has terms that are written apart; expected one equation",
                field.name);
        require(!field.conserved || field.noise == 0.0 || field.noise_conserves, field.where,
                "{} is conserved, and its noise is not; expected conserved_noise = true", field.name);
    }
}

}  // namespace drover::model
