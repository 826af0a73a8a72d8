// tests/physics/registry.cpp: what follows from the registry of coefficients, with one more row.
#include "drover/physics/coefficient_registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drover/physics/compiled_model.hpp"

namespace drover::physics::registry_tests {
namespace {

/// A coefficient that no source file knows of.
CoefficientRegistry with_one_more() {
    CoefficientRegistry rows = coefficient_registry();
    rows.push_back({.section = "relaxation",
                    .name = "chirality",
                    .symbol = "Omega",
                    .unit = "rad/s",
                    .range = not_negative,
                    .doc = "rotation of the order, in d_t p = Omega z x p",
                    .needs = needs_rod_density,
                    .value = [](Model& m) -> double& { return m.parameters["relaxation.chirality"]; },
                    .monomials = [](Model& m) -> std::vector<std::string>& { return m.relaxation.rate_terms; }});
    return rows;
}

const ModelKey* key_of(const std::vector<ModelSection>& sections, const std::string& section, const std::string& name) {
    for (const ModelSection& one : sections)
        for (const ModelKey& key : one.keys)
            if (one.name == section && key.description.name == name) return &key;
    return nullptr;
}

TEST(CoefficientRegistry, puts_a_new_coefficient_into_the_schema_and_the_tables) {
    const std::vector<ModelSection> sections = model_sections(with_one_more());
    const ModelKey* key = key_of(sections, "relaxation", "chirality");
    ASSERT_NE(key, nullptr);
    EXPECT_EQ(key->description.unit, "rad/s");
    EXPECT_THAT(key->description.doc, testing::HasSubstr("Omega: rotation of the order"));
    Model model;
    key->set(model, 0.4);
    EXPECT_EQ(std::get<double>(key->get(model)), 0.4);
    EXPECT_THROW(checked_value(key->description, "relaxation", {.value = -1.0, .where = {}}), Error) << "its range";
    for (const char* name : {"relaxation_chirality", "relaxation_chirality_error"}) {
        const ModelKey* column = key_of(sections, "table", name);
        ASSERT_NE(column, nullptr) << name;
        EXPECT_EQ(column->description.unit, "rad/s");
        column->set(model, std::vector<double>{1.0, 2.0});
    }
    EXPECT_EQ(model.table.column("relaxation.chirality").values.size(), 2u);
    EXPECT_EQ(model.table.column("relaxation.chirality").errors.size(), 2u);
}

TEST(CoefficientRegistry, puts_a_new_coefficient_into_checks_explanations_and_documentation) {
    const CoefficientRegistry rows = with_one_more();
    Model model{.fields = {.rod_density = false}};
    model.parameters["relaxation.chirality"] = 0.4;
    try {
        check_numbers(model, no_location, rows);
        FAIL() << "a coefficient of a missing field was accepted";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("relaxation.chirality is given, but fields.rod_density"));
    }
    model.fields.rod_density = true;
    EXPECT_NO_THROW(check_numbers(model, no_location, rows));
    bool explained = false;
    for (const CoefficientValue& one : coefficient_values(model, rows))
        explained = explained || (one.key == "relaxation.chirality" && one.symbol == "Omega" && one.unit == "rad/s");
    EXPECT_TRUE(explained);
    EXPECT_THAT(coefficient_documentation(rows), testing::HasSubstr("| Omega | `relaxation.chirality` * | rad/s |"));
}

}  // namespace
}  // namespace drover::physics::registry_tests
