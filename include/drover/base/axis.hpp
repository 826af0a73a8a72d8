// base/axis.hpp: an axis of arrays.
#pragma once
#include <string>
#include <vector>

namespace drover {

/// An axis of an observable, of a summary row, and of a dataset, where it is a dimension scale.
struct Axis {
    std::string name;            ///< "x"
    std::string unit;            ///< UDUNITS text; "1" for a pure number
    std::string meaning;         ///< for people; a CF comment in a file
    std::vector<double> values;  ///< coordinates
};

}  // namespace drover
