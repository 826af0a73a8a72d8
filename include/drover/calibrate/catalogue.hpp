// calibrate/catalogue.hpp: all assays there are.
#pragma once
#include "drover/calibrate/damping.hpp"
#include "drover/calibrate/drag.hpp"
#include "drover/calibrate/propulsion.hpp"
#include "drover/calibrate/relaxation.hpp"
#include "drover/calibrate/shear.hpp"
#include "drover/calibrate/stiffness.hpp"
#include "drover/calibrate/weathercock.hpp"

namespace drover::calibrate {

/// Speeds, forces and times of each; the defaults suit rods and beads of millimetres, D_r of 0.05 to 1 /s and a cell of some 30 mm.
struct Plans {
    RelaxationPlan relaxation;
    WeathercockPlan weathercock;
    DragPlan drag;
    DampingPlan damping;
    ShearPlan shear;
    PropulsionPlan propulsion;
    CompressibilityPlan stiffness;
};

/// visit(name, sentence, plan) for each, in the order of the assays.
template <class AnyPlans, class Visit>
void for_plans(AnyPlans& plans, Visit visit) {
    visit("relaxation", "Rods that lose their direction: a.", plans.relaxation);
    visit("weathercock", "Flow that turns rods: lambda_s.", plans.weathercock);
    visit("drag", "Aligned rods that carry beads: alpha/Gamma.", plans.drag);
    visit("damping", "Flow of the beads that the plates stop: Gamma/(m rho).", plans.damping);
    visit("shear", "Waves of the beads' velocity that decay: eta/(m rho).", plans.shear);
    visit("propulsion", "Rods that swim: u.", plans.propulsion);
    visit("stiffness", "Beads that are pushed together: E.", plans.stiffness);
}

/// One of each, in this order.  Throws an input Error for a plan that cannot be.
std::vector<Assay> make_assays(const Plans& plans = {});

/// The one of this name.  Throws an input Error that names them all.
const Assay& find_assay(std::span<const Assay> assays, const std::string& name);

}  // namespace drover::calibrate
