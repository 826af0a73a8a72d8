// calibrate/catalogue.hpp: all assays: what each measures, by which plan, and the list of them.
#pragma once
#include <tuple>

#include "drover/base/schema.hpp"
#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Times of a trial.
struct RelaxationPlan {
    double warm_up = 1.0;  ///< before rods are recorded [s] >= 0
    double frame = 0.025;  ///< between samples [s]; a multiple of the plate period, at which rods tilt
    double time = 6.0;     ///< recorded [s]
    double max_lag = 2.0;  ///< longest lag [s], less than `time`; about 0.5/a if affordable

    static Rows<RelaxationPlan> rows();
};

/// a of the equations, from the directions theta of all rods:
///     C(t) = <cos(theta(s + t) - theta(s))>,   C(t) = c exp(-a t)  in the exponential regime,   a = D_r in 2-D.
/// d<n>/dt = -a <n> is (polarfull) for rods without flow and gradients, so the mean bead velocity is held at zero.
/// C has three regimes: an immediate loss 1 - c by jitter (bouncing, tilt) that does not accumulate; a curved part
/// while rods persist in turning; then a straight line in ln C.  ln C is fitted from a lag t0 on, with weights 1/t^2
/// (long lags have few independent intervals), up to -ln C = 1/2.  t0 is chosen once, from all trials together: the
/// first of 1, 2, 4, ... frames whose slope agrees with the slope from 2 t0 on within the error of their difference
/// (jackknife over trials), times two.  No time average is subtracted from C, and the logarithm is taken of its mean
/// over trials, so trials may be shorter than 1/a.
/// Quantities: relaxation_rate a [1/s]; rotational_jitter 1 - c, negative if persistence costs more correlation than
/// jitter; exponential_from t0 [s], NaN if there is no such lag.
/// Source: physics as in Kumar et al., Nat. Commun. 5, 4688 (2014), Methods.
Assay relaxation(const RelaxationPlan& plan = {});

/// Speeds and times of a trial.
struct WeathercockPlan {
    std::vector<double> speeds = {1.0, 2.0, 5.0, 10.0};  ///< of the beads [mm/s] > 0, ascending
    double distance = 6.0;                               ///< of the flow while rods turn [mm]: at most about 1/lambda_s
    double max_window = 1.5;                             ///< longest time for that distance [s]; slow flows go less far
    double torque = 2e4;   ///< that holds rods transverse to the flow before the release [mg mm^2/s^2]
    double warm_up = 1.0;  ///< once, at the start [s]
    double align = 0.5;    ///< before each release [s]
    double settle = 0.05;  ///< after each release, until the angular velocity follows the flow [s]
    double frame = 0.025;  ///< longest time between samples [s]

    static Rows<WeathercockPlan> rows();
};

/// lambda_s of one rod, and lambda = lambda_s/2 of the equations, of either sign (positive: rods turn along the flow).
/// An overdamped rod in a flow v obeys  d theta/dt = lambda_s |v| sin(angle of v - theta) + noise
/// (dn/dt = lambda_s (1 - nn).v; averaged over directions, (polarfull) has half of it).
/// An orienting torque holds all rods along x while the mean bead velocity is held along y; then the torque is switched
/// off.  For any noise that is symmetric under reflection, and any distribution of directions,
///     <theta(t) - theta(0)> = lambda_s v int_0^t <cos theta> ds,
/// so rotational diffusion does not enter, and windows longer than the initial turn are used: distance/v, at most
/// max_window.  Each speed is measured with the flow to either side and the mean of the mirror pair is used, which
/// cancels drift.  lambda_s combines all speeds with weights v: squared errors of theta - theta(0) grow as the window
/// length t and the signal as v t.
/// Linearity: lambda_s(v) = lambda_0 [1 + (x - 1) ln v], weights v: the turning rate goes as v^x near x = 1.
/// Quantities: weathercock_single lambda_s [1/mm]; weathercock lambda [1/mm]; turning_exponent x;
/// weathercock_single_<v>, lambda_s at each speed.
Assay weathercock(const WeathercockPlan& plan = {});

