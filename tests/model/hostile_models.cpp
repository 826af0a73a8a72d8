// tests/model/hostile_models.cpp: malformed and hostile models are rejected at their place.
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>

#include "drover/model/equations.hpp"

namespace drover::model::hostile_models_tests {
namespace {

constexpr int field_line = 9, equation_line = 10, mass_line = 11;

Field field_of(const std::string& symbol, int spin, const std::string& equation, bool odd = false) {
    return {.name = symbol + "_field",
            .symbol = symbol,
            .spin = spin,
            .odd = odd,
            .equation = {equation, {"model.toml", equation_line, 1}},
            .where = {"model.toml", field_line, 1}};
}

/// The model that hostile_models.txt describes, without its first field.
Model surroundings() {
    Model model;
    for (const auto& [symbol, spin] : {std::pair{"phi", 0}, {"psi", 0}, {"p", 1}, {"v", 1}, {"Q", 2}, {"T", 3}})
        model.fields.push_back(field_of(symbol, spin, ""));
    for (const auto& [symbol, spin] : {std::pair{"omega", 0}, {"w", 1}})
        model.fields.push_back(field_of(symbol, spin, "", true));
    model.coefficients = {{"a", 0.3}, {"K", 1.0}, {"zero", 0.0}};
    model.definitions = {{"mu", {"phi^3 - phi - lap phi", {"model.toml", 30, 1}}},
                         {"J", {"phi p", {"model.toml", 31, 1}}}};
    return model;
}

std::string repeated(const std::string& part, int times) {
    std::string result;
    for (int i = 0; i < times; ++i) result += part;
    return result;
}

/// Compiles a model up to what a solver needs.
void expect_rejected(const Model& model, const std::string& place, const std::string& described) {
    const std::string what = described.substr(0, 100);
    try {
        const Equations equations(model);
        ADD_FAILURE() << "accepted: " << what;
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input) << what;
        EXPECT_EQ(error.place(), place) << what << "\n" << error.what();
        EXPECT_NE(error.message().find("expected"), std::string::npos) << what << "\n" << error.what();
        EXPECT_LT(error.message().size(), 1500u) << what;
    }
}
std::string at(int line, int column) { return text("model.toml:{}:{}", line, column); }

/// "s spin 1 odd mass {1 + phi} = lap s".
Field read_field(const std::string& line, bool& has_mass) {
    const std::size_t equals = line.find(" = ");
    std::istringstream words(line.substr(0, equals));
    std::string word;
    words >> word;
    Field field = field_of(word, 0, line.substr(equals + 3));
    has_mass = false;
    while (words >> word) {
        if (word == "spin") words >> field.spin;
        field.odd = field.odd || word == "odd";
        field.conserved = field.conserved || word == "conserved";
        if (word == "balance") field.left = LeftSide::balance;
        if (word == "mass") {
            const std::size_t begin = line.find('{') + 1;
            field.mass = {line.substr(begin, line.find('}') - begin), {"model.toml", mass_line, 1}};
            has_mass = true;
            break;
        }
    }
    return field;
}

TEST(HostileModels, with_a_wrong_equation_are_rejected_at_its_column) {
    std::ifstream file(DROVER_TESTS "/model/hostile_models.txt");
    int count = 0;
    for (std::string line; std::getline(file, line);) {
        if (line[0] == '#') continue;
        const std::size_t bar = line.find(" | ");
        const int column = std::stoi(line.substr(0, bar));
        Model model = surroundings();
        bool has_mass = false;
        model.fields.insert(model.fields.begin(), read_field(line.substr(bar + 3), has_mass));
        if (column == 0) expect_rejected(model, at(field_line, 1), line);
        else expect_rejected(model, at(has_mass ? mass_line : equation_line, column), line);
        ++count;
    }
    EXPECT_GE(count, 300);
}

TEST(HostileModels, that_nest_or_grow_without_limit_are_rejected_at_a_column) {
    const auto expect_at = [](int column, int spin, const std::string& equation) {
        Model model = surroundings();
        model.fields.insert(model.fields.begin(), field_of("s", spin, equation));
        expect_rejected(model, at(equation_line, column), equation);
    };
    expect_at(201, 0, repeated("(", 300) + "phi" + repeated(")", 300));
    expect_at(202, 0, repeated("-", 300) + "phi");
    expect_at(804, 0, repeated("sin(", 300) + "phi" + repeated(")", 300));
    expect_at(805, 0, repeated("lap ", 300) + "phi");
    expect_at(1, 0, repeated("phi + ", 3000) + "phi");
    expect_at(1, 0, "phi" + repeated(" ", 10000));
    expect_at(2800, 1, repeated("Q.", 2000) + "p");                                     // a chain of dots
    expect_at(1, 0, repeated("lap ", 17) + "phi");                                      // order 34
    expect_at(76, 0, "phi " + repeated("lap ", 17) + "phi^2");                          // no parentheses
    expect_at(5, 0, "psi lap lap lap lap lap lap(phi^1000 psi^999)");                   // the product rule
    expect_at(5, 0, "psi lap lap lap lap(sin(phi) exp(psi) / (1 + |p|^2 cosh(phi)))");  // likewise
    expect_at(576, 1, repeated("p.grad(", 90) + "p" + repeated(")", 90));  // 2^90 steps if each were read twice
}

TEST(HostileModels, with_wrong_definitions_are_rejected_at_the_definition) {
    const auto expect_at = [](int column, const std::vector<Definition>& definitions) {
        Model model = surroundings();
        model.fields.insert(model.fields.begin(), field_of("s", 0, "lap s"));  // uses none of them
        for (Definition definition : definitions) {
            definition.value.where = {"model.toml", 20, 1};
            model.definitions.push_back(definition);
        }
        expect_rejected(model, at(20, column), definitions[0].name);
    };
    expect_at(1, {{"f", {"f", {}}}});
    expect_at(5, {{"f", {"1 + f", {}}}});
    expect_at(3, {{"f", {"2 g", {}}}, {"g", {"2 f", {}}}});
    expect_at(1, {{"f", {"g", {}}}, {"g", {"h", {}}}, {"h", {"f + 1", {}}}});
    expect_at(1, {{"f", {"foo", {}}}});
    expect_at(3, {{"f", {"p p", {}}}});
    expect_at(1, {{"f", {"div phi", {}}}});
    expect_at(1, {{"f", {"", {}}}});
    expect_at(7, {{"f", {"phi + omega", {}}}});
    for (const char* name : {"p",    "phi",   "p_x", "Q_xy", "T_1", "phi_field", "x", "y",  "t",   "a",   "mu", "sin",
                             "grad", "outer", "pi",  "e_x",  "e_y", "d_x",       "",  "1a", "a b", "a.b", "a-b"})
        expect_at(1, {{name, {"1", {}}}});
    std::vector<Definition> chain;
    for (int i = 0; i < 3000; ++i) chain.push_back({text("f{}", i), {text("f{} + phi", i + 1), {}}});
    chain.push_back({"f3000", {"1", {}}});
    expect_at(1, chain);
    std::vector<Definition> orders;
    for (int i = 0; i < 40; ++i) orders.push_back({text("f{}", i), {i == 0 ? "phi" : text("lap lap f{}", i - 1), {}}});
    expect_at(5, orders);
}

TEST(HostileModels, with_wrong_fields_are_rejected_at_the_field) {
    const auto expect_field = [](const Field& field) {
        Model model = surroundings();
        model.fields.push_back(field);
        expect_rejected(model, at(field_line, 1), field.symbol);
    };
    const Field valid = field_of("s", 0, "lap s");
    const auto with = [&](auto change) {
        Field field = valid;
        change(field);
        return field;
    };
    for (const char* symbol : {"p", "phi", "p_x", "Q_xx", "x", "t", "a", "grad", "sin", "pi", "e_x", "d_y", "", "2s",
                               "s s", "σ", "s.t", "phi_field"})
        expect_field(with([&](Field& f) { f.symbol = symbol, f.equation.text = ""; }));
    expect_field(with([](Field& f) { f.name = "phi"; }));
    expect_field(with([](Field& f) { f.name = "two words"; }));
    expect_field(with([](Field& f) { f.symbol = "e", f.spin = 1, f.equation.text = ""; }));  // its component e_x
    for (const int spin : {-1, 7, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()})
        expect_field(with([&](Field& f) { f.spin = spin; }));
    constexpr double infinite = std::numeric_limits<double>::infinity(),
                     none = std::numeric_limits<double>::quiet_NaN();
    for (const double value : {infinite, none, -1.0}) expect_field(with([&](Field& f) { f.noise = value; }));
    for (const double value : {infinite, none}) expect_field(with([&](Field& f) { f.reference = value; }));
    expect_field(with([](Field& f) { f.odd = true, f.reference = 1.0; }));
    expect_field(with([](Field& f) { f.spin = 1, f.reference = 1.0; }));
    expect_field(with([](Field& f) { f.conserved = true, f.noise = 1.0; }));
    expect_field(with([](Field& f) { f.left = LeftSide::balance, f.equation.text = "lap s - s", f.noise = 1.0; }));
    expect_field(with([](Field& f) { f.left = LeftSide::balance, f.equation.text = "lap s - s", f.mass.text = "2"; }));
    expect_field(with([](Field& f) { f.left = LeftSide::balance, f.equation.text = ""; }));
    Model many = surroundings();
    for (int i = 0; i < 1000; ++i) many.fields.push_back(field_of(text("s{}", i), 1, ""));
    expect_rejected(many, at(field_line, 1), "1000 fields");
    Model held{.fields = {with([](Field& f) { f.left = LeftSide::balance, f.equation.text = "-s"; })}};
    expect_rejected(held, at(field_line, 1), "no field with a rate");
    Model mass = surroundings();
    mass.fields[0].mass = {"foo", {"model.toml", mass_line, 1}};
    expect_rejected(mass, at(mass_line, 1), "a mass without an equation");
    for (const double value : {infinite, none}) {
        Model model = surroundings();
        model.coefficients["a"] = value;
        expect_rejected(model, "", "coefficient");  // coefficients have no place
    }
}

}  // namespace
}  // namespace drover::model::hostile_models_tests
