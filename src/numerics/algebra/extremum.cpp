// numerics/algebra/extremum.cpp: the simplex of GSL, and least squares.
#include "numerics/algebra/extremum.hpp"

#include <gsl/gsl_fit.h>
#include <gsl/gsl_multimin.h>

#include <Eigen/Dense>
#include <memory>

#include "base/mapped.hpp"

namespace drover::numerics {

std::vector<double> even_logarithms(double min, double max, int count) {
    const double first = std::log(min), last = std::log(max);
    return mapped(std::views::iota(0, count), [&](int k) { return first + (last - first) * k / (count - 1); });
}

std::pair<double, double> climbed(const std::function<double(double, double)>& function, std::pair<double, double> from,
                                  std::pair<double, double> steps, std::pair<double, double> range) {
    using Function = std::function<double(double, double)>;
    gsl_multimin_function downhill{.f =
                                       [](const gsl_vector* v, void* f) {
                                           return -(*static_cast<const Function*>(f))(gsl_vector_get(v, 0),
                                                                                      gsl_vector_get(v, 1));
                                       },
                                   .n = 2,
                                   .params = const_cast<Function*>(&function)};
    using Vector = std::unique_ptr<gsl_vector, void (*)(gsl_vector*)>;
    const auto vector = [](std::pair<double, double> values) {
        Vector made(gsl_vector_alloc(2), gsl_vector_free);
        gsl_vector_set(made.get(), 0, values.first);
        gsl_vector_set(made.get(), 1, values.second);
        return made;
    };
    const Vector start = vector(from), first_steps = vector(steps);
    const std::unique_ptr<gsl_multimin_fminimizer, void (*)(gsl_multimin_fminimizer*)> simplex(
        gsl_multimin_fminimizer_alloc(gsl_multimin_fminimizer_nmsimplex2, 2), gsl_multimin_fminimizer_free);
    gsl_multimin_fminimizer_set(simplex.get(), &downhill, start.get(), first_steps.get());
    constexpr int max_steps = 400, max_without_gain = 30;
    constexpr double beyond = 2.0;  // whence the simplex may come back
    double best = simplex->fval;
    for (int i = 0, without_gain = 0; i < max_steps && without_gain < max_without_gain; ++i) {
        if (gsl_multimin_fminimizer_iterate(simplex.get()) != 0 || gsl_multimin_fminimizer_size(simplex.get()) < 1e-8)
            break;
        const double x = gsl_vector_get(simplex->x, 0);
        if (x < range.first - beyond || x > range.second + beyond) break;
        without_gain = simplex->fval < best ? 0 : without_gain + 1;
        best = simplex->fval;
    }
    return {gsl_vector_get(simplex->x, 0), gsl_vector_get(simplex->x, 1)};
}

Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights) {
    Line line;
    double covariance[3], chi_square = 0.0;
    gsl_fit_wlinear(x.data(), 1, weights.data(), 1, y.data(), 1, x.size(), &line.at_zero, &line.slope, &covariance[0],
                    &covariance[1], &covariance[2], &chi_square);
    return line;
}

Line fit_line_of_times(std::span<const double> x, std::span<const double> y) {
    return fit_line(x, y, mapped(x, [](double one) { return 1.0 / (one * one); }));
}

std::vector<double> least_squares(const std::vector<std::vector<double>>& columns, const std::vector<double>& y) {
    const auto rows = static_cast<Eigen::Index>(y.size()), unknowns = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd matrix(rows, unknowns);
    for (Eigen::Index k = 0; k < unknowns; ++k)
        matrix.col(k) = Eigen::Map<const Eigen::VectorXd>(columns[static_cast<std::size_t>(k)].data(), rows);
    const auto solver = matrix.colPivHouseholderQr();
    std::vector<double> factors(columns.size(), nan);
    if (solver.rank() < unknowns) return factors;
    Eigen::Map<Eigen::VectorXd>(factors.data(), unknowns) =
        solver.solve(Eigen::Map<const Eigen::VectorXd>(y.data(), rows));
    return factors;
}

}  // namespace drover::numerics
