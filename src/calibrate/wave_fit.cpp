// calibrate/wave_fit.cpp: the likelihood of waves, its slopes and its maximum.
#include "calibrate/wave_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "drover/base/error.hpp"
#include "drover/base/text.hpp"
#include "numerics/algebra/dense.hpp"

namespace drover::calibrate {

namespace {
using Matrix = Eigen::MatrixXcd;  // of few rows, but types of fixed size take a minute to compile
using Eigen::MatrixXd;
using Eigen::VectorXd;

// One product and one adjoint for all: each expression of Eigen would be compiled with kernels of its own.
Matrix product(const Matrix& a, const Matrix& b) { return a.lazyProduct(b); }
Matrix adjoint(const Matrix& a) { return a.adjoint(); }

constexpr std::size_t segments = 32;  // of time, for the errors; each at least two pairs long

/// Sums over pairs of frames a, a': all that the likelihood needs of them.
struct PairSums {
    Matrix first, second, crossed;  ///< of a a^H, a' a'^H, a' a^H
    double pairs = 0.0;
};
PairSums& operator+=(PairSums& sums, const PairSums& other) {
    sums.first += other.first;
    sums.second += other.second;
    sums.crossed += other.crossed;
    sums.pairs += other.pairs;
    return sums;
}

/// One wave: the places of its fluctuating fields, and the sums over each segment and over all.
struct Wave {
    numerics::Wavevector q;
    std::vector<int> places;
    double weight = 1.0;  ///< 1/2 of the real amplitudes at q = 0
    std::vector<PairSums> parts;
    PairSums all;
};

using Amplitudes = Eigen::Map<const Eigen::MatrixXcd>;  // a column for each frame

PairSums sums_of(const Eigen::MatrixXcd& a, Eigen::Index begin, Eigen::Index end) {
    const Matrix first = a.middleCols(begin, end - begin), second = a.middleCols(begin + 1, end - begin);
    return {.first = product(first, adjoint(first)),
            .second = product(second, adjoint(second)),
            .crossed = product(second, adjoint(first)),
            .pairs = static_cast<double>(end - begin)};
}

Wave wave_of(const WaveRecord& record, std::size_t n, const std::vector<WaveModel::Field>& fields) {
    Wave wave{.q = record.q[n]};
    const bool is_mean = wave.q.x == 0.0 && wave.q.y == 0.0;
    const Amplitudes whole(record.amplitudes[n].data(), static_cast<Eigen::Index>(fields.size()),
                           static_cast<Eigen::Index>(record.frames));
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (!fields[i].is_conserved || (!is_mean && whole.row(row).cwiseAbs().maxCoeff() > 1e-12 * fields[i].size))
            wave.places.push_back(static_cast<int>(i));
    }
    if (is_mean) wave.weight = 0.5;
    const Eigen::MatrixXcd amplitudes = whole(wave.places, Eigen::all);
    const Eigen::Index pairs = amplitudes.cols() - 1;
    const auto count = static_cast<Eigen::Index>(segments);
    for (Eigen::Index s = 0; s < count; ++s)
        wave.parts.push_back(sums_of(amplitudes, s * pairs / count, (s + 1) * pairs / count));
    wave.all = wave.parts.front();
    for (std::size_t s = 1; s < segments; ++s) wave.all += wave.parts[s];
    return wave;
}

Matrix residual(const PairSums& sums, const Matrix& propagator) {
    const Matrix crossed = product(propagator, adjoint(sums.crossed));
    return sums.second - crossed - adjoint(crossed) + product(product(propagator, sums.first), adjoint(propagator));
}

/// exp(M s), and the covariance of the noise over s.
struct Step {
    Matrix propagator, noise;
};

/// Van Loan's block matrix gives both for a part of the spacing in which nothing decays by much: it contains exp(-M s),
/// beside which they would be lost.  Two parts after each other make a longer one, without cancellation.
Step step_of(const Matrix& m, const Matrix& noise, double spacing) {
    const Eigen::Index n = m.rows();
    const double rates = spacing * numerics::balanced(m).cwiseAbs().rowwise().sum().maxCoeff();
    const int doublings = rates > 1.0 && std::isfinite(rates) ? static_cast<int>(std::ceil(std::log2(rates))) : 0;
    const double part = std::ldexp(spacing, -doublings);
    Eigen::MatrixXcd block = Eigen::MatrixXcd::Zero(2 * n, 2 * n);
    block.topLeftCorner(n, n) = -part * m;
    block.topRightCorner(n, n) = part * noise;
    block.bottomRightCorner(n, n) = part * m.adjoint();
    const Matrix grown = numerics::exponential(block);
    Matrix propagator = grown.bottomRightCorner(n, n).adjoint();
    Matrix covariance = product(propagator, grown.topRightCorner(n, n));
    for (int k = 0; k < doublings; ++k) {
        covariance += product(product(propagator, covariance), adjoint(propagator));
        propagator = product(propagator, propagator);
    }
    return {.propagator = propagator, .noise = 0.5 * (covariance + covariance.adjoint())};
}

/// Inverse and log-determinant of the covariance of the noise, scaled to unit diagonal: fields have different units.
struct Whitening {
    Matrix inverse;
    double log_determinant = 0.0;
};
std::optional<Whitening> whitening_of(const Matrix& noise) {
    const VectorXd scale = noise.diagonal().real().cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) return std::nullopt;
    const Matrix even = scale.asDiagonal() * noise * scale.asDiagonal();
    const Eigen::LLT<Matrix> root(even);
    if (root.info() != Eigen::Success) return std::nullopt;
    const VectorXd diagonal = root.matrixLLT().diagonal().real();
    const Matrix inverse = root.solve(Matrix::Identity(even.rows(), even.cols()));
    return Whitening{.inverse = scale.asDiagonal() * inverse * scale.asDiagonal(),
                     .log_determinant = 2.0 * (diagonal.array().log().sum() - scale.array().log().sum())};
}