/// Fields and times of a trial.
struct DragPlan {
    /// Of the orienting field, ascending [mg mm^2/s^2]; for P from below a half to nearly one.  One < 0 may come first.
    std::vector<double> torques = {200.0, 500.0, 1500.0, 10000.0};
    double warm_up = 0.5;  ///< once, in the strongest field [s]: the packing becomes a bed; less than m rho/Gamma
    double time = 6.0;     ///< in each field [s]; together several times m rho/Gamma and 1/a
    int windows = 4;       ///< of equal length in that time
    double frame = 0.025;  ///< between samples of P [s]
    bool bend = true;      ///< whether alpha/Gamma and tau come from the fit with a term in |P|^2 P, or without

    static Rows<DragPlan> rows();
};

/// alpha/Gamma at the area fractions of the setup, normalised such that P is the mean of n (so it is a speed).  An
/// orienting field of several strengths, the strongest first, holds the rods along x; the beads are free and start at
/// rest.  For the mean over the cell (beadmom) reads  tau dv/dt = -v + (alpha/Gamma) P,  tau = m rho/Gamma.  With the
/// next order that symmetry allows, its mean over a window of length T is
///     <v> = (alpha/Gamma) <P> + c <|P|^2 P> - tau [v(T) - v(0)]/T,
/// which holds for any fluctuations of P and any history of v, so no steady state is needed.  Least squares over the
/// windows of all torques, along x.  alpha/Gamma is the slope of the whole curve at the origin or, without `bend`, of
/// the straight line through the origin.  Only a reversal has orders near 0: without one that slope is extrapolated.
/// Quantities: drag alpha/Gamma [mm/s]; drag_cubic c = alpha_3/Gamma [mm/s], or drag_curvature where the straight line
/// was fitted, which tables do not use; response_time tau [s].  With `bend` also drag_straight, alpha/Gamma of the
/// straight line through the windows of torques > 0.  tau is determined by transients, mainly the start: it is
/// uncertain if far below a window, and noise biases it towards 0.  Its Gamma is the total friction on the beads: the
/// plates, which damping() measures alone, and rods that do not move along.
/// The same windows, but for a reversal, give the total alignment g of the rods, by flow and contacts:
///     kappa [1 + d_t P/(a P)] = g P + beta T,   P = I1(kappa)/I0(kappa),
/// which is linear in 1/a, and a is of another assay: g = alignment_steady + alignment_drift/a; alignment_reference, g
/// at 1/a = 10 s, has an error that tells their covariance.
/// Strong torques also lay rods flat and change their gait: use the weakest that order them.  Also order_<h> and
/// flow_<h>, <P> and <v> in the last window of each torque h.
Assay drag(const DragPlan& plan = {});

/// Speeds and times of a trial.
struct DampingPlan {
    double speed = 10.0;       ///< initial speed at each release [mm/s]
    double min_speed = 1.0;    ///< speed at which the fit of the decay ends [mm/s]; a decade below `speed`
    double speed_flock = 3.0;  ///< speed at which the rate is evaluated, between the other two [mm/s]
    double warm_up = 0.5;      ///< once, at the start [s]
    double hold = 0.2;         ///< before each release [s]
    int releases = 2;          ///< per system, along x, y, -x, -y, and so on
    double time = 4.0;         ///< recorded after each release [s]; until min_speed, about 3/(Gamma/(m rho))
    double frame = 0.05;       ///< between samples [s]; a multiple of the plate period

    static Rows<DampingPlan> rows();
};

/// Gamma/(m rho) of beads without rods.  The mean bead velocity is held, then released, and its decay recorded:
///     dv/dt = -g v - c,    g [1/s] linear, c [mm/s^2] Coulomb-like,    Gamma/(m rho) = g + c/v at the flock speed v.
/// (A uniform velocity relaxes at Gamma/(m rho), see (beadmom).)  Over each frame, exactly,
///     v - v' = g (x' - x) + c frame,
/// x being the mean displacement of the beads.  g and c are a least-squares fit over the frames of the mean decay of
/// all trials, as long as it is faster than min_speed; these frames are chosen once, from all trials together.  Noise
/// from collisions is the same in every frame, hence equal weights.  If the beads stay faster than speed_flock, the
/// rate is the mean of -dv/dx over the observed speeds, and g and c are not available.
/// Quantities: damping_rate Gamma/(m rho) at the flock speed [1/s]; damping_linear g; damping_coulomb c; coulomb_share
/// (c/v)/(g + c/v) at the flock speed; damping_rate_fast, _middle, _slow: (v - v')/(x' - x) over thirds of the decade
/// (in ln v), all equal for a linear law.  Multiply by m rho for Gamma [mg/(mm^2 s)].
Assay damping(const DampingPlan& plan = {});

