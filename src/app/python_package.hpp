// app/python_package.hpp: commands that the Python package carries out.
#pragma once
#include <string>
#include <vector>

namespace drover::app {

/// Becomes `python3 -m drover.PART ARGUMENTS`, which carries out `command`, with the package beside the program; does
/// not return then.  Throws an input Error where there is no Python.  What the part imports and is missing is named.
int run_python_package(const std::string& command, const std::string& part, const std::vector<std::string>& arguments);

}  // namespace drover::app
