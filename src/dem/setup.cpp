// dem/setup.cpp: the rows of the sections of a particle world, and what its keys ask of each other.
#include "drover/dem/setup.hpp"
