// physics/coefficient.cpp: reading and evaluating coefficients that depend on the densities.
#include "drover/physics/coefficient.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace drover::physics {

namespace {
constexpr int largest_power = 6;

/// Parses a power such as "rho" or "sigma^2"; false for anything else.
bool read_power(const std::string& word, Monomial& into) {
    for (const auto& [name, power] : {std::pair{"rho", &into.beads}, std::pair{"sigma", &into.rods}}) {
        const std::string symbol = name;
        if (word == symbol) {
            *power += 1;
            return true;
        }
        if (word.rfind(symbol + "^", 0) != 0) continue;
        std::size_t used = 0;
        const std::string number = word.substr(symbol.size() + 1);
        if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos || number.size() > 2)
            return false;
        *power += std::stoi(number, &used);
        return true;
    }
    return false;
}

double power(double base, int exponent) {
    double result = 1.0;
    for (int i = 0; i < exponent; ++i) result *= base;
    return result;
}
}  // namespace

std::string range_text(const numerics::SplineTable& table) {
    std::string range;
    for (const auto& [name, axis] : {std::pair{"bead", &table.first()}, std::pair{"rod", &table.second()}})
        if (axis->size() > 1)
            range += text("{}{} density {} to {}", range.empty() ? "" : ", ", name, axis->front(), axis->back());
    return range;
}

Monomial read_monomial(const std::string& written, const SourceLocation& where) {
    constexpr const char* expected = "expected a number and powers of rho and sigma, such as \"-0.5 rho sigma^2\"";
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
    require(result.beads + result.rods >= 1, where, "\"{}\" contains no power of a density; {}", written, expected);
    require(result.beads + result.rods <= largest_power, where,
            "\"{}\" has degree {}; expected at most {}: higher degrees leave too few dealiased modes", written,
            result.beads + result.rods, largest_power);
    return result;
}

Coefficient::Coefficient(double constant, std::vector<Monomial> monomials)
    : constant_(constant), monomials_(std::move(monomials)) {
    std::erase_if(monomials_, [](const Monomial& monomial) { return monomial.factor == 0.0; });
}

Dependence Coefficient::at(double bead_density, double rod_density) const {
    if (table_) {
        const numerics::TableValue found = table_->at(bead_density, rod_density);
        return {found.value, found.by_first, found.by_second};
    }
    Dependence sum{.value = constant_};
    for (const Monomial& m : monomials_) {
        const double beads = power(bead_density, m.beads), rods = power(rod_density, m.rods);
        sum.value += m.factor * beads * rods;
        if (m.beads > 0) sum.by_beads += m.factor * m.beads * power(bead_density, m.beads - 1) * rods;
        if (m.rods > 0) sum.by_rods += m.factor * m.rods * power(rod_density, m.rods - 1) * beads;
    }
    return sum;
}

bool Coefficient::depends_on_beads() const {
    if (table_) return table_->depends_on_first();
    return std::any_of(monomials_.begin(), monomials_.end(), [](const Monomial& m) { return m.beads > 0; });
}

bool Coefficient::depends_on_rods() const {
    if (table_) return table_->depends_on_second();
    return std::any_of(monomials_.begin(), monomials_.end(), [](const Monomial& m) { return m.rods > 0; });
}

int Coefficient::degree() const {
    if (table_) return varies() ? 1 : 0;
    int most = 0;
    for (const Monomial& m : monomials_) most = std::max(most, m.beads + m.rods);
    return most;
}

void Coefficient::evaluate(const double* bead_density, const double* rod_density, double reference,
                           std::span<double> out) const {
    if (table_) {
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] =
                table_->at(bead_density ? bead_density[i] : 0.0, rod_density ? rod_density[i] : 0.0).value - reference;
        return;
    }
    std::fill(out.begin(), out.end(), constant_ - reference);
    for (const Monomial& m : monomials_)
        for (std::size_t i = 0; i < out.size(); ++i) {
            double product = m.factor;
            for (int k = 0; k < m.beads; ++k) product *= bead_density[i];
            for (int k = 0; k < m.rods; ++k) product *= rod_density[i];
            out[i] += product;
        }
}

std::string Coefficient::text_of() const {
    if (table_) return "from a table of " + range_text(*table_);
    std::string result = monomials_.empty() || constant_ != 0.0 ? text("{}", constant_) : "";
    for (const Monomial& m : monomials_) {
        const bool first = result.empty();
        result += first ? text("{}", m.factor) : text(" {} {}", m.factor < 0.0 ? "-" : "+", std::abs(m.factor));
        for (const auto& [symbol, exponent] : {std::pair{"rho", m.beads}, std::pair{"sigma", m.rods}})
            if (exponent > 0) result += exponent == 1 ? text(" {}", symbol) : text(" {}^{}", symbol, exponent);
    }
    return result;
}

}  // namespace drover::physics
