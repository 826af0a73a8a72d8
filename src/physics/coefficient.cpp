// physics/coefficient.cpp: reading and evaluating coefficients that depend on the densities.
#include "physics/coefficient.hpp"

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
}  // namespace

std::string range_text(const numerics::SplineTable& table) {
    std::string range;
    const std::vector<const FieldRow*> fields = densities();
    for (std::size_t k = 0; k < fields.size(); ++k) {
        const auto& axis = k == 0 ? table.first() : table.second();
        if (axis.size() < 2) continue;
        range += text("{}{} {} to {}", range.empty() ? "" : ", ", words_of(*fields[k]), axis.front(), axis.back());
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

}  // namespace drover::physics
