// run/report/step_bias_estimate.cpp: from the differences that a run has recorded to the bias of each result.
#include <algorithm>

#include "drover/base/text.hpp"
#include "measure/fields.hpp"
#include "run/report/report.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// The rows of /step_bias that count: pieces that begin after the warm-up, comparisons after it.
struct Differences {
    std::vector<double> times;
    std::vector<double> lengths;  ///< of each piece [s]
    std::vector<double> shares;   ///< of each comparison in the time of the run
    std::vector<const double*> late, early;
};

/// Half of the step makes 1/2 (weak order 1) to 1/4 (order 2) of the bias: the difference is 1/2 to 3/4 of it.
constexpr double from_half_a_step = 5.0 / 3.0, its_error = 0.2;
constexpr double correlations_per_piece = 2.0;  // in the whole of it; the late half follows them
constexpr std::size_t min_pieces = 4;

/// Of pieces with twins, longer ones counting more.
StepBiasEstimate by_twins(const Differences& all, std::size_t k, double correlation) {
    double weights = 0.0, late = 0.0, early = 0.0;
    std::vector<std::size_t> used;
    for (std::size_t i = 0; i < all.lengths.size(); ++i) {
        if (!(all.lengths[i] >= correlations_per_piece * correlation) || !std::isfinite(all.late[i][k])) continue;
        used.push_back(i);
        weights += all.lengths[i];
        late += all.lengths[i] * all.late[i][k];
        early += all.lengths[i] * all.early[i][k];
    }
    if (used.size() < min_pieces) return {};
    late /= weights;
    early /= weights;
    double variance = 0.0;
    for (const std::size_t i : used) variance += std::pow(all.lengths[i] / weights * (all.late[i][k] - late), 2);
    // With so few pieces the error is itself uncertain: that of Student's t, twice which holds 95 %.
    const auto count = static_cast<double>(used.size());
    const double few = count / (count - 1.0) * (1.0 + 1.5 / (count - 1.0));
    const double bias = from_half_a_step * late;
    const double error = from_half_a_step * std::hypot(std::sqrt(variance) * few, 0.5 * (late - early));
    return {.bias = bias, .error = std::hypot(error, its_error * bias)};
}

/// The mean over the run of what is linear between comparisons is a sum of these times its values.
std::vector<double> shares_of(const std::vector<double>& times, double begin, double end) {
    std::vector<double> shares;
    for (std::size_t i = 0; i < times.size(); ++i) {
        const double from = i == 0 ? begin : 0.5 * (times[i - 1] + times[i]),
                     to = i + 1 == times.size() ? end : 0.5 * (times[i] + times[i + 1]);
        shares.push_back((to - from) / (end - begin));
    }
    return shares;
}

/// How much larger the error of the fields is over the run than at the comparisons, which may miss its largest values.
double unseen_error(const files::ArchiveReader& archive, double warm_up, const Differences& all) {
    const std::vector<double> times = series_of(archive, "time"), errors = series_of(archive, "step_error");
    if (errors.empty() || all.times.empty()) return 1.0;
    double run = 0.0, samples = 0.0, seen = 0.0;
    for (std::size_t i = 0; i < std::min(times.size(), errors.size()); ++i) {
        if (times[i] < warm_up) continue;
        run += errors[i];
        samples += 1.0;
    }
    for (std::size_t k = 0; k < all.times.size(); ++k) {
        const auto next = std::ranges::lower_bound(times, all.times[k] * (1.0 - 1e-9));
        const auto i = std::min(static_cast<std::size_t>(next - times.begin()), errors.size() - 1);
        seen += errors[i] * all.shares[k];
    }
    if (std::isnan(run) || std::isnan(seen)) return INFINITY;  // not resolved at some samples
    return run > 0.0 && seen > 0.0 ? std::max(1.0, run / samples / seen) : 1.0;
}

