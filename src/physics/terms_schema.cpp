// physics/terms_schema.cpp: what a scene may say of each term.
#include "drover/physics/terms.hpp"

namespace drover {

using namespace physics;

namespace {
constexpr const char* monomials = "monomials in the densities that are added to it, such as \"-0.5 rho sigma^2\"";
}

template <>
const std::vector<Row<RodCurrent>>& schema<RodCurrent>() {
    static const std::vector<Row<RodCurrent>> rows{
        {.name = "speed", .member = &RodCurrent::speed, .unit = "mm/s", .doc = "u: speed of rods along the order"},
        {.name = "kind",
         .member = &RodCurrent::kind,
         .choices = {"order", "density-order"},
         .doc = "order: J = u p, p being sigma times the mean orientation [1/mm^2]; density-order: J = u sigma p, p "
                "being the mean orientation itself [1]; [p] is the unit of p"}};
    return rows;
}

template <>
const std::vector<Row<Inertia>>& schema<Inertia>() {
    static const std::vector<Row<Inertia>> rows{{.name = "bead_mass",
                                                 .member = &Inertia::bead_mass,
                                                 .unit = "mg",
                                                 .range = positive,
                                                 .doc = "m: mass of a bead"},
                                                {.name = "advection",
                                                 .member = &Inertia::advection,
                                                 .doc = "whether beads carry their own momentum: m rho v.grad v"}};
    return rows;
}

template <>
const std::vector<Row<Drag>>& schema<Drag>() {
    static const std::vector<Row<Drag>> rows{
        {.name = "coefficient",
         .member = &Drag::coefficient,
         .unit = "mg/(mm^2 s)",
         .range = not_negative,
         .doc = "Gamma: friction of the beads with the plate, in m rho d_t v = -Gamma v"},
        {.name = "coefficient_terms", .member = &Drag::coefficient_terms, .doc = monomials}};
    return rows;
}

template <>
const std::vector<Row<Viscosity>>& schema<Viscosity>() {
    static const std::vector<Row<Viscosity>> rows{{.name = "shear",
                                                   .member = &Viscosity::shear,
                                                   .unit = "mg/s",
                                                   .range = not_negative,
                                                   .doc = "eta, in m rho d_t v = eta lap v"},
                                                  {.name = "bulk",
                                                   .member = &Viscosity::bulk,
                                                   .unit = "mg/s",
                                                   .range = not_negative,
                                                   .doc = "zeta, in m rho d_t v = zeta grad(div v)"}};
    return rows;
}

template <>
const std::vector<Row<Driving>>& schema<Driving>() {
    static const std::vector<Row<Driving>> rows{
        {.name = "strength",
         .member = &Driving::strength,
         .unit = "mg/(mm s^2)/[p]",
         .doc = "alpha: force of the rods on the beads, in m rho d_t v = alpha p"},
        {.name = "strength_terms", .member = &Driving::strength_terms, .doc = monomials}};
    return rows;
}

template <>
const std::vector<Row<Stiffness>>& schema<Stiffness>() {
    static const std::vector<Row<Stiffness>> rows{
        {.name = "beads",
         .member = &Stiffness::beads,
         .unit = "mg mm^2/s^2",
         .doc = "E: pressure of the beads on themselves, in m rho d_t v = -E grad rho"},
        {.name = "rods",
         .member = &Stiffness::rods,
         .unit = "mg mm^2/s^2",
         .doc = "F: pressure of the rods on the beads, in m rho d_t v = -F grad sigma"}};
    return rows;
}

template <>
const std::vector<Row<Relaxation>>& schema<Relaxation>() {
    static const std::vector<Row<Relaxation>> rows{
        {.name = "rate",
         .member = &Relaxation::rate,
         .unit = "1/s",
         .doc = "a: rate at which order decays, in d_t p = -a p; below 0 it grows, and only b stops it"},
        {.name = "rate_terms", .member = &Relaxation::rate_terms, .doc = monomials},
        {.name = "saturation",
         .member = &Relaxation::saturation,
         .unit = "1/s/[p]^2",
         .range = not_negative,
         .doc = "b: what stops the growth of order, in d_t p = -b |p|^2 p"},
        {.name = "saturation_terms", .member = &Relaxation::saturation_terms, .doc = monomials}};
    return rows;
}

template <>
const std::vector<Row<Elasticity>>& schema<Elasticity>() {
    static const std::vector<Row<Elasticity>> rows{
        {.name = "stiffness",
         .member = &Elasticity::stiffness,
         .unit = "mm^2/s",
         .range = not_negative,
         .doc = "K3: resistance of the order to any gradient, in d_t p = K3 lap p"},
        {.name = "splay",
         .member = &Elasticity::splay,
         .unit = "mm^2/s",
         .range = not_negative,
         .doc = "K1: further resistance to splay, in d_t p = K1 grad(div p)"}};
    return rows;
}

template <>
const std::vector<Row<Weathercock>>& schema<Weathercock>() {
    static const std::vector<Row<Weathercock>> rows{
        {.name = "strength",
         .member = &Weathercock::strength,
         .unit = "[p]/mm",
         .doc = "lambda: how the flow of beads orders rods, in d_t p = lambda v; or lambda_s, see convention"},
        {.name = "strength_terms", .member = &Weathercock::strength_terms, .doc = monomials},
        {.name = "convention",
         .member = &Weathercock::convention,
         .choices = {"mean", "single-rod"},
         .doc =
             "what strength is: mean: lambda of the equations; single-rod: lambda_s of one rod that turns as dn/dt = "
             "lambda_s (1 - nn).v, which is what an assay of one rod across a flow measures: lambda = lambda_s/2"}};
    return rows;
}

template <>
const std::vector<Row<SelfAdvection>>& schema<SelfAdvection>() {
    static const std::vector<Row<SelfAdvection>> rows{{.name = "strength",
                                                       .member = &SelfAdvection::strength,
                                                       .unit = "mm/s/[p]",
                                                       .doc = "w: how order carries itself, in d_t p = -w p.grad p"}};
    return rows;
}

template <>
const std::vector<Row<Pressure>>& schema<Pressure>() {
    static const std::vector<Row<Pressure>> rows{
        {.name = "beads",
         .member = &Pressure::beads,
         .unit = "[p] mm^3/s",
         .doc = "A: how rods turn away from crowded beads, in d_t p = -A grad rho"},
        {.name = "rods",
         .member = &Pressure::rods,
         .unit = "[p] mm^3/s",
         .doc = "B: how rods turn away from crowded rods, in d_t p = -B grad sigma; independent rods: u/2"}};
    return rows;
}

template <>
const std::vector<Row<Diffusion>>& schema<Diffusion>() {
    static const std::vector<Row<Diffusion>> rows{{.name = "beads",
                                                   .member = &Diffusion::beads,
                                                   .unit = "mm^2/s",
                                                   .range = not_negative,
                                                   .doc = "D_rho: diffusion of beads, in d_t rho = D_rho lap rho"},
                                                  {.name = "rods",
                                                   .member = &Diffusion::rods,
                                                   .unit = "mm^2/s",
                                                   .range = not_negative,
                                                   .doc =
                                                       "D_sigma: diffusion of rods, in d_t sigma = D_sigma lap sigma"}};
    return rows;
}

template <>
const std::vector<Row<physics::Noise>>& schema<physics::Noise>() {
    static const std::vector<Row<physics::Noise>> rows{
        {.name = "order",
         .member = &physics::Noise::order,
         .unit = "[p]^2 mm^2/s",
         .range = not_negative,
         .doc = "Delta: strength of the white noise on p, <f_i f_j> = Delta delta_ij delta(r - r') delta(t - t')"},
        {.name = "rods",
         .member = &physics::Noise::rods,
         .unit = "1/s",
         .range = not_negative,
         .doc = "strength of the conserved noise on sigma; 2 D_sigma sigma is the shot noise of independent rods, 0 "
                "leaves sigma without shot noise"},
        {.name = "beads",
         .member = &physics::Noise::beads,
         .unit = "1/s",
         .range = not_negative,
         .doc = "strength of the conserved noise on rho"}};
    return rows;
}

template <>
const std::vector<Row<BodyForce>>& schema<BodyForce>() {
    static const std::vector<Row<BodyForce>> rows{
        {.name = "kind",
         .member = &BodyForce::kind,
         .choices = {"none", "uniform", "point"},
         .doc = "a force on the beads: the same everywhere, or at a point that may move"},
        {.name = "x",
         .member = &BodyForce::x,
         .unit = "mg/(mm s^2), point: mg mm/s^2",
         .doc = "its part along x: a force per area when uniform, a force at a point"},
        {.name = "y", .member = &BodyForce::y, .unit = "mg/(mm s^2), point: mg mm/s^2", .doc = "its part along y"},
        {.name = "at_x", .member = &BodyForce::at_x, .unit = "mm", .doc = "point: where it stands at t = 0, along x"},
        {.name = "at_y", .member = &BodyForce::at_y, .unit = "mm", .doc = "point: where it stands at t = 0, along y"},
        {.name = "velocity_x", .member = &BodyForce::velocity_x, .unit = "mm/s", .doc = "point: how it moves along x"},
        {.name = "velocity_y", .member = &BodyForce::velocity_y, .unit = "mm/s", .doc = "point: how it moves along y"},
        {.name = "width",
         .member = &BodyForce::width,
         .unit = "mm",
         .range = not_negative,
         .doc = "point: standard deviation of the Gaussian that it is spread over; 0: all modes of the grid alike"}};
    return rows;
}

template <>
const std::vector<Row<OrientingField>>& schema<OrientingField>() {
    static const std::vector<Row<OrientingField>> rows{
        {.name = "x", .member = &OrientingField::x, .unit = "[p]/s", .doc = "h_x, in d_t p = h"},
        {.name = "y", .member = &OrientingField::y, .unit = "[p]/s", .doc = "h_y, in d_t p = h"}};
    return rows;
}

template <>
const std::vector<Row<TableData>>& schema<TableData>() {
    constexpr const char* values = "at each node, rod density fastest; takes the place of the number in its own table";
    constexpr const char* errors = "standard errors of those values, independent of each other; for drover boundary";
    static const std::vector<Row<TableData>> rows{
        {.name = "bead_density",
         .member = &TableData::bead_density,
         .unit = "1/mm^2",
         .doc = "nodes of the bead density rho, ascending; empty: no dependence on it"},
        {.name = "rod_density",
         .member = &TableData::rod_density,
         .unit = "1/mm^2",
         .doc = "nodes of the rod density sigma, ascending; empty: no dependence on it"},
        {.name = "relaxation_rate", .member = &TableData::relaxation_rate, .unit = "1/s", .doc = values},
        {.name = "relaxation_saturation",
         .member = &TableData::relaxation_saturation,
         .unit = "1/s/[p]^2",
         .doc = values},
        {.name = "drag_coefficient", .member = &TableData::drag_coefficient, .unit = "mg/(mm^2 s)", .doc = values},
        {.name = "driving_strength", .member = &TableData::driving_strength, .unit = "mg/(mm s^2)/[p]", .doc = values},
        {.name = "weathercock_strength", .member = &TableData::weathercock_strength, .unit = "[p]/mm", .doc = values},
        {.name = "relaxation_rate_error",
         .member = &TableData::relaxation_rate_error,
         .unit = "1/s",
         .range = not_negative,
         .doc = errors},
        {.name = "relaxation_saturation_error",
         .member = &TableData::relaxation_saturation_error,
         .unit = "1/s/[p]^2",
         .range = not_negative,
         .doc = errors},
        {.name = "drag_coefficient_error",
         .member = &TableData::drag_coefficient_error,
         .unit = "mg/(mm^2 s)",
         .range = not_negative,
         .doc = errors},
        {.name = "driving_strength_error",
         .member = &TableData::driving_strength_error,
         .unit = "mg/(mm s^2)/[p]",
         .range = not_negative,
         .doc = errors},
        {.name = "weathercock_strength_error",
         .member = &TableData::weathercock_strength_error,
         .unit = "[p]/mm",
         .range = not_negative,
         .doc = errors},
        {.name = "outside",
         .member = &TableData::outside,
         .choices = {"refuse", "hold"},
         .doc = "beyond the nodes: refuse: the run stops and says so; hold: the values at the edge"}};
    return rows;
}

}  // namespace drover
