// base/eigen_templates.cpp: compiles what eigen_templates.hpp declares.
#define DROVER_EIGEN_TEMPLATE template
#include "base/eigen_templates.hpp"
