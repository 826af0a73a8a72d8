// calibrate/assays/diffusion.hpp: self-diffusion of beads and of single rods from mean-square displacements.
#pragma once
#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct DiffusionPlan {
    double warm_up = 1.0;  ///< before positions are recorded [s] >= 0
    double frame = 0.05;   ///< between recorded positions [s] > 0; a multiple of the plate period
    double time = 10.0;    ///< recorded [s]
    double min_lag = 0.5;  ///< shortest lag of the fit [s]; longer than ballistic motion and rattling in a cage
    double max_lag = 2.5;  ///< longest lag of the fit [s]; less than `time`

    static Rows<DiffusionPlan> rows();
};

/// Diffusion coefficients D of a bed without forces, from the slope of the mean-square displacement in two dimensions:
///     <|r(s + t) - r(s)|^2> = c + 4 D t,   min_lag <= t <= max_lag,
/// averaged over particles and start times s and fitted by least squares with weights 1/t^2.  The offset c holds
/// rattling in a cage (c > 0) and persistence of the velocity (c < 0).
/// Beads are measured without rods.  Their displacements are taken relative to the mean over all N beads, which removes
/// drift of the bed, and multiplied by N/(N - 1).
/// Rods are measured among beads whose mean velocity is held at zero, in the frame of the body: r is the sum of the
/// displacements along and across the mean axis of each frame.  The mean speed of each rod over the trial is
/// subtracted from the displacement along the axis, and the mean square along the axis is divided by 1 - t/time, which
/// is exact for a Brownian path.  So D holds neither propulsion u nor the active dispersion u^2/(2 D_r), which
/// the equations contain as J = u sigma P; rods of different speeds do not add to it.
/// Self-diffusion equals the collective diffusion in  d_t rho = D lap rho  only for independent particles.
/// Quantities: bead_diffusion, rod_diffusion D [mm^2/s]; bead_diffusion_offset, rod_diffusion_offset c [mm^2];
/// bead_diffusion_change, rod_diffusion_change: (D of the longer half of the lags - D of the shorter half)/D, 0 for
/// diffusive motion.
Assay diffusion(const DiffusionPlan& plan = {});

}  // namespace drover::calibrate
