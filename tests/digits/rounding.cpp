// tests/digits/rounding.cpp: a library to preload, which sets the rounding mode of a program: that of $ROUNDING, "up",
// "down" or "zero"; otherwise to nearest.  New threads inherit it.
#include <cfenv>
#include <cstdlib>
#include <string_view>

namespace {
[[gnu::constructor]] void set_rounding_mode() {
    const char* given = std::getenv("ROUNDING");
    const std::string_view mode = given ? given : "";
    if (mode == "up") std::fesetround(FE_UPWARD);
    if (mode == "down") std::fesetround(FE_DOWNWARD);
    if (mode == "zero") std::fesetround(FE_TOWARDZERO);
}
}  // namespace