/// Of comparisons without noise: the estimated error of the fields is good to a factor of about 3.  It has no waves
/// beyond its coarse grid: where nothing changes, only a constant is known to be right.
StepBiasEstimate by_comparison(const Differences& all, std::size_t k, double unseen, bool is_constant) {
    constexpr double too_much_unseen = 3.0;
    constexpr std::size_t min_comparisons = 6;
    double sum = 0.0, size = 0.0;
    for (std::size_t i = 0; i < all.late.size(); ++i) {
        sum += all.shares[i] * all.late[i][k];
        size += all.shares[i] * std::abs(all.late[i][k]);
    }
    if (size == 0.0 && is_constant) return {0.0, 0.0};
    if (all.late.size() < min_comparisons || !std::isfinite(sum) || size == 0.0 || unseen > too_much_unseen) return {};
    return {.bias = sum, .error = unseen * size};
}

/// d ln DN/d ln N between two boxes.
StepBiasEstimate of_exponent(const StepBiasEstimate& small, double small_variance, const StepBiasEstimate& large,
                             double large_variance, double log_ratio) {
    return {(large.bias / large_variance - small.bias / small_variance) / (2.0 * log_ratio),
            std::hypot(large.error / large_variance, small.error / small_variance) / (2.0 * log_ratio)};
}

void add_boxes(const std::vector<std::string>& densities, const measure::Summary& summary, StepBiases& biases) {
    for (const measure::BoxFamily& family : measure::box_families())
        for (const std::string& what : densities) {
            const std::string start = what + "_number";
            const auto variance = biases.of.find(start + "_variance" + family.ending);
            const auto row_of = [&](const char* result) {
                return measure::find_row(summary.rows, start + result + family.ending);
            };
            const measure::SummaryRow *number = row_of(""), *deviation = row_of("_deviation");
            if (variance == biases.of.end() || number == nullptr || deviation == nullptr) continue;
            const auto mean = [](const measure::SummaryRow& row, std::size_t b) { return row.estimates[b].mean; };
            std::vector<StepBiasEstimate> roots, exponents;
            const std::vector<StepBiasEstimate>& of = variance->second;
            for (std::size_t b = 0; b < of.size(); ++b) {
                const double root = mean(*deviation, b);
                roots.push_back({of[b].bias / (2.0 * root), of[b].error / (2.0 * root)});  // of that of a variance
                exponents.emplace_back();
                if (b + 1 < of.size())
                    exponents.back() = of_exponent(of[b], root * root, of[b + 1], std::pow(mean(*deviation, b + 1), 2),
                                                   std::log(mean(*number, b + 1) / mean(*number, b)));
            }
            biases.of[start + "_deviation" + family.ending] = std::move(roots);
            biases.of[start + "_exponent" + family.ending] = std::move(exponents);
        }
}
}  // namespace

const StepBiasEstimate* StepBiases::find(const std::string& row, std::size_t component) const {
    const auto found = of.find(row);
    return found == of.end() || component >= found->second.size() ? nullptr : &found->second[component];
}

StepBiases step_biases(const files::ArchiveReader& archive, const io::Scene& scene, bool is_exact,
                       const BiasedRows& measured, const measure::Summary& summary) {
    StepBiases biases;
    for (const std::string& density : measured.densities) biases.exact.push_back(density + "_number");
    biases.state = is_exact ? StepBiasState::exact : step_bias_state(scene);
    const std::string group = step_bias_group;
    if (biases.state == StepBiasState::measured && (!measured.has_all || !archive.has(group + "/late")))
        biases.state = StepBiasState::not_measured;
    if (biases.state != StepBiasState::measured) return biases;
    const std::vector<double> times = archive.read(group + "/time").values,
                              steps = archive.read(group + "/steps").values,
                              late = archive.read(group + "/late").values,
                              early = archive.read(group + "/early").values;
    std::size_t size = 0;
    for (const BiasedRows::Row& row : measured.rows) size += row.values;
    const bool noisy = io::has_noise(scene);
    const double warm_up = static_cast<double>(summary.warm_up) *
                           (scene.output.sample_every > 0.0 ? scene.output.sample_every : scene.time.end);
    Differences differences;
    for (std::size_t i = 0; i < times.size() && (i + 1) * size <= late.size(); ++i) {
        const double length = noisy ? steps[i] * scene.time.dt : 0.0;
        if (steps[i] == 0.0 || times[i] - length < warm_up * (1.0 - 1e-9)) continue;
        differences.times.push_back(times[i]);
        differences.lengths.push_back(length);
        differences.late.push_back(late.data() + i * size);
        differences.early.push_back(early.data() + i * size);
    }
    const std::vector<double> samples = archive.read(std::string(field_samples_group) + "/time").values;
    if (!samples.empty() && samples.back() > warm_up)
        differences.shares = shares_of(differences.times, warm_up, samples.back());
    else differences.shares.assign(differences.times.size(), 0.0);
    const double unseen = noisy ? 1.0 : unseen_error(archive, warm_up, differences);
    std::size_t first = 0;
    for (const auto& [name, values, is_of_model, is_of_shells] : measured.rows) {
        const measure::SummaryRow* summarised = measure::find_row(summary.rows, name);
        for (std::size_t k = 0; k < values && is_of_model; ++k) {
            const measure::Estimate* estimate =
                summarised && k < summarised->estimates.size() ? &summarised->estimates[k] : nullptr;
            const double correlation = estimate ? estimate->autocorrelation_time : NAN;
            const bool is_constant = estimate && estimate->error && *estimate->error == 0.0;
            if (noisy) biases.of[name].push_back(by_twins(differences, first + k, correlation));
            else if (is_of_shells && !measured.has_shell[k % measured.has_shell.size()]) biases.of[name].emplace_back();
            else biases.of[name].push_back(by_comparison(differences, first + k, unseen, is_constant));
        }
        first += values;
    }
    add_boxes(measured.densities, summary, biases);
    return biases;
}

