// tests/physics/form.cpp: the fields of a form and their names.
#include "drover/physics/form.hpp"

#include <gtest/gtest.h>

namespace drover::physics::form_tests {
namespace {

TEST(Form, rods_alone_have_one_scalar_and_one_vector_named_in_the_order_of_the_components) {
    EXPECT_EQ(layout(rods_only), (numerics::scalars_and_vectors(1, 1)));
    const auto names = component_names(rods_only);
    ASSERT_EQ(names.size(), 3u);
    EXPECT_EQ(names[0].name, "rod_density");
    EXPECT_EQ(names[1].name, "polar_order_x");
    EXPECT_EQ(names[2].name, "polar_order_y");
    for (const Component& component : names) {
        EXPECT_EQ(component.unit, "mm-2");
        EXPECT_FALSE(component.meaning.empty());
    }
}

TEST(Form, an_absent_field_has_no_component) {
    const Form order_alone{.polar_order = 0};
    EXPECT_EQ(layout(order_alone), (numerics::scalars_and_vectors(0, 1)));
    ASSERT_EQ(component_names(order_alone).size(), 2u);
    EXPECT_EQ(component_names(order_alone)[0].name, "polar_order_x");
    EXPECT_TRUE(component_names(Form{}).empty());
}

}  // namespace
}  // namespace drover::physics::form_tests
