// measure/particles.hpp: the observables of rods and beads.
#pragma once
#include <span>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "drover/dem/setup.hpp"
#include "drover/dem/world.hpp"
#include "measure/observable.hpp"
#include "measure/summary.hpp"

namespace drover::measure {

/// Bins of equal width from 0.
struct Bins {
    double width = 0.0;     ///< [mm]
    std::size_t count = 0;  ///< 0: not measured
};

/// What the observables of a run need, prepared once.
struct ParticleSetting {
    dem::Cell cell;
    bool periodic = false;
    bool round = false;  ///< circle or flower: a local polar frame about the origin
    std::size_t beads = 0, rods = 0;
    double bead_diameter = 0.0;  ///< mean by number [mm]
    double rod_length = 0.0;     ///< mean, from tip to tip [mm]
    Bins bead_separations, rod_separations;
    int fine_x = 0, fine_y = 0;     ///< cells of the mesh on which bodies are counted; periodic cells only
    std::vector<int> boxes;         ///< sides of boxes, in cells of this mesh, along x and along y
    std::vector<double> fractions;  ///< area of each box as a fraction of the cell
    int mesh = 0;             ///< cells along and across a rod of the mesh on which the flow around it is measured
    double mesh_width = 0.0;  ///< of each cell [mm]; the middle one is centred on the centre of mass
};
/// Uses the shapes and numbers of `at_start`, not the positions.
ParticleSetting make_particle_setting(const dem::Setup& setup, const dem::Bodies& at_start);

/// Means over the beads at one moment, in the plane except where noted.  Radial and azimuthal (counter-clockwise) about
/// the origin.
struct BeadMeans {
    double velocity_x = 0.0, velocity_y = 0.0, velocity_radial = 0.0, velocity_azimuthal = 0.0;      ///< [mm/s]
    double velocity_square = 0.0;                                                                    ///< [mm^2/s^2]
    double direction_x = 0.0, direction_y = 0.0, direction_radial = 0.0, direction_azimuthal = 0.0;  ///< of v/|v|
    double temperature_horizontal = 0.0, temperature_vertical = 0.0;                                 ///< [mg mm^2/s^2]
    double height = 0.0;  ///< of the centres [mm]
};

/// The same of rods.
struct RodMeans {
    double order_x = 0.0, order_y = 0.0, order_radial = 0.0, order_azimuthal = 0.0, order_nematic = 0.0;
    double velocity_x = 0.0, velocity_y = 0.0, velocity_radial = 0.0, velocity_azimuthal = 0.0;  ///< [mm/s]
    double velocity_along = 0.0, velocity_along_deviation = 0.0;  ///< along n of each rod: mean and deviation [mm/s]
    double temperature_horizontal = 0.0, temperature_vertical = 0.0, temperature_turning = 0.0;  ///< [mg mm^2/s^2]
    double height = 0.0;                                                                         ///< [mm]
    double tilt = 0.0;                                                                           ///< sqrt(<n_z^2>)
};

/// Sums over pairs, by bin; empty where the setting has no bins.  The rows of particle_observables() define them.
struct PairSums {
    double hexatic = 0.0, hexatic_local = 0.0, neighbours = 0.0;
    std::vector<double> bead_correlation, rod_correlation;             ///< g(r), periodic cells only
    std::vector<double> rod_pairs, rod_pairs_order, rod_pairs_excess;  ///< in any cell
    std::vector<double> flow_density, flow_along, flow_across;         ///< [along * mesh + across]
};
BeadMeans bead_means(const ParticleSetting& setting, const dem::Bodies& bodies);
RodMeans rod_means(const ParticleSetting& setting, const dem::Bodies& bodies);
PairSums pair_sums(const ParticleSetting& setting, const dem::Bodies& bodies);

/// Variance over all positions on the counting mesh of the number of bodies in each box.
std::vector<double> box_variances(const ParticleSetting& setting, std::span<const dem::Vector> positions);

/// One moment of a run.  Means and sums are computed on construction, once for all observables.
struct ParticleMoment {
    const ParticleSetting& setting;
    dem::Bodies bodies;
    double time = 0.0;  ///< [s]
    dem::EnergyBalance balance;
    dem::Counts counts;
    double energy_kinetic = 0.0;  ///< [mg mm^2/s^2]
    BeadMeans beads = bead_means(setting, bodies);
    RodMeans rods = rod_means(setting, bodies);
    PairSums pairs = pair_sums(setting, bodies);
};

/// The observables that are defined for these bodies and this cell.
///
/// Trap: bodies vibrate with the plates.  Velocities, heights and temperatures sampled at multiples of the plates'
/// period are those of one phase of it.  Speeds come from displacements: see measure/trajectories.hpp.
Observables<ParticleMoment> particle_observables(const ParticleSetting& setting);

/// The recorded series with what their summary needs.
Recorded particle_recording(const ParticleSetting& setting, std::vector<RecordedSeries> series);

}  // namespace drover::measure
