// calibrate/assays/scattering.hpp: alignment by contacts from collisions of two rods.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Cell and times of a trial.
struct ScatteringPlan {
    double cell = 16.0;         ///< side of the periodic square with two rods [mm]; more than twice the range
    double range = 5.5;         ///< distance of centres at which an encounter begins and ends [mm]; rods must not touch
    double max_duration = 4.0;  ///< longer encounters are cut off there [s]; well below 1/a
    double warm_up = 1.0;       ///< once, in random directions [s]
    double time = 100.0;        ///< of a trial [s]
    double frame = 0.1;         ///< between samples of the positions [s]; short compared to an encounter

    static Rows<ScatteringPlan> rows();
};

/// Two rods meet again and again in a small cell, in a bed whose mean velocity is held at zero.  z_j = exp(i theta_j)
/// where an encounter begins, z_j' where it ends.  Rods of density sigma that meet in pairs, without correlations
/// before they meet, change the moments psi_k = <z^k> of their directions at the rates
///     d_t psi_k = sigma sum_q J_kq psi_q psi_(k-q),
///     J_kq = (A/2) < w (z_1'^k + z_2'^k - z_1^k - z_2^k) z_1^-q z_2^(q-k) >,
/// A being the area of the cell, w the rate of encounters of one pair whose relative angle is uniform, and < > the mean
/// over those.  In a small cell a pair keeps its relative angle from one encounter to the next, so rates are measured
/// at each angle on its own, per time that the pair spends apart at it, in the area of the cell beyond the range.
/// Between contacts rods turn by noise: the mean of exp(i k turn) over as long a time, of rods that are apart, is
/// divided out of z'^k.
/// Quantities: contact_scattering c = J_10 + J_11, in d_t P = c sigma P [mm^2/s]; those of the second moment,
/// scattering_second J_20 + J_22, scattering_excitation J_21 and scattering_saturation -(J_12 + J_1,-1) [mm^2/s];
/// encounter_rate A w [mm^2/s]; encounters_cut, the share of encounters that outlast max_duration; relaxation_apart, a
/// of the noise that is divided out, from the longer half of the durations; contact_at_<d>, the part of c from relative
/// angles of d degrees, +- 15: c is their mean.
/// Source: Bertin, Droz & Gregoire, J. Phys. A 42, 445001 (2009), whose kernel is here measured; with the closure psi_3
/// = 0 and psi_2 quasi-stationary it gives saturation and advection (src/calibrate/closures.cpp).
Assay scattering(const ScatteringPlan& plan = {});

}  // namespace drover::calibrate
