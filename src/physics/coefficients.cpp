// physics/coefficients.cpp: columns of a table, and the keys of external forces and fields.
#include "drover/physics/coefficients.hpp"

#include <algorithm>

namespace drover::physics {

bool has_noise(const Noise& noise) {
    return noise.order != 0.0 || noise.velocity != 0.0 || noise.rods != 0.0 || noise.beads != 0.0;
}

const TableColumn& TableData::column(const std::string& key) const {
    static const TableColumn none;
    const auto found = columns.find(key);
    return found == columns.end() ? none : found->second;
}

bool TableData::has_values() const {
    return std::any_of(columns.begin(), columns.end(), [](const auto& one) { return !one.second.values.empty(); });
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::BodyForce>>& schema<physics::BodyForce>() {
    static const std::vector<Row<physics::BodyForce>> rows{
        {.name = "kind",
         .member = &physics::BodyForce::kind,
         .choices = {"none", "uniform", "point"},
         .doc = "external force on the beads: uniform, or at a fixed or moving point"},
        {.name = "x",
         .member = &physics::BodyForce::x,
         .unit = "mg/(mm s^2), point: mg mm/s^2",
         .doc = "x component: a force per area when uniform, a force at a point"},
        {.name = "y", .member = &physics::BodyForce::y, .unit = "mg/(mm s^2), point: mg mm/s^2", .doc = "y component"},
        {.name = "at_x",
         .member = &physics::BodyForce::at_x,
         .unit = "mm",
         .doc = "point: its position at t = 0, along x"},
        {.name = "at_y",
         .member = &physics::BodyForce::at_y,
         .unit = "mm",
         .doc = "point: its position at t = 0, along y"},
        {.name = "velocity_x",
         .member = &physics::BodyForce::velocity_x,
         .unit = "mm/s",
         .doc = "point: its velocity along x"},
        {.name = "velocity_y",
         .member = &physics::BodyForce::velocity_y,
         .unit = "mm/s",
         .doc = "point: its velocity along y"},
        {.name = "width",
         .member = &physics::BodyForce::width,
         .unit = "mm",
         .range = not_negative,
         .doc = "point: standard deviation of its Gaussian profile; 0: band-limited point force"}};
    return rows;
}

template <>
const std::vector<Row<physics::OrientingField>>& schema<physics::OrientingField>() {
    static const std::vector<Row<physics::OrientingField>> rows{
        {.name = "x", .member = &physics::OrientingField::x, .unit = "[p]/s", .doc = "h_x, in d_t p = h"},
        {.name = "y", .member = &physics::OrientingField::y, .unit = "[p]/s", .doc = "h_y, in d_t p = h"}};
    return rows;
}

template <>
const std::vector<Row<physics::Approximation>>& schema<physics::Approximation>() {
    static const std::vector<Row<physics::Approximation>> rows{
        {.name = "quasi_linear",
         .member = &physics::Approximation::quasi_linear,
         .doc = "short waves act on the long ones and these on them, and not short waves on each other"},
        {.name = "quasi_linear_above",
         .member = &physics::Approximation::quasi_linear_above,
         .unit = "1/mm",
         .range = not_negative,
         .doc = "with quasi_linear: the largest |q| of a long wave; 0: only the means are long"}};
    return rows;
}

}  // namespace drover
