// theory/theory.hpp: the linear theory of any model: uniform states, growth of waves, fluctuations, long waves.
//
// Deviations are ~ exp(i q.r + s t): a mode grows at the rate Re s, and its frequency is -Im s.  Units are those of the
// model: rates per time, wavenumbers per length.
#pragma once
#include <complex>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/model/linearised_at.hpp"

namespace drover::theory {

// ---- Uniform states

/// A uniform stationary state.
struct StationaryState {
    std::string name;            ///< "isotropic", "ordered"; where several have this name, with the values that differ
    model::UniformState values;  ///< of all components, fields in balance included
    double residual = 0.0;       ///< the largest |rate| of a component, relative to the size of its terms
    bool is_isotropic = false;   ///< no field with a spin has a value
    bool has_free_direction = false;  ///< turned copies are states too; this one is ordered along x
    bool is_of_family = false;        ///< besides turned copies, a continuum of states contains it
};

struct StationaryStates {
    std::vector<StationaryState> states;  ///< isotropic ones first, then by the size of the order and by values
    std::string why_none;                 ///< why there is no state; empty if there is one
    /// Why there is no ordered state; empty if there is one, or no field with a spin has a rate.
    std::string why_no_order;
    std::string kink = {};            ///< a stationary state at which no linear theory exists; empty if none was found
    std::string why_incomplete = {};  ///< why the search ended before it had tried all it tries; empty: it did not
};

/// Combinations of the means of the components with a rate that no uniform state changes: one orthonormal row each.
/// Declared as conserved or not: the sum of two densities that turn into each other counts as well.  Throws an input
/// Error if the rates are not finite about the references.
Eigen::MatrixXd conserved_means(const model::Equations& equations);
/// The same over the components of the symbols of `at`.
Eigen::MatrixXd conserved_means(const model::LinearisedAt& at);

/// The uniform stationary states with conserved means as in the state of the references.  All other components are
/// unknowns: Newton's method, also with deflation of the states that are known, from a fixed set of starting points
/// (for each field values of both signs from 1e-3 to 1e3 times its reference, or 1 where that is 0; mixtures of all).
/// It may miss a state.  Turned copies of a state are counted once, and so are the members of a continuous family with
/// one parameter.  A state is accepted where its residual is below 1e-12.
/// Source of the deflation: Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37, A2026 (2015).
StationaryStates stationary_states(const model::Equations& equations);
/// The same with conserved means and references as in this state of all components.  Throws an input Error for a state
/// of another size or with values that are not finite.
StationaryStates stationary_states(const model::Equations& equations, const model::UniformState& means);

/// The state nearest to the means in samples of a run, by the components with a rate: where a direction is free it
/// wanders, and the sizes of fields with a spin count alone.  nullptr if there is none; the first without samples, or
/// where they are not finite.  Throws an input Error for a sample of another size.
const StationaryState* nearest_state(const StationaryStates& found, const model::Model& model,
                                     const std::vector<model::UniformState>& samples);

/// Only the states that Newton's method finds from these means and these guesses of all components; the guesses take
/// their conserved means from the first.  For models that differ little from one whose states are known.  elsewhere:
/// also from the starting points of stationary_states, without the search around the states they lead to, which takes
/// most of the time.  Throws as stationary_states, for guesses too.
StationaryStates stationary_states_near(const model::Equations& equations, const model::UniformState& means,
                                        const std::vector<model::UniformState>& guesses, bool elsewhere = false);

/// Whether turned copies of every state are equivalent, for uniform states and waves: tried at random states.
bool turns_freely(const model::Equations& equations);

// ---- Modes of one wave

/// Sorted by growth rate, fastest first, of a conjugate pair the mode of positive frequency.  `shapes` has one row for
/// each of LinearisedAt::state_components(), and one column of norm 1 for each mode; `duals` times `shapes` is the
/// identity.  Near a defective matrix, columns of `shapes` are nearly equal and `duals` is large.
/// LinearisedAt::all_components(q) times `shapes` has all fields.
struct Modes {
    Eigen::VectorXcd rates;  ///< s
    model::Symbol shapes, duals;
    /// The rounding error of each rate: that of the fields coupled to it, in balanced units, times the condition of the
    /// mode, large where modes nearly coincide.
    Eigen::VectorXd roundings;
    /// -Im s; 0 within the rounding error.  Throws an input Error for a mode that does not exist.
    double frequency(Eigen::Index mode) const;
};

/// At q = 0 without the conserved means.  For at most 6 components every growth rate has six digits, however slow the
/// mode is; beyond, the rounding errors are those of double precision relative to the fastest rate.
Modes modes(const model::LinearisedAt& at, const numerics::Wavevector& q);

/// Only the rates, unsorted, with those of the conserved means.
Eigen::VectorXcd mode_rates(const model::LinearisedAt& at, const numerics::Wavevector& q);

/// The largest of them; angle: from the direction of the state [rad].
double growth_rate(const model::LinearisedAt& at, double q, double angle = 0.0);

/// The largest growth rate of one wave, and its Modes::frequency(), 0 for a stationary mode; `rounding`: the size of
/// its rounding error.
struct Growth {
    double rate = 0.0, frequency = 0.0, rounding = 0.0;
    bool grows() const { return rate > rounding; }
};
/// angle: from the direction of the state [rad].  At q = 0 without conserved means; -infinity if there is nothing else.
Growth growth(const model::LinearisedAt& at, double q, double angle = 0.0);

/// The share of each term of Equations::terms() in the rate of a mode (an index of modes(at, q)): shares add up to s.
/// Each is the derivative of s by the logarithm of a factor of the term: left vector, symbol of the term, right vector,
/// both with the fields in balance that follow.  Terms of balances at every point have no share of their own: they are
/// parts of the terms that read their fields.  Throws an input Error for a mode that does not exist.
std::vector<std::complex<double>> term_shares(const model::LinearisedAt& at, const numerics::Wavevector& q,
                                              std::size_t mode = 0);

// ---- Growth over wavenumbers

/// Range of a search: `wavenumbers` values of |q|, evenly spaced in log |q|, at `angles` angles of half a turn where a
/// search has no angles of its own (of one where all directions are equivalent); maxima and edges are then refined.
struct GrowthSearch {
    double min = 1e-3, max = 1e2;  ///< |q|, 0 < min < max
    int wavenumbers = 121;         ///< >= 3
    int angles = 90;               ///< >= 1
};
/// Throws an input Error for an invalid search.
void check(const GrowthSearch& search);

/// A range of |q| at one angle where waves grow, with its fastest wave.
struct Band {
    double min = 0.0, max = 0.0;  ///< edges; the end of the search where the band reaches it
    double q = 0.0;               ///< of the fastest wave
    Growth growth = {};
    bool reaches_min = false, reaches_max = false;  ///< whether growth goes on beyond the search
};
/// Ascending.  Throws an input Error for an invalid search.
std::vector<Band> growth_bands(const model::LinearisedAt& at, double angle, const GrowthSearch& search);

/// The wave of the largest growth rate, which may be below 0.
struct FastestWave {
    double q = 0.0, angle = 0.0;  ///< |q|, and its angle from the direction of the state [rad]; q = 0: uniform
    Growth growth = {};
    bool at_min = false, at_max = false;  ///< the rate increases towards the smallest, the largest |q| of the search
    Eigen::VectorXcd shape;               ///< of all components, norm 1 for those with a rate
    std::vector<std::complex<double>> shares;  ///< of each term: see term_shares
};

// ---- Fluctuations

/// Equal-time structure factors S = <a_q a_q^H>/area of all components, fields in balance included.
struct Covariance {
    model::Symbol matrix;  ///< Hermitian; empty without a stationary state
    std::string why_none;  ///< a mode grows, or noise drives a mode that does not decay
};
/// From m S + S m^H + noise = 0.  Modes that neither grow nor decay, and that no noise drives, do not contribute.
/// Throws an input Error for more than numerics::max_lyapunov components with a rate.
Covariance covariance(const model::LinearisedAt& at, const numerics::Wavevector& q);

/// Only that of the components with a rate, by the complex Schur form of m, which also handles defective m.  Returns
/// the largest growth rate: there is no stationary state unless it is below 0.
double solve_covariance(const model::LinearisedAt& at, const numerics::Wavevector& q, model::Symbol& matrix);

/// S(q, omega) = (-i omega - m)^-1 noise (-i omega - m)^-H of all components; its integral over omega/(2 pi) is S(q).
/// Throws a run Error where a mode has the rate -i omega.
model::Symbol dynamic_structure(const model::LinearisedAt& at, const numerics::Wavevector& q, double omega);

/// Of one wave: one matrix of all components for each frequency or lag.
struct Correlations {
    std::vector<model::Symbol> matrices;  ///< empty without a stationary state
    std::string why_none;                 ///< as Covariance
};
/// dynamic_structure() of the stationary state at these frequencies.  As in covariance(), modes that neither grow nor
/// decay, and that no noise drives, do not contribute.
Correlations dynamic_structures(const model::LinearisedAt& at, const numerics::Wavevector& q,
                                const std::vector<double>& frequencies);

/// Correlations of two times in that state, <a_q(t + n interval) a_q(t)^H>/area for n = 0 .. lags - 1.  Throws an input
/// Error unless interval >= 0 and finite.
Correlations lagged_covariances(const model::LinearisedAt& at, const numerics::Wavevector& q, double interval,
                                std::size_t lags);

/// The names of the parts of LinearisedAt::along_and_across: "phi", "p_along", "p_across".
std::vector<std::string> part_names(const model::Equations& equations);

/// Structure factors of the stored modes of a grid, in parts along and across q.
struct StructureFactors {
    std::vector<std::string> names;            ///< of the parts
    std::vector<std::complex<double>> values;  ///< [mode][part][part]; 0 for modes that are not kept and at q = 0
    std::string why_none;                      ///< of the first mode without a stationary state; values are then empty
    std::complex<double> at(std::size_t mode, std::size_t i, std::size_t j) const {
        return values[(mode * names.size() + i) * names.size() + j];
    }
};
/// Of the modes that are wanted alone; the values of others are 0.
using IsWanted = std::function<bool(std::size_t mode)>;
/// degree: of products, as for numerics::is_kept.  is_wanted: empty for all.
StructureFactors structure_factors(const model::LinearisedAt& at, const numerics::Grid& grid, int degree,
                                   Threads& threads, const IsWanted& is_wanted = {});

// ---- Long waves

/// A slow mode, whose rate vanishes at q = 0: s = -i speed q - damping q^2 as q -> 0.  A mode that diffuses has the
/// speed 0 and its diffusion constant as damping.
struct SlowMode {
    std::complex<double> speed;    ///< its imaginary part above 0: the mode grows, at a rate proportional to q
    std::complex<double> damping;  ///< its real part below 0: it grows, at a rate proportional to q^2; NaN: defective
    Eigen::VectorXcd shape;        ///< norm 1
};

/// Reduced equations of the slow modes after elimination of the fast ones: rates = (-i q U - q^2 D) slow, with
/// U = U_x c + U_y s and D = D_xx c^2 + D_yy s^2 + D_xy c s, c and s the cosine and sine of the angle of q from the x
/// axis.
struct LongWaves {
    Eigen::MatrixXd speed_x, speed_y;                    ///< U
    Eigen::MatrixXd damping_xx, damping_yy, damping_xy;  ///< D
    Eigen::MatrixXd left;   ///< projects a force on the slow modes, one per row: left M right = 1
    Eigen::MatrixXd right;  ///< slow modes, one per column
    std::string why_none;   ///< why s is no power series in q; empty if it is
};
/// Source: second-order perturbation of a semi-simple eigenvalue (Kato, Perturbation Theory for Linear Operators,
/// II.2), for M d/dt = F(q), where F is of second degree in q.  What is slow is found by the singular values of F(0).
LongWaves long_waves(const model::LinearisedAt& at);

/// By speed; shapes are those of LinearisedAt::members().  angle: from the x axis [rad].
std::vector<SlowMode> slow_modes(const LongWaves& waves, double angle);

/// Growth of the fastest slow mode: proportional to q (first = Im speed > 0), else to q^2 (first = 0, second =
/// -damping); without slow modes second is -infinity.
struct SlowGrowth {
    double first = 0.0, second = -std::numeric_limits<double>::infinity();
    /// That of one more mode too.
    void add(std::complex<double> speed, std::complex<double> damping);
    /// Positive if every slow mode decays.  Only its sign is meaningful.
    double margin() const { return first > 0.0 ? -first : -second; }
};
SlowGrowth slow_growth(const LongWaves& waves, double angle);

struct SlowModes {
    std::vector<SlowMode> modes;  ///< by speed, then by damping; shapes of all components
    std::string why_none;         ///< as LongWaves
};
/// angle: from the direction of the state [rad].
SlowModes slow_modes(const model::LinearisedAt& at, double angle = 0.0);

}  // namespace drover::theory