/// Waves and times of a trial.
struct ShearPlan {
    std::vector<double> waves = {1, 3, 5};  ///< across the cell, integers >= 1, ascending: q = 2 pi waves/ly
    double speed = 10.0;                    ///< initial amplitude at each release [mm/s]
    double min_fraction = 0.2;              ///< of the initial amplitude, at which the fit of the decay ends
    double warm_up = 0.5;                   ///< once, at the start [s]
    double hold = 0.2;                      ///< before each release [s]
    int releases = 2;                       ///< of each wave, with alternating sign
    double time = 0.8;                      ///< recorded after each release [s]
    double frame = 0.01;                    ///< between samples [s]; a multiple of the plate period

    static Rows<ShearPlan> rows();
};

/// eta and Gamma of beads without rods, from the decay of waves v_x = A sin(q y), which (beadmom) damps at the rate
///     r(q) = (Gamma + eta q^2)/(m rho),
/// a straight line in q^2, fitted with weights 1/r^2.  The amplitude is held, then released.  r comes from the frames
/// in which the mean amplitude over all trials exceeds min_fraction of the first:
///     (A_0 - A_n)/sum of trapezoids = (2/frame) tanh(r frame/2),  exact for an exponential.
/// A wave contains all speeds from 0 to A: if damping() finds a Coulomb-like part, Gamma here is a mean over them.
/// Quantities: viscosity_kinematic eta/(m rho) [mm^2/s]; damping_intercept Gamma/(m rho) [1/s]; shear_bend, the largest
/// residual of r relative to r; shear_rate_<k>, r of each wave [1/s].  Multiply by m rho for eta [mg/s] and Gamma
/// [mg/(mm^2 s)].
Assay shear(const ShearPlan& plan = {});

/// Times of a trial.
struct PropulsionPlan {
    double warm_up = 1.0;  ///< before rods are recorded [s]
    double time = 4.0;     ///< recorded [s]
    double frame = 0.025;  ///< over which a displacement is taken [s]; the experiment used 1/40 s

    static Rows<PropulsionPlan> rows();
};

/// u: speed of rods along their axis, among beads whose mean velocity is held at zero.  With the displacement d over a
/// frame and n at its start,
///     u = <d.n>/frame x/(1 - exp(-x)),   x = -ln <n(0).n(frame)>.
/// Rotational diffusion shortens d.n by (1 - exp(-D_r frame))/(D_r frame); jitter of n shortens it too, to first order
/// by x/2.
/// Quantities: propulsion u [mm/s]; propulsion_spread [mm/s], the standard deviation among rods of their mean
/// <d.n>/frame over a trial (from differences between rods, gaits and, in short trials, statistics).
Assay propulsion(const PropulsionPlan& plan = {});

/// Forces and times of a trial.
struct StiffnessPlan {
    int waves = 2;                              ///< of the force across the cell
    std::vector<double> pushes = {10.0, 20.0};  ///< two force amplitudes on a bead, ascending > 0 [mg mm/s^2]
    bool among_rods = false;                    ///< whether the rods of the setup are in the bed
    double torque = 300.0;                      ///< of the field that holds them across the force [mg mm^2/s^2]
    double warm_up = 0.5;                       ///< once, at the start [s]
    /// After each change of the force, until sound has decayed [s]: about 4 m rho/(Gamma + eta q^2).
    double settle = 2.0;
    double time = 2.0;    ///< averaged under each force [s]
    double frame = 0.02;  ///< between samples [s]

    static Rows<StiffnessPlan> rows();
};

