// dem/setup.cpp: what the keys of a particle world ask of each other.
#include "drover/dem/setup.hpp"
namespace drover::dem { void check(const Setup&, const PlaceOf&) {} }
