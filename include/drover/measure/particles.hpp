// measure/particles.hpp: what is measured on rods and beads, each as one row: name, unit, axes, formula, function.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "drover/dem/setup.hpp"
#include "drover/dem/world.hpp"

namespace drover::measure {

/// An axis of an observable of particles.
enum class ParticleAxis {
    bead_separation,  ///< distance of two beads in the plane
    rod_separation,   ///< distance of the centres of mass of two rods in the plane
    box,              ///< boxes by size
    along,            ///< place beside a rod, along its n
    across            ///< place beside a rod, along n turned by +90 degrees
};

/// Bins of equal width from 0.
struct Bins {
    double width = 0.0;     ///< [mm]
    std::size_t count = 0;  ///< 0: not measured
};

/// All that observables need to know of a run, prepared once.
struct ParticleSetting {
    dem::Cell cell;
    bool periodic = false;
    bool round = false;  ///< circle or flower: a local polar frame about the origin
    std::size_t beads = 0, rods = 0;
    double bead_diameter = 0.0;  ///< mean by number [mm]
    double rod_length = 0.0;     ///< mean, from tip to tip [mm]
    Bins bead_separations, rod_separations;
    int fine_x = 0, fine_y = 0;  ///< cells in which bodies are counted, periodic cells only
    std::vector<int> boxes;      ///< sides of boxes, in these, along x and along y
    std::vector<double> part;    ///< share of each box of the area of the cell: it holds rods times part on average
    int mesh = 0;                ///< cells along and across of the field around a rod
    double mesh_width = 0.0;     ///< of each [mm]; the middle one is about the centre of mass
};
/// Reads shapes and numbers of `at_start`, not its places.
ParticleSetting make_particle_setting(const dem::Setup& setup, const dem::Bodies& at_start);

/// Means over the beads at one moment; in the plane unless said.  Radial and azimuthal (counter-clockwise) about the origin.
struct BeadMeans {
    double velocity_x = 0.0, velocity_y = 0.0, velocity_radial = 0.0, velocity_azimuthal = 0.0;      ///< [mm/s]
    double speed = 0.0;                                                                              ///< of |v| [mm/s]
    double direction_x = 0.0, direction_y = 0.0, direction_radial = 0.0, direction_azimuthal = 0.0;  ///< of v/|v|
    double temperature_horizontal = 0.0, temperature_vertical = 0.0;                                 ///< [mg mm^2/s^2]
    double height = 0.0;  ///< of the centres [mm]
};

/// The same of rods.
struct RodMeans {
    double order_x = 0.0, order_y = 0.0, order_radial = 0.0, order_azimuthal = 0.0, order_nematic = 0.0;
    double velocity_x = 0.0, velocity_y = 0.0, velocity_radial = 0.0, velocity_azimuthal = 0.0;  ///< [mm/s]
    double velocity_along = 0.0, velocity_along_deviation = 0.0;  ///< along each rod's own n, and its spread [mm/s]
    double temperature_horizontal = 0.0, temperature_vertical = 0.0, temperature_turning = 0.0;  ///< [mg mm^2/s^2]
    double height = 0.0;                                                                         ///< [mm]
    double tilt = 0.0;                                                                           ///< root of <n_z^2>
};

/// Sums over pairs, by bin; empty where the setting has no bins.  What they are stands in the rows of particle_observables().
struct PairSums {
    double hexatic = 0.0, hexatic_local = 0.0, neighbours = 0.0;
    std::vector<double> bead_correlation, rod_correlation;             ///< g(r), periodic cells only
    std::vector<double> rod_pairs, rod_pairs_order, rod_pairs_excess;  ///< in any cell
    std::vector<double> flow_density, flow_along, flow_across;         ///< [along * mesh + across]
};
BeadMeans bead_means(const ParticleSetting& setting, const dem::Bodies& bodies);
RodMeans rod_means(const ParticleSetting& setting, const dem::Bodies& bodies);
PairSums pair_sums(const ParticleSetting& setting, const dem::Bodies& bodies);

/// One moment of a run.  Means and sums are computed when it is made, once for all observables.
struct ParticleMoment {
    const ParticleSetting& setting;
    const dem::Bodies& bodies;
    double time = 0.0;  ///< [s]
    const dem::EnergyBalance& balance;
    const dem::Counts& counts;
    double energy_kinetic = 0.0;  ///< [mg mm^2/s^2]
    BeadMeans beads = bead_means(setting, bodies);
    RodMeans rods = rod_means(setting, bodies);
    PairSums pairs = pair_sums(setting, bodies);
};

struct ParticleObservable {
    std::string name;
    std::string unit;                ///< UDUNITS text
    std::vector<ParticleAxis> axes;  ///< slowest first; none: a single number
    std::string formula;             ///< what it is, for people
    std::function<void(const ParticleMoment& moment, std::span<double> out)> measure;  ///< out: size_of() numbers
    bool accumulates = false;  ///< counted since the start: what has a time mean is its rate, see rates()
};

/// The rows that have a meaning for the bodies there are and for the cell.
///
/// Trap: bodies rattle with the plates.  Velocities, heights and temperatures of one moment, sampled at multiples of the plates' period, are
/// those of one phase of it.  Speeds come from displacements: see measure/trajectories.hpp.
std::vector<ParticleObservable> particle_observables(const ParticleSetting& setting);

/// A mean whose weights change from moment to moment, or are zero at some (no pair in a bin, no bead under a rod): the time mean of one observable
/// divided by that of another of the same axes.
struct ParticleQuotient {
    std::string name;
    std::string unit;
    std::string formula;
    std::string sum, weight;  ///< names of the two observables
};
std::vector<ParticleQuotient> particle_quotients(const ParticleSetting& setting);

/// Of a row that accumulates: (a[i + 1] - a[i])/spacing, one fewer than there are samples.
std::vector<double> rates(std::span<const double> accumulated, double spacing);

/// Numbers on an axis in a setting, and of an observable: the product of its axes.
std::size_t size_of(ParticleAxis axis, const ParticleSetting& setting);
std::size_t size_of(const ParticleObservable& observable, const ParticleSetting& setting);

/// What stands on an axis.
struct AxisValues {
    std::string name;
    std::string unit;
    std::string meaning;
    std::vector<double> values;
};
AxisValues axis_of(ParticleAxis axis, const ParticleSetting& setting);

}  // namespace drover::measure
