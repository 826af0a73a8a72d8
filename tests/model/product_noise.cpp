// tests/model/product_noise.cpp: white noises that multiply fields, in the sense of Ito.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "drover/base/error.hpp"
#include "drover/model/evolution.hpp"
#include "drover/model/linearised_at.hpp"

namespace drover::model::product_noise_tests {
namespace {

constexpr double pi = std::numbers::pi;

Field scalar(const std::string& symbol, const std::string& equation, double reference = 0.0) {
    return {.name = symbol, .symbol = symbol, .equation = {equation, {}}, .reference = reference};
}

Model with_noise(std::vector<Field> fields, std::vector<WhiteNoise> noises,
                 std::map<std::string, double> coefficients = {}) {
    Model model{.fields = std::move(fields), .definitions = {}, .coefficients = std::move(coefficients)};
    model.noises = std::move(noises);
    return model;
}

double mean_of(std::span<const double> values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

TEST(ProductNoiseLong, that_multiplies_a_field_has_the_moments_of_ito) {
    // d_t u = -k u + D lap u + s u xi from u = 1, on the kept modes K.  Its mean decays with exp(-k t), and the powers
    // of its modes obey d_t P_q = -2 (k + D q^2) P_q + s^2/A sum over p in K with q - p in K of P_p.
    constexpr double k = 0.3, D = 0.2, s = 0.8, side = 6.0, end = 1.0;
    constexpr int kept = 2, runs = 600;  // 8 points, products of two factors: |k| < 8/3
    const numerics::Grid grid{.nx = 8, .ny = 8, .lx = side, .ly = side};
    std::map<std::pair<int, int>, double> power;
    for (int i = -kept; i <= kept; ++i)
        for (int j = -kept; j <= kept; ++j) power[{i, j}] = i == 0 && j == 0 ? 1.0 : 0.0;
    constexpr int parts = 4000;
    for (int n = 0; n < parts; ++n) {  // Euler: 1e-4 of the powers
        std::map<std::pair<int, int>, double> rate;
        for (const auto& [q, of_q] : power) {
            const double square = std::pow(2.0 * pi / side, 2) * (q.first * q.first + q.second * q.second);
            rate[q] = -2.0 * (k + D * square) * of_q;
            for (const auto& [p, of_p] : power)
                if (power.contains({q.first - p.first, q.second - p.second})) rate[q] += s * s / (side * side) * of_p;
        }
        for (auto& [q, of_q] : power) of_q += end / parts * rate[q];
    }
    double all = 0.0;
    for (const auto& [q, of_q] : power) all += of_q;
    const Equations equations(
        with_noise({scalar("u", "-k u + D lap u + s u xi", 1.0)}, {{.symbol = "xi"}}, {{"k", k}, {"D", D}, {"s", s}}));
    double mean = 0.0, mean_square = 0.0, square = 0.0, square_square = 0.0;
    for (int run = 1; run <= runs; ++run) {
        Evolution evolution(equations, {.grid = grid, .dt = 1.0 / 32, .seed = static_cast<std::uint64_t>(run)});
        evolution.advance(32);
        const numerics::Fields fields = evolution.fields();
        const double here = mean_of(fields[0]);
        double squares = 0.0;
        for (const double value : fields[0]) squares += value * value / 64.0;
        mean += here / runs, mean_square += here * here / runs;
        square += squares / runs, square_square += squares * squares / runs;
    }
    const double error = std::sqrt((mean_square - mean * mean) / runs),
                 error_of_square = std::sqrt((square_square - square * square) / runs);
    // Stratonovich's drift s^2 25/(2 A) would make the mean exp(0.22) times as large, that is over 20 errors.
    EXPECT_LT(error, 0.01);
    EXPECT_NEAR(mean, std::exp(-k * end), 3.0 * error);
    // The steps are wrong by some 1/32 of what noise adds, half of an error.
    EXPECT_LT(error_of_square, 0.03 * all);
    EXPECT_NEAR(square, all, 3.5 * error_of_square);
}

TEST(ProductNoise, of_a_uniform_strength_is_exact_in_steps_of_any_length) {
    // The strength is as good as uniform, and the slowest mode decays within two steps.
    const Equations equations(
        with_noise({scalar("u", "-k u + D lap u + (1 + 1e-13 u) xi")}, {{.symbol = "xi"}}, {{"k", 0.3}, {"D", 1.0}}));
    const numerics::Grid grid{.nx = 8, .ny = 8, .lx = 6.0, .ly = 6.0};
    Evolution whole(equations, {.grid = grid, .dt = 4.0}), parts(equations, {.grid = grid, .dt = 1.0});
    double square = 0.0;
    constexpr int steps = 4000;
    for (int n = 0; n < steps; ++n) {
        whole.advance(1);
        if (n < 4) {
            parts.advance(4);
            const numerics::Fields one = whole.fields(), other = parts.fields();
            for (std::size_t i = 0; i < 64; ++i) ASSERT_NEAR(one.values[i], other.values[i], 1e-10);
        }
        for (const double value : whole.fields().values) square += value * value / (64.0 * steps);
    }
    double expected = 0.0;
    for (int i = -2; i <= 2; ++i)
        for (int j = -2; j <= 2; ++j) expected += 0.5 / (0.3 + std::pow(2.0 * pi / 6.0, 2) * (i * i + j * j)) / 36.0;
    EXPECT_NEAR(square, expected, 0.03 * expected);  // the mean alone has 1.6/(0.3 4000) of variance a run: 1.5 %
}

TEST(ProductNoise, has_the_strength_of_the_start_of_a_step) {
    // In one step u falls to 1/e: with the strength of its end, noise would have 1/e^2 of the variance.
    constexpr double strength = 1e-3;
    const Equations equations(with_noise({scalar("u", "-u + s u xi", 1.0)}, {{.symbol = "xi"}}, {{"s", strength}}));
    Evolution run(equations, {.grid = {.nx = 64, .ny = 64, .lx = 64.0, .ly = 64.0}, .dt = 1.0});
    run.advance(1);
    const numerics::Fields fields = run.fields();
    const double mean = mean_of(fields[0]);
    double variance = 0.0;
    for (const double value : fields[0]) variance += (value - mean) * (value - mean) / 4096.0;
    EXPECT_NEAR(mean, std::exp(-1.0), 1e-4);  // its noise: 1e-3/64
    // Modes of products of two factors: |k| < 64/3.  1848 of them have a scatter of 3.3 %.
    const double expected = strength * strength * 0.5 * (1.0 - std::exp(-2.0)) / 4096.0 * (43 * 43 - 1);
    EXPECT_NEAR(variance, expected, 0.1 * expected);
}

TEST(ProductNoise, of_independent_walkers_keeps_their_poisson_fluctuations) {
    // d_t c = D lap c + div(sqrt(2 D c) xi) of Dean: S(q) = <c> at all q, whatever the density.
    const Equations equations(
        with_noise({scalar("c", "D lap c + div(sqrt(2 D c) xi)", 40.0)}, {{.symbol = "xi", .spin = 1}}, {{"D", 1.0}}));
    const numerics::Grid grid{.nx = 16, .ny = 16, .lx = 16.0, .ly = 16.0};
    Evolution run(equations, {.grid = grid, .dt = 0.25});
    double variance = 0.0;
    run.advance(200);
    constexpr int samples = 1200;
    for (int n = 0; n < samples; ++n) {
        run.advance(4);
        const numerics::Fields fields = run.fields();
        EXPECT_NEAR(mean_of(fields[0]), 40.0, 1e-9);  // conserved
        for (const double value : fields[0]) variance += std::pow(value - 40.0, 2) / (256.0 * samples);
    }
    // 48 modes beside the mean are kept (a root counts as two factors, with its noise three: |k| < 16/4), each with the
    // variance 40/A; the slowest four decay in 6.5 s.  48 modes of 1200 samples: 1 %.
    EXPECT_NEAR(variance, 40.0 / 256.0 * 48.0, 0.03 * 7.5);
}

TEST(ProductNoise, that_two_fields_share_has_one_value_for_both) {
    const Model model =
        with_noise({scalar("a", "-a + a zeta", 0.7), scalar("b", "-2 b - 3 zeta", 0.2)}, {{.symbol = "zeta"}});
    const Equations equations(model);
    EXPECT_TRUE(equations.has_product_noise());
    const Symbol found = equations.noise({0.7, 0.2}, {0.4, 0.3}), other = equations.noise({-2.0, 0.2}, {0.4, 0.3});
    EXPECT_NEAR(std::abs(found(0, 0) - 0.49), 0.0, 1e-15);
    EXPECT_NEAR(std::abs(found(0, 1) + 2.1), 0.0, 1e-15);
    EXPECT_NEAR(std::abs(found(1, 1) - 9.0), 0.0, 1e-15);
    EXPECT_NEAR(other(0, 1).real(), 6.0, 1e-15);
    ASSERT_EQ(equations.noise_terms().size(), 2u);
    EXPECT_EQ(equations.terms().size(), 2u);
}

TEST(ProductNoise, that_two_fields_share_drives_them_together_in_a_run) {
    // Of the same law: b = -2 a on every path.
    const Equations equations(
        with_noise({scalar("a", "-a + lap a + (1 + 0.2 a) zeta", 0.0), scalar("b", "-b + lap b - 2 (1 + 0.2 a) zeta"),
                    scalar("c", "-a - c + (1 + 0.2 a) xi")},
                   {{.symbol = "zeta"}, {.symbol = "xi"}}));
    const numerics::Grid grid{.nx = 8, .ny = 8, .lx = 6.0, .ly = 6.0};
    Evolution run(equations, {.grid = grid, .dt = 0.5});
    run.advance(40);
    const numerics::Fields fields = run.fields();
    double a = 0.0, b = 0.0, apart = 0.0;
    for (std::size_t i = 0; i < 64; ++i) {
        EXPECT_NEAR(fields[1][i], -2.0 * fields[0][i], 1e-13);
        a += fields[0][i] * fields[0][i], b += fields[2][i] * fields[2][i], apart += fields[0][i] * fields[2][i];
    }
    EXPECT_LT(std::abs(apart), 0.9 * std::sqrt(a * b));  // xi is another noise
}

TEST(ProductNoise, of_a_force_is_divided_by_a_mass_that_varies) {
    Model model = with_noise({scalar("rho", "-div(rho v)", 2.0),
                              {.name = "v", .symbol = "v", .spin = 1, .equation = {"-v + lap v + 3 xi", {}}}},
                             {{.symbol = "xi", .spin = 1}});
    model.fields[1].mass = {"0.5 rho", {}};
    const Equations equations(model);
    const Symbol noise = equations.noise({4.0, 0.0, 0.0}, {1.0, 0.0});
    EXPECT_NEAR(noise(1, 1).real(), std::pow(3.0 / (0.5 * 4.0), 2), 1e-14);
    EXPECT_EQ(noise(0, 0), 0.0);
    model.fields[1].equation.text = "-v + lap v + 0.5 rho xi";  // an acceleration
    EXPECT_FALSE(Equations(model).has_product_noise());
}

TEST(ProductNoise, turns_with_space) {
    // A current along the order, and noise that the order reflects: both turned by 90 degrees, with the fields.
    const auto model = [](const std::string& noise) {
        return with_noise({scalar("c", "lap c + div(c xi)", 1.0),
                           {.name = "p", .symbol = "p", .spin = 1, .equation = {"-p + " + noise, {}}}},
                          {{.symbol = "xi", .spin = 1}, {.symbol = "zeta"}});
    };
    const Equations equations(model("p zeta + c^2 xi"));
    const Symbol along_x = equations.noise({2.0, 0.5, 0.0}, {0.0, 0.7}),
                 along_y = equations.noise({2.0, 0.0, 0.5}, {-0.7, 0.0});
    EXPECT_NEAR(std::abs(along_x(0, 0) - 4.0 * 0.49), 0.0, 1e-14);
    EXPECT_NEAR(along_x(1, 1).real(), 0.25 + 16.0, 1e-14);
    EXPECT_NEAR(std::abs(along_x(0, 2) - along_y(0, 1) * -1.0), 0.0, 1e-14);
    EXPECT_NEAR(std::abs(along_x(1, 1) - along_y(2, 2)), 0.0, 1e-14);
}

TEST(ProductNoise, that_is_not_finite_says_what_to_do) {
    const Equations equations(with_noise({scalar("c", "lap c + sqrt(c) zeta", 0.01)}, {{.symbol = "zeta"}}));
    Evolution run(equations, {.grid = {.nx = 8, .ny = 8, .lx = 8.0, .ly = 8.0}, .dt = 0.5});
    try {
        run.advance(100);
        FAIL() << "expected an Error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("sqrt(max(c, 0))"), std::string::npos) << error.what();
    }
    const Equations clipped(with_noise({scalar("c", "lap c + sqrt(max(c, 0)) zeta", 0.01)}, {{.symbol = "zeta"}}));
    Evolution goes_on(clipped, {.grid = {.nx = 8, .ny = 8, .lx = 8.0, .ly = 8.0}, .dt = 0.5});
    goes_on.advance(100);
}

std::string rejection_of(const std::string& equation, bool conserved = false) {
    Model model = with_noise({scalar("a", "")}, {{.symbol = "zeta"}, {.symbol = "xi", .spin = 1}});
    model.fields[0].equation = {equation, {.file = "model", .line = 1, .column = 1}};
    model.fields[0].conserved = conserved;
    try {
        const Equations equations(model);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(ProductNoise, is_proportional_to_its_noise) {
    for (const char* equation : {"-a + a zeta", "-a + (1 + cos(x)) zeta", "-a + (1 + t) a zeta", "-a + a xi.grad a",
                                 "-a + a (zeta + div xi)", "-a + div(a xi) + zeta"})
        EXPECT_EQ(rejection_of(equation), "") << equation;
    for (const char* equation :
         {"-a + zeta^2", "-a + a sin(zeta)", "-a + xi.xi", "-a + (1 + zeta) a^2", "-a + lap(a^3 + a zeta)",
          "-a + (a + zeta)^2", "-a + a/(1 + zeta)", "-a + a zeta div xi"}) {
        const std::string found = rejection_of(equation);
        EXPECT_EQ(found.rfind("model:1:4: the term \"+ ", 0), 0u) << equation << ": " << found;
        EXPECT_NE(found.find("expected noise as a"), std::string::npos) << equation << ": " << found;
    }
    EXPECT_EQ(rejection_of("0.5 (zeta - a) + lap a"), "");
    EXPECT_NE(rejection_of("0.5 (zeta - a) + a zeta").find("model:1:1: the term \"0.5 (zeta - a)\" mixes noise that "),
              std::string::npos);
    EXPECT_EQ(rejection_of("lap a + div(a xi)", true), "");
    EXPECT_NE(rejection_of("lap a + a zeta", true).find("no divergence"), std::string::npos);
}

}  // namespace
}  // namespace drover::model::product_noise_tests
