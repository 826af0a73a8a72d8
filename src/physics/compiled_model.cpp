// physics/compiled_model.cpp: reading and evaluating coefficients that depend on the densities; compiling those of a
// model, and checking its numbers.
#include "physics/compiled_model.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/mapped.hpp"
#include "physics/model_file.hpp"

namespace drover::physics {

namespace {
constexpr int largest_power = 6;

/// Parses a power such as "rho" or "sigma^2"; false for anything else.
bool read_power(const std::string& word, Monomial& into) {
    const std::vector<const FieldRow*> fields = densities();
    for (std::size_t k = 0; k < fields.size(); ++k) {
        const std::string& symbol = fields[k]->symbol;
        if (word == symbol) {
            into.powers[k] += 1;
            return true;
        }
        if (word.rfind(symbol + "^", 0) != 0) continue;
        const std::string number = word.substr(symbol.size() + 1);
        if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos || number.size() > 2)
            return false;
        into.powers[k] += std::stoi(number);
        return true;
    }
    return false;
}

double power(double base, int exponent) {
    double result = 1.0;
    for (int i = 0; i < exponent; ++i) result *= base;
    return result;
}

/// "rho and sigma".
std::string symbols() { return joined(mapped(densities(), &FieldRow::symbol), " and "); }

int degree_of(const Monomial& monomial) { return monomial.powers[0] + monomial.powers[1]; }

Coefficient tabulated(const std::vector<double>& nodes, const TableData& table, double factor) {
    const auto axis = [](const std::vector<double>& at) { return at.empty() ? std::vector<double>{0.0} : at; };
    std::vector<double> values = nodes;
    for (double& value : values) value *= factor;
    return Coefficient(std::make_shared<numerics::SplineTable>(axis(table.nodes[0]), axis(table.nodes[1]),
                                                               std::move(values), table.outside));
}

/// What a coefficient contains of another, which lowers it: a monomial of that density, or a number where it is none of
/// the fields.
void add_lowered(const ModelValues& model, const CoefficientRow& other, double& constant,
                 std::vector<Monomial>& monomials) {
    const std::vector<const FieldRow*> fields = densities(*model.file);
    for (std::size_t k = 0; k < fields.size(); ++k) {
        if (fields[k]->symbol != other.times) continue;
        Monomial one{.factor = -number(model, other.key())};
        one.powers[k] = 1;
        if (presence(model, *fields[k]) != Presence::absent) monomials.push_back(one);
        else constant += one.factor * number(model, fields[k]->reference);
    }
}

/// The coefficient that lowers this one; nullptr if there is none or it is 0.
const CoefficientRow* lowered_by(const ModelValues& model, const std::string& key) {
    for (const CoefficientRow& other : model.file->coefficients)
        if (other.lowers == key && number(model, other.key()) != 0.0) return &other;
    return nullptr;
}

double factor_in(const ModelValues& model, const CoefficientRow& row) {
    return row.factor_key.empty() ? 1.0 : factor_of(row, word(model, row.factor_key));
}

Coefficient compiled(const CoefficientRow& row, const ModelValues& model, const Locate& locate) {
    const TableColumn& column = model.table.column(row.key());
    const std::vector<double>&nodes = column.values, &errors = column.errors;
    const std::vector<std::string>& written = monomials_of(model, row.key());
    const double factor = factor_in(model, row);
    const CoefficientRow* other = lowered_by(model, row.key());
    const bool is_number = nodes.empty() && errors.empty() && written.empty();
    if (is_number && other == nullptr) return factor * number(model, row.key());
    const std::string name = "table." + row.section() + "_" + row.name(), monomial_key = row.key() + "_terms";
    require(errors.empty() || errors.size() == nodes.size(), locate(name + "_error"),
            "{}_error has {} values and {} has {}; expected equal numbers, or no errors", name, errors.size(), name,
            nodes.size());
    if (!nodes.empty()) {
        if (other != nullptr)
            fail_input(locate(other->key()),
                       "{} and {} are both given; expected one of them: a table of the rate contains -{} {}",
                       other->key(), name, other->symbol, other->times);
        require(written.empty(), locate(monomial_key), "{} and {} are both given; expected one of them", monomial_key,
                name);
        try {
            return tabulated(nodes, model.table, factor);
        } catch (const Error& error) {
            fail_input(locate(name), "{}: {}", name, error.what());
        }
    }
    std::vector<Monomial> monomials;
    for (const std::string& monomial : written) {
        monomials.push_back(read_monomial(monomial, locate(monomial_key)));
        monomials.back().factor *= factor;
    }
    double constant = factor * number(model, row.key());
    if (other != nullptr) add_lowered(model, *other, constant, monomials);
    return {constant, std::move(monomials)};
}

/// Whether the coefficient has the same table in both models.
bool has_same_table(const CoefficientRow& row, const ModelValues& model, const ModelValues& other) {
    const TableData &here = model.table, &there = other.table;
    const std::vector<double>& nodes = here.column(row.key()).values;
    return !nodes.empty() && nodes == there.column(row.key()).values && here.nodes == there.nodes &&
           here.outside == there.outside && factor_in(model, row) == factor_in(other, row);
}

/// The key of a field that is not there; nullptr for one that is.  needs_rate: in a balance it is not, either.
const std::string* missing_key(const ModelValues& model, const std::string& symbol, bool needs_rate) {
    for (const FieldRow& field : model.file->fields) {
        if (field.symbol != symbol) continue;
        const Presence how = presence(model, field);
        if (how == Presence::absent || (needs_rate && how == Presence::balance)) return &field.present;
    }
    return nullptr;
}

const std::string* missing_key(const ModelValues& model, const CoefficientRow& row) {
    for (const std::string& symbol : row.needs)
        if (const std::string* key = missing_key(model, symbol, symbol == row.noise_of)) return key;
    return nullptr;
}

/// A number of an absent field is an error in the scene.
void check_fields(const ModelValues& model, const std::map<std::string, Coefficient>& coefficients,
                  const Locate& locate) {
    const auto refuse = [&](const std::string& key, const std::string* missing) {
        if (missing != nullptr)
            fail_input(locate(key), "{} is given, but {} excludes its field; set it to 0 or include the field", key,
                       *missing);
    };
    const ModelFile& file = *model.file;
    for (const CoefficientRow& row : file.coefficients)
        if (coefficients.at(row.key()).is_active()) refuse(row.key(), missing_key(model, row));
    for (const KeyRow& row : file.keys)
        if (!row.needs.empty() && !is_standard(model, row.key()))
            refuse(row.key(), missing_key(model, row.needs, row.needs_rate));
    const std::vector<const FieldRow*> fields = densities(file);
    for (const auto& [key, coefficient] : coefficients)
        for (std::size_t k = 0; k < fields.size(); ++k) {
            if (presence(model, *fields[k]) != Presence::absent) continue;
            require(!coefficient.depends_on(k), locate(text("{}_terms", key)),
                    "{} depends on the {}, which {} excludes; include the field", key, words_of(fields[k]->name),
                    fields[k]->present);
        }
}

/// "the densities 1 (bead_density) and 2 (rod_density)".
std::string densities_text(const ModelFile& file, const Densities& at) {
    std::string result;
    const std::vector<const FieldRow*> fields = densities(file);
    for (std::size_t k = 0; k < fields.size(); ++k)
        result += text("{}{} ({})", k == 0 ? "" : " and ", at[k], fields[k]->observed.short_name);
    return result;
}

/// A field that a scene asks for has something that changes it.
void check_moved(const ModelValues& model, const Locate& locate) {
    const ModelFile& file = *model.file;
    for (const FieldRow& field : file.fields) {
        if (!field.conserved || field.present.empty() || is_standard(model, field.present)) continue;
        if (presence(model, field) == Presence::absent) continue;
        const bool has_text =
            std::ranges::any_of(model.text_terms, [&](const TextTerm& term) { return term.of == field.alias; });
        const bool has_term = std::ranges::any_of(field.terms, [&](const TermRow& term) {
            const auto row = std::ranges::find(file.coefficients, term.key, &CoefficientRow::key);
            return row == file.coefficients.end() ? has_fields(model, term.needs) : number(model, term.key) != 0.0;
        });
        require(has_text || has_term || number(model, field.noise) != 0.0, locate(field.present),
                "{} is given, and nothing in this scene changes the {}: no term and no noise; give one, or exclude the "
                "field",
                field.present, words_of(field.name));
    }
}
}  // namespace

