// calibrate/catalogue.hpp: the list of all assays.
#pragma once
#include <tuple>

#include "calibrate/assays/alignment_assay.hpp"
#include "calibrate/assays/damping.hpp"
#include "calibrate/assays/diffusion.hpp"
#include "calibrate/assays/drag.hpp"
#include "calibrate/assays/propulsion.hpp"
#include "calibrate/assays/relaxation.hpp"
#include "calibrate/assays/rotation.hpp"
#include "calibrate/assays/scattering.hpp"
#include "calibrate/assays/shear.hpp"
#include "calibrate/assays/stiffness.hpp"
#include "calibrate/assays/weathercock.hpp"

namespace drover::calibrate {

/// Speeds, forces and times of each assay.
/// The defaults suit millimetre-sized rods and beads, D_r = 0.05 to 1 /s and a cell of about 30 mm.
struct Plans {
    RelaxationPlan relaxation;
    WeathercockPlan weathercock;
    DragPlan drag;
    DampingPlan damping;
    ShearPlan shear;
    PropulsionPlan propulsion;
    StiffnessPlan stiffness;
    DiffusionPlan diffusion;
    AlignmentPlan alignment;
    ScatteringPlan scattering;
    RotationPlan rotation;
};

/// `doc` describes the section [calibrate.<name>] of a scene.
template <class Plan>
struct CatalogueRow {
    const char *name, *doc;
    Plan Plans::*plan;
    Assay (*make)(const Plan&);
};

/// To add an assay: its header and source, one member of Plans and one row here.
inline constexpr std::tuple catalogue{
    CatalogueRow{"relaxation", "Decay of rod orientation: a.", &Plans::relaxation, &relaxation},
    CatalogueRow{"weathercock", "Rotation of rods by bead flow: lambda_s.", &Plans::weathercock, &weathercock},
    CatalogueRow{"drag", "Beads dragged by aligned rods: alpha/Gamma.", &Plans::drag, &drag},
    CatalogueRow{"damping", "Bead flow stopped by the plates: Gamma/(m rho).", &Plans::damping, &damping},
    CatalogueRow{"shear", "Decay of shear waves of the beads: eta/(m rho).", &Plans::shear, &shear},
    CatalogueRow{"propulsion", "Speed of self-propelled rods: u.", &Plans::propulsion, &propulsion},
    CatalogueRow{"stiffness", "Response of the bead density to a force: E.", &Plans::stiffness, &stiffness},
    CatalogueRow{"diffusion", "Mean-square displacements of beads and single rods: D.", &Plans::diffusion, &diffusion},
    CatalogueRow{"alignment", "Alignment of rods by contacts, the beads held: c and a among rods.", &Plans::alignment,
                 &alignment},
    CatalogueRow{"scattering", "Alignment by contacts from collisions of two rods, the beads held: c and J_kq.",
                 &Plans::scattering, &scattering},
    CatalogueRow{"rotation", "Mean-square angles of single rods: D_r.", &Plans::rotation, &rotation}};

/// Calls visit(name, doc, plan) for each assay, in the order of the catalogue.
template <class AnyPlans, class Visit>
void for_plans(AnyPlans& plans, Visit visit) {
    std::apply([&](const auto&... row) { (visit(row.name, row.doc, plans.*row.plan), ...); }, catalogue);
}

/// One assay of each kind, in the order of the catalogue.  Throws an input Error for an invalid plan.
std::vector<Assay> make_assays(const Plans& plans = {});

/// The assay of this name.  Throws an input Error that lists the valid names.
const Assay& find_assay(std::span<const Assay> assays, const std::string& name);

}  // namespace drover::calibrate