/// Minus the logarithm of the likelihood with its slopes, per segment and in all.
struct Slopes {
    VectorXd gradient;
    MatrixXd by_segment;   ///< a column for each segment
    MatrixXd information;  ///< Fisher's
};

class Likelihood {
public:
    Likelihood(const WaveModel& model, const WaveRecord& record, NoiseOf noise)
        : model_(model), noise_(noise), spacing_(record.spacing), area_(record.area) {
        for (std::size_t n = 0; n < record.q.size(); ++n) waves_.push_back(wave_of(record, n, model.fields));
    }

    VectorXd start() const {
        VectorXd values(static_cast<Eigen::Index>(model_.numbers.size()));
        for (Eigen::Index i = 0; i < values.size(); ++i) values(i) = number(i).start;
        return values;
    }

    /// Minus the logarithm of the likelihood; infinite where some amplitude has no noise.
    double value(const VectorXd& values) const {
        const LinearWaves e = equations(values);
        double sum = 0.0;
        for (const Wave& wave : waves_) {
            const Step step = step_of(e, wave);
            const std::optional<Whitening> white = whitening_of(step.noise);
            if (!white) return infinite;
            sum += wave.weight * (wave.all.pairs * white->log_determinant +
                                  product(white->inverse, residual(wave.all, step.propagator)).trace().real());
        }
        return std::isfinite(sum) ? sum : infinite;
    }

    /// The first wave with an amplitude that no noise reaches, for messages.
    std::string without_noise(const VectorXd& values) const {
        const LinearWaves e = equations(values);
        for (const Wave& wave : waves_)
            if (!whitening_of(step_of(e, wave).noise)) return text("q = ({:.4g}, {:.4g})", wave.q.x, wave.q.y);
        return "some q";
    }

    /// Central differences over `steps` give the slopes of propagator and noise; all else is exact.
    Slopes slopes(const VectorXd& values, const VectorXd& steps) const {
        const Eigen::Index n = values.size();
        Slopes result{.gradient = VectorXd::Zero(n),
                      .by_segment = MatrixXd::Zero(n, static_cast<Eigen::Index>(segments)),
                      .information = MatrixXd::Zero(n, n)};
        const LinearWaves at = equations(values);
        std::vector<LinearWaves> below, above;
        VectorXd widths(n);
        for (Eigen::Index i = 0; i < n; ++i) {
            VectorXd low = values, high = values;
            low(i) = std::max(values(i) - steps(i), number(i).min);
            high(i) = values(i) + steps(i);
            widths(i) = high(i) - low(i);
            below.push_back(equations(low));
            above.push_back(equations(high));
        }
        for (const Wave& wave : waves_) {
            const Step step = step_of(at, wave);
            const std::optional<Whitening> white = whitening_of(step.noise);
            if (!white) continue;  // value() is infinite there
            std::vector<Step> slope;
            for (Eigen::Index i = 0; i < n; ++i) {
                const Step low = step_of(below[static_cast<std::size_t>(i)], wave),
                           high = step_of(above[static_cast<std::size_t>(i)], wave);
                slope.push_back({.propagator = (high.propagator - low.propagator) / widths(i),
                                 .noise = (high.noise - low.noise) / widths(i)});
                if (noise_ == NoiseOf::frames) slope.back().noise.setZero();  // it is the most likely one everywhere
            }
            add(wave, step, *white, slope, result);
        }
        result.gradient = result.by_segment.rowwise().sum();
        return result;
    }