std::string range_text(const numerics::SplineTable& table) {
    std::string range;
    const std::vector<const FieldRow*> fields = densities();
    for (std::size_t k = 0; k < fields.size(); ++k) {
        const auto& axis = k == 0 ? table.first() : table.second();
        if (axis.size() < 2) continue;
        range += text("{}{} {} to {}", range.empty() ? "" : ", ", words_of(fields[k]->name), axis.front(), axis.back());
    }
    return range;
}

Monomial read_monomial(const std::string& written, const SourceLocation& where) {
    const std::string expected = text("expected a number and powers of {}, such as \"-0.5 {} {}^2\"", symbols(),
                                      densities().front()->symbol, densities().back()->symbol);
    std::istringstream words(written);
    Monomial result;
    std::string word;
    require(static_cast<bool>(words >> word), where, "\"{}\" is not a polynomial term; {}", written, expected);
    char* end = nullptr;
    result.factor = std::strtod(word.c_str(), &end);
    require(*end == '\0' && std::isfinite(result.factor), where,
            "\"{}\" is not a polynomial term: \"{}\" is not a number; {}", written, word, expected);
    while (words >> word)
        require(read_power(word, result), where, "\"{}\" is not a polynomial term: unknown factor \"{}\"; {}", written,
                word, expected);
    require(degree_of(result) >= 1, where, "\"{}\" contains no power of a density; {}", written, expected);
    require(degree_of(result) <= largest_power, where,
            "\"{}\" has degree {}; expected at most {}: higher degrees leave too few dealiased modes", written,
            degree_of(result), largest_power);
    return result;
}

