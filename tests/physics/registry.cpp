// tests/physics/registry.cpp: what follows from a model file, with one more coefficient.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/start.hpp"
#include "physics/equations.hpp"
#include "physics/model_keys.hpp"

namespace drover::physics::registry_tests {
namespace {

/// With a coefficient that no source file knows of.
ModelFile with_one_more() {
    ModelFile file = shipped_model();
    file.coefficients.push_back({.id = "relaxation.chirality",
                                 .symbol = "Omega",
                                 .unit = "rad/s",
                                 .range = not_negative,
                                 .doc = "rotation of the order, in d_t p = Omega z x p",
                                 .needs = {"sigma"},
                                 .varies = true});
    return file;
}

const ModelKey* key_of(const std::vector<ModelSection>& sections, const std::string& section, const std::string& name) {
    for (const ModelSection& one : sections)
        for (const ModelKey& key : one.keys)
            if (one.name == section && key.description.name == name) return &key;
    return nullptr;
}

TEST(ModelFile, puts_a_new_coefficient_into_the_schema_and_the_tables) {
    const ModelFile file = with_one_more();
    const std::vector<ModelSection> sections = model_sections(file);
    const ModelKey* key = key_of(sections, "relaxation", "chirality");
    ASSERT_NE(key, nullptr);
    EXPECT_EQ(key->description.unit, "rad/s");
    EXPECT_THAT(key->description.doc, testing::HasSubstr("Omega: rotation of the order"));
    ModelValues model(file);
    EXPECT_EQ(std::get<double>(key->get(model)), 0.0);
    key->set(model, 0.4);
    EXPECT_EQ(std::get<double>(key->get(model)), 0.4);
    EXPECT_EQ(number(model, "relaxation.chirality"), 0.4);
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

TEST(ModelFile, puts_a_new_coefficient_into_checks_explanations_and_documentation) {
    const ModelFile file = with_one_more();
    ModelValues model(file);
    model.values["fields.rod_density"] = false;
    number_in(model, "relaxation.chirality") = 0.4;
    try {
        CompiledModel{model};
        FAIL() << "a coefficient of a missing field was accepted";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("relaxation.chirality is given, but fields.rod_density"));
    }
    model.values["fields.rod_density"] = true;
    EXPECT_NO_THROW(CompiledModel{model});
    bool explained = false;
    for (const CoefficientValue& one : coefficient_values(model))
        explained = explained || (one.key == "relaxation.chirality" && one.symbol == "Omega" && one.unit == "rad/s");
    EXPECT_TRUE(explained);
    EXPECT_THAT(coefficient_documentation(file), testing::HasSubstr("| Omega | `relaxation.chirality` * | rad/s |"));
}

TEST(ModelFile, of_rods_and_beads_has_the_components_that_a_scene_chooses) {
    ModelValues model;
    const auto components = [&] { return model::components_of_state(Equations(model).solver()); };
    const auto names = [&] {
        std::vector<std::string> found;
        for (const model::StateComponent& one : components()) found.push_back(one.name);
        return found;
    };
    EXPECT_THAT(names(), testing::ElementsAre("rod_density", "polar_order_x", "polar_order_y"));
    EXPECT_EQ(form_name(model), "rods only");
    for (const model::StateComponent& one : components()) EXPECT_EQ(one.unit, "mm-2");
    model.values["fields.bead_density"] = true;
    model.values["fields.bead_velocity"] = std::string("dynamic");
    model.values["drag.coefficient"] = 1.0;
    EXPECT_THAT(names(), testing::ElementsAre("bead_density", "rod_density", "bead_velocity_x", "bead_velocity_y",
                                              "polar_order_x", "polar_order_y"));
    EXPECT_EQ(form_name(model), "two-component");
    model.values["fields.bead_velocity"] = std::string("slaved");  // it follows the others
    EXPECT_EQ(names().size(), 4u);
    EXPECT_EQ(form_name(model), "overdamped");
    model.values["fields.bead_density"] = false;
    EXPECT_EQ(form_name(model), "polar order, rod density, slaved bead velocity");
}

TEST(ModelValues, of_a_key_that_the_file_does_not_have_are_an_error) {
    EXPECT_THROW(number(ModelValues(), "relaxation.chirality"), Error);
}

}  // namespace
}  // namespace drover::physics::registry_tests
