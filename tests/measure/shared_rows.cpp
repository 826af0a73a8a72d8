// tests/measure/shared_rows.cpp: names that fields and particles share stand for the same quantity in both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "drover/numerics/transform.hpp"
#include "measure/fields.hpp"
#include "measure/fields_support.hpp"
#include "measure/particles_support.hpp"
#include "model/start.hpp"

namespace drover::measure::shared_rows_tests {
namespace {

const numerics::Grid grid{.nx = 48, .ny = 48, .lx = 48.0, .ly = 48.0};  // the mesh on which bodies are counted

/// Bodies at the centres of the cells of the grid.  Their numbers are waves with periods of 4 and 6 cells, which the
/// modes of the grid represent exactly; directions and velocities depend on the numbers, so that means over bodies
/// differ from means over the area.
struct Snapshot {
    double spread = 0.0;                                                       ///< of the directions
    static int wave_4(int i) { return i % 4 == 0 ? 1 : i % 4 == 2 ? -1 : 0; }  // cos(2 pi i/4)
    // 2 cos(2 pi i/6)
    static int wave_6(int i) { return i % 6 == 0 ? 2 : i % 6 == 3 ? -2 : i % 6 == 1 || i % 6 == 5 ? 1 : -1; }
    int rods(int i, int j) const { return 4 + wave_6(i) + wave_4(j); }
    int beads(int i, int j) const { return 4 + wave_4(i) + wave_6(j); }
    double angle(int i, int j) const { return spread * (rods(i, j) + std::sin(2.0 * pi * j / 48.0)); }
    double velocity_x(int i, int j) const { return 0.5 * beads(i, j) + 0.3 * std::cos(2.0 * pi * i / 48.0); }
    double velocity_y(int i, int j) const { return 0.2 * rods(i, j) - 0.1 * beads(i, j); }
};

ParticleScene particles_of(const Snapshot& snapshot) {
    ParticleScene scene(dem::CellShape::periodic, grid.lx, grid.ly);
    for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
            const double x = i + 0.5, y = j + 0.5;
            for (int k = 0; k < snapshot.rods(i, j); ++k) scene.add_rod(x, y, snapshot.angle(i, j));
            for (int k = 0; k < snapshot.beads(i, j); ++k)
                scene.add_bead(x, y, snapshot.velocity_x(i, j), snapshot.velocity_y(i, j));
        }
    return scene;
}

/// The same bodies as fields; the cells have an area of 1 mm^2.
class FieldScene {
public:
    FieldScene(const Snapshot& snapshot, const physics::Model& model)
        : threads_(1),
          setting_(setting_of(grid, model)),
          form(physics::form(model)),
          fields_(grid, numerics::components(physics::layout(form))),
          velocity_(grid, 2),
          spectra_(grid, fields_.count()),
          velocity_spectra_(grid, 2) {
        std::size_t point = 0;
        for (int j = 0; j < grid.ny; ++j)
            for (int i = 0; i < grid.nx; ++i, ++point) {
                const double weight = form.order_is_density ? snapshot.rods(i, j) : 1.0;
                fields_[form.bead_density][point] = snapshot.beads(i, j);
                fields_[form.rod_density][point] = snapshot.rods(i, j);
                fields_[form.polar_order][point] = weight * std::cos(snapshot.angle(i, j));
                fields_[form.polar_order + 1][point] = weight * std::sin(snapshot.angle(i, j));
                velocity_[0][point] = snapshot.velocity_x(i, j);
                velocity_[1][point] = snapshot.velocity_y(i, j);
                for (int axis = 0; axis < 2 && form.bead_velocity >= 0; ++axis)
                    fields_[form.bead_velocity + axis][point] = velocity_[axis][point];
            }
        const numerics::Transform transform(grid, 1, threads_);
        transform.forward(fields_, spectra_);
        transform.forward(velocity_, velocity_spectra_);
    }
    FieldMoment moment() const {
        return {.setting = setting_,
                .state = spectra_,
                .state_on_grid = fields_,
                .balanced = velocity_spectra_,
                .balanced_on_grid = velocity_};
    }
    const FieldSetting& setting() const { return setting_; }

private:
    Threads threads_;
    FieldSetting setting_;
    physics::Form form;
    numerics::Fields fields_, velocity_;
    numerics::Spectra spectra_, velocity_spectra_;
};

std::vector<physics::Model> models() {
    std::vector<physics::Model> result;
    for (const char* velocity : {"dynamic", "slaved"})
        for (const char* kind : {"order", "density-order"})
            result.push_back(model_of({.bead_density = true, .rod_density = true, .bead_velocity = velocity}, kind));
    return result;
}

const std::vector<Snapshot> snapshots{{.spread = 0.3}, {.spread = 0.9}};

template <class Moment>
std::vector<RecordedSeries> recorded(const Observables<Moment>& rows, const std::vector<Moment>& moments) {
    std::vector<RecordedSeries> series;
    for (const auto& row : rows) {
        std::vector<double> values;
        for (const Moment& moment : moments) {
            const std::vector<double> now = measure_one(row, moment);
            values.insert(values.end(), now.begin(), now.end());
        }
        series.push_back(recorded_series(row, values));
    }
    return series;
}

void expect_near(const std::vector<double>& a, const std::vector<double>& b, const std::string& name) {
    ASSERT_EQ(a.size(), b.size()) << name;
    for (std::size_t k = 0; k < a.size(); ++k) {
        EXPECT_EQ(std::isnan(a[k]), std::isnan(b[k])) << name << " " << k;
        // Rounding of sums over ten thousand bodies, and of differences of squares of numbers in boxes.
        if (std::isnan(a[k])) continue;
        EXPECT_NEAR(a[k], b[k], 1e-10 * (1.0 + std::abs(a[k]))) << name << " " << k;
    }
}

template <class Row>
void expect_one_definition(const Row& of_fields, const Row& of_particles) {
    const std::string& name = of_fields.name;
    EXPECT_EQ(of_fields.unit, of_particles.unit) << name;
    EXPECT_EQ(of_fields.formula, of_particles.formula) << name;
    ASSERT_EQ(names_of(of_fields.axes), names_of(of_particles.axes)) << name;
    for (std::size_t a = 0; a < of_fields.axes.size(); ++a) {
        EXPECT_EQ(of_fields.axes[a].unit, of_particles.axes[a].unit) << name;
        EXPECT_EQ(of_fields.axes[a].meaning, of_particles.axes[a].meaning) << name;
        expect_near(of_fields.axes[a].values, of_particles.axes[a].values, of_fields.axes[a].name);
    }
}

/// Both recordings of the same snapshots.
std::pair<Recorded, Recorded> recordings(const physics::Model& model) {
    std::vector<ParticleMoment> particle_moments;
    std::vector<std::unique_ptr<FieldScene>> fields;
    std::vector<FieldMoment> field_moments;
    const ParticleSetting setting = particles_of(snapshots.front()).setting();
    for (const Snapshot& snapshot : snapshots) {
        particle_moments.push_back(particles_of(snapshot).moment(setting));
        fields.push_back(std::make_unique<FieldScene>(snapshot, model));
        field_moments.push_back(fields.back()->moment());
    }
    const FieldSetting& field_setting = fields.front()->setting();
    return {field_recording(field_setting, recorded(field_observables(field_setting), field_moments)),
            particle_recording(setting, recorded(particle_observables(setting), particle_moments))};
}

TEST(SharedRows, of_fields_and_particles_agree_on_the_same_snapshots) {
    for (const physics::Model& model : models()) {
        const auto [fields, particles] = recordings(model);
        std::set<std::string> shared;
        for (const RecordedSeries& of_fields : fields.series) {
            const RecordedSeries* of_particles = find_row(particles.series, of_fields.name);
            if (of_particles == nullptr) continue;
            shared.insert(of_fields.name);
            expect_one_definition(of_fields, *of_particles);
            expect_near(of_fields.values, of_particles->values, of_fields.name);
        }
        EXPECT_THAT(shared, testing::ElementsAre("bead_number_variance", "bead_speed", "bead_velocity_mean_x",
                                                 "bead_velocity_mean_y", "bead_velocity_order", "flow_alignment",
                                                 "polar_order", "rod_number_variance"));
    }
}

TEST(SharedRows, of_both_summaries_agree_on_the_same_snapshots) {
    auto [fields, particles] = recordings(models().front());
    fields.warm_up = particles.warm_up = 0;
    const Summary of_fields = summarise(fields), of_particles = summarise(particles);
    std::set<std::string> shared;
    for (const SummaryRow& row : of_fields.rows) {
        const SummaryRow* other = find_row(of_particles.rows, row.name);
        if (other == nullptr) continue;
        shared.insert(row.name);
        expect_one_definition(row, *other);
        std::vector<double> a, b;
        for (const Estimate& estimate : row.estimates) a.push_back(estimate.mean);
        for (const Estimate& estimate : other->estimates) b.push_back(estimate.mean);
        if (row.name.ends_with("_exponent")) {  // undefined where numbers do not fluctuate: boxes of whole periods
            const auto& deviation =
                find_row(of_particles.rows, row.name.substr(0, row.name.find('_')) + "_number_deviation")->estimates;
            for (std::size_t k = 0; k + 1 < a.size(); ++k)
                if (deviation[k].mean < 1e-6 || deviation[k + 1].mean < 1e-6) a[k] = b[k] = 0.0;
            EXPECT_NE(a[0], 0.0);
        }
        expect_near(a, b, row.name);
    }
    EXPECT_THAT(shared, testing::IsSupersetOf({"polar_order_susceptibility", "polar_order_binder", "rod_number",
                                               "rod_number_deviation", "rod_number_exponent", "bead_number",
                                               "bead_number_deviation", "bead_number_exponent"}));
}

TEST(SharedRows, are_means_over_bodies_and_not_over_the_area) {
    const Snapshot snapshot = snapshots.back();
    double over_area = 0.0, square = 0.0, order_x = 0.0, order_y = 0.0;
    for (int j = 0; j < 48; ++j)
        for (int i = 0; i < 48; ++i) {
            const double x = snapshot.velocity_x(i, j), y = snapshot.velocity_y(i, j);
            over_area += x / 2304.0;
            square += snapshot.beads(i, j) * (x * x + y * y) / (4.0 * 2304.0);
            order_x += snapshot.rods(i, j) * std::cos(snapshot.angle(i, j)) / (4.0 * 2304.0);
            order_y += snapshot.rods(i, j) * std::sin(snapshot.angle(i, j)) / (4.0 * 2304.0);
        }
    for (const physics::Model& model : models()) {
        const FieldScene scene(snapshot, model);
        const auto value = [&](const char* name) {
            return measure_one(*find_row(field_observables(scene.setting()), name), scene.moment()).front();
        };
        EXPECT_NEAR(value("bead_speed"), std::sqrt(square), 1e-12);
        EXPECT_NEAR(value("polar_order"), std::hypot(order_x, order_y), 1e-12);
        EXPECT_GT(value("bead_velocity_mean_x"), over_area + 0.05);  // more beads where they are faster
    }
}

TEST(FlowAlignment, is_the_cosine_between_flow_and_order_and_nan_without_either) {
    ParticleScene particles = particles_of({.spread = 0.0});
    for (dem::Bead& bead : particles.bodies.beads) bead.velocity = {-3.0, 4.0, 0.0};
    EXPECT_NEAR(particles("flow_alignment"), -0.6, 1e-12);  // all rods along x; rounding
    for (dem::Bead& bead : particles.bodies.beads) bead.velocity = {};
    EXPECT_TRUE(std::isnan(particles("flow_alignment")));
    for (const physics::Model& model : models()) {
        const FieldSetting setting = setting_of(grid, model);
        const physics::Form form = physics::form(model);
        numerics::Fields fields(grid, numerics::components(physics::layout(form))), velocity(grid, 2);
        numerics::Spectra spectra(grid, fields.count()), velocity_spectra(grid, 2);
        Threads threads(1);
        const numerics::Transform transform(grid, 1, threads);
        const auto alignment = [&](double vx, double vy, double px) {
            const auto fill = [](std::span<double> values, double value) {
                std::fill(values.begin(), values.end(), value);
            };
            for (const int density : {form.bead_density, form.rod_density}) fill(fields[density], 2.0);
            for (const auto& [axis, v] : {std::pair{0, vx}, {1, vy}}) {
                fill(velocity[axis], v);
                if (form.bead_velocity >= 0) fill(fields[form.bead_velocity + axis], v);
            }
            fill(fields[form.polar_order], px);
            transform.forward(fields, spectra);
            transform.forward(velocity, velocity_spectra);
            const auto rows = field_observables(setting);
            const FieldMoment moment{.setting = setting,
                                     .state = spectra,
                                     .state_on_grid = fields,
                                     .balanced = velocity_spectra,
                                     .balanced_on_grid = velocity};
            return measure_one(*find_row(rows, "flow_alignment"), moment).front();
        };
        EXPECT_NEAR(alignment(-3.0, 4.0, 0.5), -0.6, 1e-12);
        EXPECT_TRUE(std::isnan(alignment(0.0, 0.0, 0.5)));
        EXPECT_TRUE(std::isnan(alignment(1.0, 0.0, 0.0)));
    }
}

TEST(FlowAlignment, that_is_undefined_in_a_sample_has_no_mean_and_the_summary_reports_it) {
    RecordedSeries series{.name = "flow_alignment", .values = std::vector<double>(100, 0.5)};
    series.values[3] = std::nan("");
    const SummaryRow row = summarise({.series = {series}, .warm_up = 0}).rows.front();
    EXPECT_TRUE(std::isnan(row.estimates.front().mean));
    EXPECT_THAT(row.estimates.front().why_no_error, testing::HasSubstr("not finite in 1 of 100 samples"));
    EXPECT_EQ(summarise({.series = {series}, .warm_up = 4}).rows.front().estimates.front().mean, 0.5);
}

TEST(SharedRows, leave_no_name_of_a_field_to_an_observable) {
    const auto observables = particle_observables(particles_of(snapshots.front()).setting());
    for (const physics::Model& model : models())
        for (const model::StateComponent& component : model::components_of_state(physics::Equations(model).solver())) {
            EXPECT_EQ(find_row(observables, component.name), nullptr) << component.name;
            EXPECT_EQ(find_row(field_observables(setting_of(grid, model)), component.name), nullptr);
        }
}

}  // namespace
}  // namespace drover::measure::shared_rows_tests
