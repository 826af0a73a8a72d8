// calibrate/wave_fit.hpp: coefficients of the field equations from recorded waves, by maximum likelihood.
#pragma once
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "base/constants.hpp"
#include "drover/model/symbol.hpp"
#include "drover/numerics/grid.hpp"

namespace drover::calibrate {

/// Fourier amplitudes of the fields at equal times, a(q) = integral of a exp(-i q r)/area.
struct WaveRecord {
    double spacing = 0.0;  ///< between two frames [s]
    double area = 0.0;     ///< of the cell [mm^2]
    std::size_t frames = 0;
    std::vector<numerics::Wavevector> q = {};  ///< one of each pair q and -q; (0, 0) for the means of v and p
    /// Of each wave, frame after frame: the fields, vectors by components.
    std::vector<std::vector<std::complex<double>>> amplitudes = {};
};

/// Every k-th frame.
WaveRecord thinned(const WaveRecord& record, std::size_t every);

/// A number to be fitted.
struct FittedNumber {
    std::string key;
    double start = 0.0;
    double min = -infinite;
};

/// The linear equations of waves about a uniform state: d/dt of the fields of a record at q, and the strengths of their
/// noise, <f f^H> = noise delta(t - t') per area.
struct LinearWaves {
    std::function<model::Symbol(const numerics::Wavevector&)> symbol, noise;
};

/// What is fitted to the fields of a record.
struct WaveModel {
    /// Of each field of the record: one whose mean is conserved does not fluctuate at q = 0, nor where its amplitude is
    /// the rounding error of `size`.
    struct Field {
        bool is_conserved = false;
        double size = 0.0;
    };
    std::vector<Field> fields;
    std::vector<FittedNumber> numbers;
    std::function<LinearWaves(const std::vector<double>&)> at;  ///< for values of the numbers
};

struct FittedValue {
    double value = 0.0;
    /// Standard error, from the scatter of segments of time, which also holds where waves do not follow the model
    /// exactly, or error_of_model where that is larger.
    double error = 0.0;
    double error_of_model = 0.0;            ///< the one that the model predicts, by its Fisher information
    bool at_bound = false;                  ///< the value is its lower bound, towards which the likelihood increases
    std::vector<double> correlations = {};  ///< of its error with those of all values
};
struct WaveFit {
    std::vector<FittedValue> values;  ///< in the order of the fitted numbers
    int iterations = 0;
};

inline constexpr std::size_t min_wave_pairs = 64;

/// The covariance of the noise of a step: that of the model, which its strengths determine; or the one that makes the
/// frames most likely, which may have any correlations between fields (as those of particles have), so that decay and
/// couplings alone count.
enum class NoiseOf { model, frames };

/// Fits numbers of a model to waves.  The linear equations da/dt = M(q) a + noise give each frame
/// from the one before,
///     a(t + s) = exp(M s) a(t) + f,    <f f^H> = integral over 0 < t < s of exp(M t) Q exp(M^H t)/area,
/// so the likelihood of all frames is exact at any spacing s.  Its maximum is found by scoring (Gauss-Newton steps with
/// the expected information) from the values at the start.
/// Sources: covariance of the noise, Van Loan, IEEE Trans. Autom. Control 23, 395 (1978); errors, White, Econometrica
/// 50, 1 (1982).
/// Throws an input Error for too few frames, for waves that noise does not reach, and for numbers that the waves do not
/// determine, alone or together; a run Error where no maximum is found.
WaveFit fit_waves(const WaveModel& model, const WaveRecord& record, NoiseOf noise);

}  // namespace drover::calibrate