std::vector<std::string> step_bias_warnings(const StepBiases& biases, const io::Scene& scene,
                                            const measure::Summary& summary) {
    constexpr double large = 0.1;
    std::string worst;
    double worst_ratio = large;
    std::size_t others = 0;
    for (const measure::SummaryRow& row : summary.rows)
        for (std::size_t k = 0; k < row.estimates.size(); ++k) {
            const StepBiasEstimate* found = biases.find(row.name, k);
            const measure::Estimate& estimate = row.estimates[k];
            const double size = std::abs(estimate.mean), scatter = estimate.error.value_or(NAN);
            if (found == nullptr || !found->is_resolved() || !(size > 10.0 * scatter)) continue;
            // Of several hundred numbers some exceed two standard errors by chance.
            if (!(std::abs(found->bias) > 3.0 * found->error)) continue;
            const double ratio = std::abs(found->bias) / size;
            if (!(ratio > large)) continue;
            ++others;
            if (ratio <= worst_ratio) continue;
            worst_ratio = ratio;
            worst = row.name;
            if (!row.axes.empty() && row.axes.size() == 1)
                worst += text(" at {} = {:.3g} {}", row.axes[0].name, row.axes[0].values[k], row.axes[0].unit);
            worst += text(" by {}", step_bias_text(biases, scene, row.name, k, estimate));
        }
    if (worst.empty()) return {};
    return {text("the time step biases {}{}; expected less than {:.0f} %: choose time.dt = {}", worst,
                 others > 1 ? text(", and {} other numbers by more than a tenth", others - 1) : "", 100.0 * large,
                 scene.time.dt * std::exp2(-std::ceil(std::log2(worst_ratio / large))))};
}

std::string step_bias_text(const StepBiases& biases, const io::Scene& scene, const std::string& row,
                           std::size_t component, const measure::Estimate& estimate) {
    if (biases.state == StepBiasState::exact || std::ranges::find(biases.exact, row) != biases.exact.end())
        return "exact";
    const StepBiasEstimate* found = biases.find(row, component);  // none where it is not measured
    if (found == nullptr) return "not measured";
    const double size = std::abs(estimate.mean);
    const std::string unresolved = text("not resolved (effort {:.3g} %)", 100.0 * scene.accuracy.effort);
    if (!found->is_resolved()) return unresolved;
    if (found->bias == 0.0 && found->error == 0.0) return "0";
    if (!(size > 2.0 * estimate.error.value_or(0.0)))  // a mean that may be zero has no relative error
        return text("{} +- {:.1g}", measured_text(found->bias, found->error), found->error);
    const double percent = 100.0 * found->bias / size, error = 100.0 * found->error / size;
    constexpr double too_uncertain = 100.0;  // per cent
    if (error > too_uncertain) return unresolved;
    return text("{}{} +- {:.1g} %", percent > 0.0 ? "+" : "", measured_text(percent, error), error);
}

}  // namespace drover::run
