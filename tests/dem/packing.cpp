// tests/dem/packing.cpp: dummy for a trial of speed.
#include "drover/dem/packing.hpp"
#include <gtest/gtest.h>
#include <chrono>
#include <cstdlib>
namespace drover::dem {
TEST(Trial, trial) {
    dem::Setup s; s.cell.lx = s.cell.ly = std::atof(getenv("L")); s.beads.area_fraction = std::atof(getenv("B")); s.rods.area_fraction = std::atof(getenv("R"));
    if (getenv("POLY")) { s.beads.diameters = {0.6,0.7,0.8,0.9,1.0}; s.beads.parts = {1,1,1,1,1}; }
    auto t = std::chrono::steady_clock::now();
    try { auto p = pack(s, 1); printf("rounds %d\n", p.rounds); } catch (std::exception& e) { puts(e.what()); }
    printf("%s %s: %.2f s\n", getenv("B"), getenv("R"), std::chrono::duration<double>(std::chrono::steady_clock::now()-t).count());
}
}
