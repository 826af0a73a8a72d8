// physics/terms.cpp: linearisations of the terms, in the variables of IsotropicBlocks (along q: sigma, i q.p/|q|).
#include "drover/physics/terms.hpp"

namespace drover::physics {

namespace {
/// Rows of the fields in the blocks: scalars first, then the vector parts.
int rods(const Form& form) { return form.rod_density; }
int order_along(const Form& form) { return layout(form).scalars; }
constexpr int order_across = 0;
}  // namespace

void add_linearisation(const RodCurrent& term, const Form& form, double q, numerics::IsotropicBlocks& rates) {
    rates.along(rods(form), order_along(form)) -= term.speed * q;  // -u i q (q.p/|q|)
}

void add_linearisation(const Relaxation& term, const Form& form, double, numerics::IsotropicBlocks& rates) {
    rates.along(order_along(form), order_along(form)) -= term.rate;
    rates.across(order_across, order_across) -= term.rate;
}

void add_linearisation(const Elasticity& term, const Form& form, double q, numerics::IsotropicBlocks& rates) {
    rates.along(order_along(form), order_along(form)) -= (term.stiffness + term.splay) * q * q;
    rates.across(order_across, order_across) -= term.stiffness * q * q;
}

void add_linearisation(const RodPressure& term, const Form& form, double q, numerics::IsotropicBlocks& rates) {
    rates.along(order_along(form), rods(form)) += term.strength * q;  // i (-B i q sigma)
}

void add_linearisation(const RodDiffusion& term, const Form& form, double q, numerics::IsotropicBlocks& rates) {
    rates.along(rods(form), rods(form)) -= term.diffusivity * q * q;
}

void add_covariance(const Noise& noise, const Form& form, double q, numerics::IsotropicBlocks& covariance) {
    covariance.along(order_along(form), order_along(form)) += noise.order;
    covariance.across(order_across, order_across) += noise.order;
    covariance.along(rods(form), rods(form)) += noise.rods * q * q;
}

}  // namespace drover::physics

namespace drover {

using namespace physics;

template <>
const std::vector<Row<RodCurrent>>& schema<RodCurrent>() {
    static const std::vector<Row<RodCurrent>> rows{
        {.name = "speed",
         .member = &RodCurrent::speed,
         .unit = "mm/s",
         .sentence = "u: speed of rods along the order, in d_t sigma = -u div p"}};
    return rows;
}

template <>
const std::vector<Row<Relaxation>>& schema<Relaxation>() {
    static const std::vector<Row<Relaxation>> rows{
        {.name = "rate",
         .member = &Relaxation::rate,
         .unit = "1/s",
         .sentence = "a: rate at which order decays, in d_t p = -a p; below 0 it grows, and a linear model has nothing "
                     "to stop it"}};
    return rows;
}

template <>
const std::vector<Row<Elasticity>>& schema<Elasticity>() {
    static const std::vector<Row<Elasticity>> rows{
        {.name = "stiffness",
         .member = &Elasticity::stiffness,
         .unit = "mm^2/s",
         .range = not_negative,
         .sentence = "K3: resistance of the order to any gradient, in d_t p = K3 lap p"},
        {.name = "splay",
         .member = &Elasticity::splay,
         .unit = "mm^2/s",
         .range = not_negative,
         .sentence = "K1: further resistance to splay, in d_t p = K1 grad(div p)"}};
    return rows;
}

template <>
const std::vector<Row<RodPressure>>& schema<RodPressure>() {
    static const std::vector<Row<RodPressure>> rows{
        {.name = "strength",
         .member = &RodPressure::strength,
         .unit = "mm/s",
         .sentence = "B: how rods turn away from crowded places, in d_t p = -B grad sigma; independent rods: u/2"}};
    return rows;
}

template <>
const std::vector<Row<RodDiffusion>>& schema<RodDiffusion>() {
    static const std::vector<Row<RodDiffusion>> rows{{.name = "diffusivity",
                                                      .member = &RodDiffusion::diffusivity,
                                                      .unit = "mm^2/s",
                                                      .range = not_negative,
                                                      .sentence = "D: diffusion of rods, in d_t sigma = D lap sigma"}};
    return rows;
}

template <>
const std::vector<Row<physics::Noise>>& schema<physics::Noise>() {
    static const std::vector<Row<physics::Noise>> rows{
        {.name = "order",
         .member = &physics::Noise::order,
         .unit = "1/(mm^2 s)",
         .range = not_negative,
         .sentence = "Delta: strength of the white noise on p, <f_i f_j> = Delta delta_ij delta(r - r') delta(t - t')"},
        {.name = "rods",
         .member = &physics::Noise::rods,
         .unit = "1/s",
         .range = not_negative,
         .sentence =
             "strength of the conserved noise on sigma; 2 D sigma is the shot noise of independent rods, 0 leaves "
             "sigma without shot noise"}};
    return rows;
}

}  // namespace drover
