// tests/model/evolution.cpp: runs of a model in memory: how they continue, and what they reject.
#include "drover/model/evolution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/refusal.hpp"

namespace drover::model::evolution_tests {
namespace {

constexpr numerics::Grid grid{.nx = 8, .ny = 6, .lx = 8.0, .ly = 6.0};

Equations one_scalar(const std::string& equation, double noise = 0.0) {
    return Equations({.fields = {{.name = "u", .symbol = "u", .equation = {equation, {}}, .noise = noise}}});
}

TEST(Evolution, continued_in_another_object_is_that_of_one_object_bit_for_bit) {
    const Equations equations = one_scalar("cos(t) - u^3 + lap u", 0.1);
    Evolution whole(equations, {.grid = grid, .dt = 0.25, .seed = 3});
    whole.advance(7);
    const numerics::Fields between = whole.fields();
    whole.set_fields(between);  // rounds as the set_fields of the continued run
    whole.advance(5);
    Evolution rest(equations, {.grid = grid, .dt = 0.25, .seed = 3, .first_step = 7});
    EXPECT_EQ(rest.time(), 1.75);
    rest.set_fields(between);
    rest.advance(5);
    EXPECT_EQ(rest.step(), 12);
    EXPECT_EQ(rest.fields().values, whole.fields().values);
    Evolution anew(equations, {.grid = grid, .dt = 0.25, .seed = 3});
    anew.set_fields(between);
    anew.advance(5);
    EXPECT_NE(anew.fields().values, whole.fields().values);
    rest = std::move(anew);
    EXPECT_EQ(rest.step(), 5);
}

TEST(Evolution, rejects_fields_of_another_grid_or_number_and_keeps_its_own) {
    Evolution run(one_scalar("-u"), {.grid = grid, .dt = 0.1});
    numerics::Fields other(grid, 1), none(grid, 1);
    other.size *= 2;
    none.size = 0;
    for (const numerics::Fields& fields : {other, none, numerics::Fields({.nx = 4, .ny = 4}, 3)})
        EXPECT_NE(refusal_of([&] { run.set_fields(fields); }).find("expected 48"), std::string::npos);
    run.advance(1);
    EXPECT_EQ(run.fields().values, numerics::Fields(grid, 1).values);
    EXPECT_THROW(run.advance(-1), Error);
    EXPECT_THROW(Evolution(one_scalar("-u"), {.grid = grid, .dt = 0.1, .first_step = -1}), Error);
}

TEST(Evolution, that_diverged_is_advanced_only_with_other_fields) {
    Evolution run(one_scalar("u^3"), {.grid = grid, .dt = 1.0});
    numerics::Fields fields(grid, 1);
    fields.values.assign(fields.values.size(), 1e100);
    run.set_fields(fields);
    EXPECT_NE(refusal_of([&] { run.advance(8); }).find("the run diverged"), std::string::npos);
    EXPECT_NE(refusal_of([&] { run.advance(1); }).find("expected other fields first"), std::string::npos);
    fields.values.assign(fields.values.size(), 1e-3);
    run.set_fields(fields);
    EXPECT_NO_THROW(run.advance(1));
}

}  // namespace
}  // namespace drover::model::evolution_tests
