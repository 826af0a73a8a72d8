// tests/files/record_identity.cpp: scene texts of versions of drover that know other keys.
#include "files/record_folder.hpp"

#include <gtest/gtest.h>

namespace drover::files::record_identity_tests {
namespace {

TEST(SceneTexts, are_the_same_where_a_key_that_one_lacks_has_its_default) {
    const std::string defaults = "[run]\nseed = 1\nthreads = 0\n\n[cell]\nlx = 5.0\n";
    const std::string older = "[run]\nseed = 7\n", newer = "[run]\nseed = 7\nthreads = 0\n\n[cell]\nlx = 5.0\n";
    EXPECT_TRUE(are_same(older, older, ""));
    EXPECT_TRUE(are_same(older, newer, defaults));
    EXPECT_TRUE(are_same(newer, older, defaults));
    EXPECT_FALSE(are_same(older, "[run]\nseed = 7\nthreads = 2\n", defaults));
    EXPECT_FALSE(are_same(older, "[run]\nseed = 8\nthreads = 0\n", defaults));
    EXPECT_FALSE(are_same(older, "[run]\nseed = 7\nnote = 0\n", defaults));  // a key that has no default any more
}

}  // namespace
}  // namespace drover::files::record_identity_tests