    /// The largest change of a rate or of a strength of noise by a step of one number, in parts of it.
    double change(const VectorXd& values, Eigen::Index i, double step) const {
        VectorXd next = values;
        next(i) += step;
        const LinearWaves from = equations(values), to = equations(next);
        double largest = 0.0;
        const auto compare = [&](const model::Symbol& one, const model::Symbol& other) {
            for (Eigen::Index k = 0; k < one.size(); ++k)
                if (const double size = std::abs(one.data()[k]); size > 0.0)
                    largest = std::max(largest, std::abs(other.data()[k] - one.data()[k]) / size);
        };
        for (const Wave& wave : waves_) {
            compare(from.symbol(wave.q), to.symbol(wave.q));
            if (noise_ == NoiseOf::model) compare(from.noise(wave.q), to.noise(wave.q));
        }
        return largest;
    }

    const FittedNumber& number(Eigen::Index i) const { return model_.numbers[static_cast<std::size_t>(i)]; }

private:
    Step step_of(const LinearWaves& e, const Wave& wave) const {
        const Matrix m = e.symbol(wave.q)(wave.places, wave.places);
        if (noise_ == NoiseOf::model) {
            const Matrix noise = e.noise(wave.q)(wave.places, wave.places);
            return calibrate::step_of(m, noise / area_, spacing_);
        }
        const Matrix propagator = numerics::exponential(spacing_ * m);
        return {.propagator = propagator, .noise = residual(wave.all, propagator) / wave.all.pairs};
    }

    LinearWaves equations(const VectorXd& values) const { return model_.at({values.begin(), values.end()}); }

    static void add(const Wave& wave, const Step& step, const Whitening& white, const std::vector<Step>& slope,
                    Slopes& to) {
        const auto n = static_cast<Eigen::Index>(slope.size());
        std::vector<Matrix> noise, turned;  // white slopes
        for (const Step& one : slope) {
            noise.push_back(product(white.inverse, one.noise));
            turned.push_back(product(white.inverse, one.propagator));
        }
        for (std::size_t s = 0; s < segments; ++s) {
            const PairSums& sums = wave.parts[s];
            const Matrix left = product(white.inverse, residual(sums, step.propagator));
            const Matrix missed = sums.crossed - product(step.propagator, sums.first);  // of a' given a, with a
            for (Eigen::Index i = 0; i < n; ++i) {
                const auto k = static_cast<std::size_t>(i);
                const std::complex<double> by_noise = sums.pairs * noise[k].trace() - product(noise[k], left).trace(),
                                           by_step = product(turned[k], adjoint(missed)).trace();
                to.by_segment(i, static_cast<Eigen::Index>(s)) += wave.weight * (by_noise - 2.0 * by_step).real();
            }
        }
        for (Eigen::Index i = 0; i < n; ++i)
            for (Eigen::Index j = 0; j < n; ++j) {
                const auto k = static_cast<std::size_t>(i), l = static_cast<std::size_t>(j);
                const std::complex<double> by_noise = wave.all.pairs * product(noise[k], noise[l]).trace(),
                                           by_step =
                                               product(product(turned[k], wave.all.first), adjoint(slope[l].propagator))
                                                   .trace();
                to.information(i, j) += wave.weight * (by_noise + 2.0 * by_step).real();
            }
    }

    const WaveModel& model_;
    NoiseOf noise_;
    double spacing_, area_;
    std::vector<Wave> waves_;
};