/// Stiffness E of beads, without rods or among them, from the density response to a standing force wave f sin(qx) on
/// each bead.  (beadmom) with number density rho contains the force density rho f sin(qx); at rest
///     0 = rho f sin(qx) - E d rho/dx,
/// so  rho = rho_0 (1 + d cos(qx))  with  d = -f/(E q)  to first order:
///     E = -f/(q d)   [mg mm^2/s^2],   (speed of sound)^2 = E/m without damping.
/// (If rho is a mass density, divide E by the mass m of a bead; if an area fraction, by its area.)  Friction does not
/// enter: beads are shaken and at rest on average.  Forces of both signs are applied and averaged.
/// Two amplitudes: E is the least-squares line of d on f through the origin; `response_ratio` is (d/f at the larger)/
/// (d/f at the smaller), 1 if linear.  E is not available if d is less than 3 standard errors from 0, since 1/d then
/// has no mean.
/// Among rods a field along y holds their directions, so that neither their propulsion nor their order is along the
/// force; their centres are free. rods_follow is the part by which their density follows that of the beads: with a
/// force F grad sigma of the rods, what is measured is E + F (sigma/rho) rods_follow.
/// F is not measured: a force on the rods moves them relative to a bed that flows, and self-propelled rods are never at
/// rest, so E grad rho + F grad sigma = 0 cannot be observed; its origin in a table is `set`.
/// Quantities: stiffness E; density_response -d/f [s^2/(mg mm)]; response_ratio; among rods also rods_follow.
Assay stiffness(const StiffnessPlan& plan = {});

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

/// Fields and times of a trial.
struct AlignmentPlan {
    /// Of the orienting field, ascending [mg mm^2/s^2] > 0; for P from below .4 to .9.
    std::vector<double> torques = {100.0, 300.0, 1000.0};
    double warm_up = 0.5;  ///< once, without a field [s]
    double time = 4.0;     ///< in each field [s]
    int windows = 2;       ///< of equal length in that time
    double frame = 0.025;  ///< between samples of P [s]

    static Rows<AlignmentPlan> rows();
};

/// Alignment of rods by contacts at the area fractions of the setup: many rods, in random directions at first, in an
/// orienting field along x that grows, while the mean velocity of the beads, if any, is held at zero.  Rods that turn
/// with the torque mu T and, by contacts, 2 c sigma P towards the mean orientation P of all, obey
///     d_t <P_x> = -a <P_x> + (mu T/2) <1 - C2> + c sigma <P_x (1 - C2) - P_y S2>,
/// C2 and S2 being the means of cos and sin of twice the angle.  It is exact for any number of rods, any distribution
/// and any history, and linear in a, mu and c sigma: least squares over the windows of all fields.  The fit of all
/// three gives the rate a among rods; with a of the relaxation assay, c sigma = contact_steady + a contact_slope.  (The
/// saturation b follows from a and c, as from any alignment.)
/// Quantities: contact_reference, c sigma at a = 0.1/s, whose error also tells the covariance of contact_steady [1/s]
/// and contact_slope [1]; relaxation_among_rods a [1/s]; orienting_mobility mu [s/(mg mm^2)], at a = 0.1/s;
/// order_held_<T>, <P> in the last window of each field.
/// Source: first moment of the Langevin equation of rods with pairwise torques (2 c/V) sin(theta_j - theta_i).
Assay alignment(const AlignmentPlan& plan = {});

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

/// Times of a trial.
struct RotationPlan {
    double warm_up = 1.0;  ///< before angles are recorded [s] >= 0
    double frame = 0.05;   ///< between recorded angles [s] > 0; a rod turns by less than half a turn in it
    double time = 10.0;    ///< recorded [s]
    double min_lag = 0.5;  ///< shortest lag of the fit [s]; longer than a rod keeps its rate of turning
    double max_lag = 2.5;  ///< longest lag of the fit [s]; less than `time`

    static Rows<RotationPlan> rows();
};

/// D_r of single rods among beads whose mean velocity is held at zero, from the slope of the mean-square angle:
///     <[theta(s + t) - theta(s)]^2> = c + 2 D_r t,   min_lag <= t <= max_lag,
/// averaged over rods and start times s and fitted by least squares with weights 1/t^2.  The offset c holds jitter of
/// the axis (c > 0) and persistence of the rate of turning (c < 0).  relaxation_rate, from the mean direction, equals
/// D_r where a rod turns in many small steps, and not where it turns in few large ones, whose squares D_r counts.
/// Quantities: rotational_diffusion D_r [1/s]; rotational_offset c [1]; rotational_change: (D_r of the longer half of
/// the lags - D_r of the shorter half)/D_r, 0 for diffusive turning.
Assay rotation(const RotationPlan& plan = {});

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

/// To add an assay: its source in assays/, its plan and its function above, one member of Plans and one row here.
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
inline std::vector<Assay> make_assays(const Plans& plans = {}) {
    return std::apply([&](const auto&... row) { return std::vector<Assay>{row.make(plans.*row.plan)...}; }, catalogue);
}

}  // namespace drover::calibrate