Coefficient::Coefficient(double constant, std::vector<Monomial> monomials)
    : constant_(constant), monomials_(std::move(monomials)) {
    std::erase_if(monomials_, [](const Monomial& monomial) { return monomial.factor == 0.0; });
}

double Coefficient::at(const Densities& densities) const {
    if (table_) return table_->at(densities[0], densities[1]).value;
    double sum = constant_;
    for (const Monomial& m : monomials_)
        sum += m.factor * power(densities[0], m.powers[0]) * power(densities[1], m.powers[1]);
    return sum;
}

bool Coefficient::depends_on(std::size_t density) const {
    if (table_) return density == 0 ? table_->depends_on_first() : table_->depends_on_second();
    return std::ranges::any_of(monomials_, [density](const Monomial& m) { return m.powers[density] > 0; });
}

int Coefficient::degree() const {
    if (table_) return varies() ? 1 : 0;
    int max_degree = 0;
    for (const Monomial& m : monomials_) max_degree = std::max(max_degree, degree_of(m));
    return max_degree;
}

std::string Coefficient::text_of() const {
    if (table_) return "from a table of " + range_text(*table_);
    const std::vector<const FieldRow*> fields = densities();
    std::string result = monomials_.empty() || constant_ != 0.0 ? text("{}", constant_) : "";
    for (const Monomial& m : monomials_) {
        const bool first = result.empty();
        result += first ? text("{}", m.factor) : text(" {} {}", m.factor < 0.0 ? "-" : "+", std::abs(m.factor));
        for (std::size_t k = 0; k < fields.size(); ++k)
            if (const int exponent = m.powers[k]; exponent > 0)
                result += " " + fields[k]->symbol + (exponent == 1 ? "" : text("^{}", exponent));
    }
    return result;
}

CompiledModel::CompiledModel(const ModelValues& the_model, const Locate& locate, const CompiledModel* like)
    : model(the_model) {
    for (const CoefficientRow& row : model.file->coefficients)
        coefficients.emplace(row.key(), like != nullptr && has_same_table(row, model, like->model)
                                            ? like->coefficient(row.key())
                                            : compiled(row, model, locate));
    check_fields(model, coefficients, locate);
    check_moved(model, locate);
    try {
        require_values(*this, mean_densities(model));
    } catch (const Error& error) {
        fail_input(locate(densities(*model.file).back()->reference), "{}", error.what());
    }
}

bool is_in_mass(const FieldRow& field, const FieldRow& density) {
    return std::ranges::find(field.mass_factors, density.symbol) != field.mass_factors.end();
}

double mass_factor(const CompiledModel& model, const FieldRow& field) {
    const ModelFile& file = *model.model.file;
    double product = 1.0;
    for (const std::string& factor : field.mass_factors) {
        for (const CoefficientRow& row : file.coefficients)
            if (row.symbol == factor) product *= model.coefficient(row.key()).at({});
        for (const FieldRow* density : densities(file))
            if (density->symbol == factor && presence(model.model, *density) == Presence::absent)
                product *= number(model.model, density->reference);
    }
    return product;
}

void require_values(const CompiledModel& model, const Densities& at) {
    for (const auto& [key, coefficient] : model.coefficients)
        if (!std::isfinite(coefficient.at(at)))
            fail_input(
                {},
                "{} is not defined at the densities {}, outside its table of {}; use densities inside the table, or "
                "set table.outside = \"hold\"",
                key, densities_text(*model.model.file, at),
                coefficient.table() ? range_text(*coefficient.table()) : "");
}

}  // namespace drover::physics