/// Steps for differences: a thousandth of a standard error, and no less than rounding allows.
VectorXd difference_steps(const VectorXd& values, const VectorXd& errors) {
    return (1e-3 * errors).cwiseMax(1e-6 * values.cwiseAbs());
}

/// Before errors are known: parts of the values, larger where they are lost in the rounding of other numbers.
VectorXd first_steps(const VectorXd& values, const Likelihood& likelihood) {
    VectorXd steps = difference_steps(values, VectorXd::Zero(values.size()));
    constexpr double enough = 1e-9;  // of the rates: rounding leaves six digits of the difference
    for (Eigen::Index i = 0; i < values.size(); ++i) {
        const double largest = std::max(std::abs(values(i)), 1e-12);  // a value of 0 has no size
        if (steps(i) == 0.0) steps(i) = largest;
        while (steps(i) < largest && likelihood.change(values, i, steps(i)) < enough)
            steps(i) = std::min(10.0 * steps(i), largest);
    }
    return steps;
}

/// Inverse of the information; throws where a combination of numbers is not determined.
MatrixXd covariance_of(const MatrixXd& information, const Likelihood& likelihood) {
    const VectorXd diagonal = information.diagonal();
    for (Eigen::Index i = 0; i < diagonal.size(); ++i)
        require(diagonal(i) > 0.0, {}, "the waves do not depend on {}; expected numbers that change them: leave it out",
                likelihood.number(i).key);
    const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
    const MatrixXd even = scale.asDiagonal() * information * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(even);
    if (modes.eigenvalues()(0) < 1e-9) {
        const VectorXd weak = modes.eigenvectors().col(0);
        std::vector<std::string> together;
        for (Eigen::Index i = 0; i < weak.size(); ++i)
            if (std::abs(weak(i)) > 0.1) together.push_back(likelihood.number(i).key);
        fail_input({},
                   "the waves determine only a combination of {}; expected numbers that change them differently: "
                   "leave one of these out, and give its value to the scene",
                   joined(together, " and "));
    }
    const MatrixXd inverse =
        modes.eigenvectors() * modes.eigenvalues().cwiseInverse().asDiagonal() * modes.eigenvectors().transpose();
    return scale.asDiagonal() * inverse * scale.asDiagonal();
}

/// A step of scoring: damping times the diagonal is added to the information; numbers that would pass their bound stay
/// there.
VectorXd scored(const VectorXd& values, const Slopes& slopes, double damping, const Likelihood& likelihood) {
    const Eigen::Index n = values.size();
    std::vector<Eigen::Index> free(static_cast<std::size_t>(n));
    std::iota(free.begin(), free.end(), Eigen::Index{0});
    const auto min_of = [&](Eigen::Index i) { return likelihood.number(i).min; };
    std::erase_if(free, [&](Eigen::Index i) { return values(i) <= min_of(i) && slopes.gradient(i) > 0.0; });
    const VectorXd diagonal = slopes.information.diagonal()(free);
    const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
    MatrixXd even = scale.asDiagonal() * MatrixXd(slopes.information(free, free)) * scale.asDiagonal();
    even.diagonal().array() += damping;
    const VectorXd step = scale.asDiagonal() * even.ldlt().solve(scale.asDiagonal() * VectorXd(slopes.gradient(free)));
    VectorXd next = values;
    for (std::size_t k = 0; k < free.size(); ++k) {
        const Eigen::Index i = free[k];
        next(i) = std::max(values(i) - step(static_cast<Eigen::Index>(k)), min_of(i));
    }
    return next;
}

/// Of a trial step, which may leave the numbers that the equations allow, such as those of a noise.
double value_of(const VectorXd& values, const Likelihood& likelihood) {
    try {
        return likelihood.value(values);
    } catch (const Error& error) {
        if (error.fault() != Fault::input) throw;
        return infinite;
    }
}

/// The fit at the maximum.  Its errors: information^-1 (sum of g g^T over segments) information^-1, g being the slopes
/// of one segment; or those of the model, which are larger where few segments hold most of the information.
WaveFit fit_at(const VectorXd& values, const Likelihood& likelihood, const VectorXd& steps, int iterations) {
    const Slopes slopes = likelihood.slopes(values, steps);
    const MatrixXd covariance = covariance_of(slopes.information, likelihood);
    const auto count = static_cast<double>(segments);
    const MatrixXd centred = slopes.by_segment.colwise() - slopes.gradient / count;
    const MatrixXd scatter = centred * centred.transpose() * (count / (count - 1.0));
    const MatrixXd errors = covariance * scatter * covariance;
    WaveFit fit{.iterations = iterations};
    for (Eigen::Index i = 0; i < values.size(); ++i)
        fit.values.push_back({.value = values(i),
                              .error = std::sqrt(std::max(errors(i, i), covariance(i, i))),
                              .error_of_model = std::sqrt(covariance(i, i)),
                              .at_bound = values(i) <= likelihood.number(i).min});
    for (Eigen::Index i = 0; i < values.size(); ++i)
        for (Eigen::Index j = 0; j < values.size(); ++j)
            fit.values[static_cast<std::size_t>(i)].correlations.push_back(errors(i, j) /
                                                                           std::sqrt(errors(i, i) * errors(j, j)));
    return fit;
}
}  // namespace

WaveFit fit_waves(const WaveModel& model, const WaveRecord& record, NoiseOf noise) {
    require(!model.numbers.empty(), {}, "no number to fit; expected at least one, such as relaxation.rate");
    require(!record.q.empty(), {}, "no wave; expected at least one");
    require(record.frames > min_wave_pairs, {}, "{} frames; expected at least {}: record more frames", record.frames,
            min_wave_pairs + 1);
    const Likelihood likelihood(model, record, noise);
    VectorXd values = likelihood.start(), steps = first_steps(values, likelihood);
    double value = likelihood.value(values);
    require(
        std::isfinite(value) || noise == NoiseOf::model, {},
        "the frames show no noise in some field of the wave at {}; expected fluctuations: leave out the frames of a "
        "start, or waves that nothing drives",
        likelihood.without_noise(values));
    require(
        std::isfinite(value), {},
        "the scene has no noise that reaches every field of the wave at {}; expected noise of each field, or of one "
        "that drives it: such as noise.order, and driving.strength for the beads",
        likelihood.without_noise(values));
    constexpr int max_iterations = 200;
    double damping = 1e-3;
    for (int iteration = 1; iteration <= max_iterations; ++iteration) {
        const Slopes slopes = likelihood.slopes(values, steps);
        const VectorXd errors = covariance_of(slopes.information, likelihood).diagonal().cwiseSqrt();
        steps = difference_steps(values, errors);
        bool is_better = false;
        VectorXd next = values;
        double found = value;
        for (; damping < 1e12 && !is_better; damping *= is_better ? 0.1 : 10.0) {
            next = scored(values, slopes, damping, likelihood);
            found = value_of(next, likelihood);
            is_better = found <= value;
        }
        const auto errors_to = [&](const VectorXd& other) {
            return ((other - values).array() / errors.array()).abs().maxCoeff();
        };
        // No step is better: at a maximum, up to rounding, or where the likelihood cannot be followed further.
        if (!is_better && !(errors_to(scored(values, slopes, 0.0, likelihood)) < 1e-2)) break;
        const double moved = errors_to(next);
        if (is_better) values = next, value = found;
        if (!is_better || moved < 1e-4) return fit_at(values, likelihood, steps, iteration);
    }
    std::vector<std::string> reached;
    for (Eigen::Index i = 0; i < values.size(); ++i)
        reached.push_back(text("{} = {:.4g}", likelihood.number(i).key, values(i)));
    fail_run("no maximum of the likelihood in {} steps, at {}; expected one: start from values nearer to it",
             max_iterations, joined(reached));
}

WaveRecord thinned(const WaveRecord& record, std::size_t every) {
    WaveRecord result{.spacing = record.spacing * static_cast<double>(every),
                      .area = record.area,
                      .frames = (record.frames + every - 1) / every,
                      .q = record.q};
    for (const auto& all : record.amplitudes) {
        const std::size_t fields = all.size() / record.frames;
        std::vector<std::complex<double>> kept;
        for (std::size_t frame = 0; frame < record.frames; frame += every)
            kept.insert(kept.end(), all.begin() + static_cast<std::ptrdiff_t>(frame * fields),
                        all.begin() + static_cast<std::ptrdiff_t>((frame + 1) * fields));
        result.amplitudes.push_back(std::move(kept));
    }
    return result;
}
}  // namespace drover::calibrate
