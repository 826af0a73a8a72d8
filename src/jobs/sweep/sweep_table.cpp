// jobs/sweep/sweep_table.cpp: means over seeds, and where they contradict the errors of the runs; the table as CSV;
// arrays of a sweep from the results of its runs.
#include "jobs/sweep/sweep_plan.hpp"

#include <algorithm>
#include <numeric>
#include <ranges>
#include <set>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "files/archive.hpp"
#include "io/calibration.hpp"
#include "measure/replicates.hpp"
#include "measure/trajectories.hpp"
#include "run/loop/provenance.hpp"

namespace drover::jobs {

namespace {
/// The mean over the seeds of a point.
measure::Replicates over_seeds(const std::vector<measure::Estimate>& runs) {
    if (!runs.empty()) return measure::combine(runs);
    return {.mean = {.mean = nan, .why_no_error = "no run of this point has this observable"},
            .deviation = nan,
            .chi_squared = nan,
            .chance = nan};
}

/// The relaxation time of a point is the inverse of its mean rotational diffusion: the inverse of a single short run is
/// too noisy.
void invert_diffusion(const std::vector<std::string>& names, std::vector<measure::Replicates>& results) {
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    const std::size_t from = column("rotational_diffusion"), to = column("relaxation_time");
    if (from >= results.size() || to >= results.size()) return;
    results[to].mean = measure::relaxation_time_of(results[from].mean);
}

/// Warns of errors that the scatter of the seeds does not show, or that contradict it.
void add_warnings(const SweepRow& row, bool finds_warm_up, SweepTable& table) {
    std::vector<std::string> wide, narrow, unknown;
    for (std::size_t column = 0; column < row.results.size(); ++column) {
        const measure::Replicates& result = row.results[column];
        const std::string& name = table.names[column];
        if (measure::contradicts(result)) (result.chi_squared > 1.0 ? wide : narrow).push_back(name);
        // Components of a direction wander, and have no start to forget.
        const bool wanders =
            result.mean.averaging == measure::Averaging::direction || name.ends_with("_x") || name.ends_with("_y");
        if (finds_warm_up && row.seeds > 1 && result.mean.error && result.without_error > 0 && !wanders)
            unknown.push_back(name);
    }
    std::string at;
    for (std::size_t k = 0; k < row.point.values.size(); ++k)
        at += text("{}{} = {:.6g}", k == 0 ? "at " : ", ", table.keys[k], row.point.values[k]);
    if (!at.empty()) at += ": ";
    if (!wide.empty())
        table.warnings.push_back(
            text("{}the seeds differ by far more than their errors in {}; the runs are shorter than their slowest "
                 "change, or end in different states: give longer runs; the error in the table is that of the scatter",
                 at, joined(wide)));
    if (constexpr std::size_t max_names = 4; !unknown.empty()) {
        const std::size_t shown = std::min(unknown.size(), max_names), more = unknown.size() - shown;
        unknown.resize(shown);
        table.warnings.push_back(
            text("{}some runs are too short for an error estimate in {}{}; the error in the table is that of "
                 "the scatter, which does not show what the runs have in common, such as their start: give longer "
                 "runs, or set analysis.warm_up",
                 at, joined(unknown), more == 0 ? "" : text(" and {} more", more)));
    }
    if (!narrow.empty())
        table.warnings.push_back(
            text("{}the seeds differ by far less than their errors in {}; the error in the "
                 "table is that of the scatter",
                 at, joined(narrow)));
}

constexpr const char *branch_axis = "branch", *seed_axis = "seed", *point_axis = "point";

std::size_t length_of(const std::vector<std::size_t>& shape) {
    return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

/// Copies means and errors of an array of estimates into the front of one that is at least as long along each axis.
template <class Get>
void place(const std::vector<std::size_t>& from, const std::vector<std::size_t>& to, std::size_t begin, Get get,
           std::vector<double>& means, std::vector<double>& errors) {
    for (std::size_t i = 0; i < length_of(from); ++i) {
        std::size_t rest = i, at = 0, stride = 1;
        for (std::size_t a = from.size(); a-- > 0; stride *= to[a]) {
            at += rest % from[a] * stride;
            rest /= from[a];
        }
        const measure::Estimate& estimate = get(i);
        means[begin + at] = estimate.mean;
        errors[begin + at] = estimate.error.value_or(nan);
    }
}

std::vector<std::size_t> shape_of_row(const measure::SummaryRow& row) {
    return mapped(row.axes, [](const measure::Axis& axis) { return axis.values.size(); });
}

/// One result in all runs.
struct Column {
    std::string name, unit, formula;
    std::vector<std::string> axes;
    std::vector<std::size_t> shape;                ///< the largest of all runs
    std::vector<const measure::SummaryRow*> rows;  ///< by seed and point; nullptr: none
};

/// An axis of results.
struct OwnAxis {
    files::Axis axis;
    bool differs = false;                            ///< between runs
    std::vector<const std::vector<double>*> values;  ///< by point
};

class Dataset {
public:
    Dataset(const io::Scene& scene, const SweepLayout& layout, const std::map<std::string, RunResults>& results,
            const SweepTable& means)
        : layout_(layout), means_(means), seeds_(static_cast<std::size_t>(layout.seeds)), first_seed_(scene.run.seed) {
        add_key_axes(scene);
        for (std::size_t r = 0; r < layout.runs.size(); ++r)
            if (const auto found = results.find(layout.runs[r].name); found != results.end())
                for (const measure::SummaryRow& row : found->second.rows) take(row, r);
    }

    files::ResultTable table() {
        for (const auto& [name, own] : own_axes_) add_axis(name, own);
        if (seeds_ > 1) {
            files::Axis seeds{seed_axis, "1", "run.seed, as in the names of the runs", {}};
            for (std::size_t s = 0; s < seeds_; ++s)
                seeds.values.push_back(static_cast<double>(first_seed_) + static_cast<double>(s));
            table_.axes.push_back(std::move(seeds));
        }
        std::vector<double> ended(length_of(point_shape_), 0.0);
        for (std::size_t p = 0; p < places_.size(); ++p) ended[places_[p]] = means_.rows[p].seeds;
        put("seeds", "1", "runs that have ended", key_axes_, std::move(ended));
        for (const Column& column : columns_) add(column);
        return std::move(table_);
    }

private:
    /// Whether two points have the same values, as where a ramp comes back to one.
    bool has_repeated_points() const {
        std::set<std::pair<std::vector<double>, Branch>> points;
        for (const SweepPoint& point : layout_.points) points.emplace(point.values, point.branch);
        return points.size() < layout_.points.size();
    }

    /// An axis for each key, along which each point has a place, or the points in their order and the keys as results.
    void add_key_axes(const io::Scene& scene) {
        const auto unit_of = [&](const std::string& key) {
            return io::unit_in_results(scene, io::unit_of(scene.kind, key));
        };
        const auto value_of = [](std::size_t k) { return [k](const SweepPoint& point) { return point.values[k]; }; };
        places_.resize(layout_.points.size(), 0);
        if (has_repeated_points() || !scene.sweep.refine.empty()) {
            std::iota(places_.begin(), places_.end(), std::size_t{0});
            const std::vector<double> numbers(places_.begin(), places_.end());
            table_.axes.push_back({point_axis, "1", "of the sweep, from 0, in its order", numbers});
            key_axes_ = {point_axis};
            point_shape_ = {numbers.size()};
            for (std::size_t k = 0; const std::string& key : layout_.keys)
                put(io::axis_of(key), unit_of(key), key, key_axes_, mapped(layout_.points, value_of(k++)));
            return;
        }
        const auto add_axis_of = [&](const std::string& name, const std::string& unit, const std::string& meaning,
                                     const std::vector<double>& of_points) {
            std::vector<double> values = of_points;
            std::ranges::sort(values);
            values.erase(std::unique(values.begin(), values.end()), values.end());
            for (std::size_t p = 0; p < places_.size(); ++p)
                places_[p] = places_[p] * values.size() +
                             static_cast<std::size_t>(std::ranges::lower_bound(values, of_points[p]) - values.begin());
            table_.axes.push_back({name, unit, meaning, values});
            key_axes_.push_back(name);
            point_shape_.push_back(values.size());
        };
        for (std::size_t k = 0; const std::string& key : layout_.keys)
            add_axis_of(io::axis_of(key), unit_of(key), key, mapped(layout_.points, value_of(k++)));
        if (std::ranges::any_of(layout_.points, [](const SweepPoint& point) { return point.branch != Branch::none; }))
            add_axis_of(branch_axis, "1", "of the ramp: 0 up, 1 down",
                        mapped(layout_.points,
                               [](const SweepPoint& one) { return one.branch == Branch::down ? 1.0 : 0.0; }));
    }

    void take(const measure::SummaryRow& row, std::size_t run) {
        auto column = std::ranges::find_if(columns_, [&](const Column& one) {
            return one.name == row.name && one.axes.size() == row.axes.size();
        });
        if (column == columns_.end()) {
            columns_.push_back({.name = row.name, .unit = row.unit, .formula = row.formula, .axes = {}});
            column = columns_.end() - 1;
            column->axes = measure::names_of(row.axes);
            column->shape.assign(row.axes.size(), 0);
            column->rows.assign(seeds_ * layout_.points.size(), nullptr);
        }
        const SweepRun& one = layout_.runs[run];
        column->rows[static_cast<std::size_t>(one.seed) * layout_.points.size() + one.point] = &row;
        for (std::size_t a = 0; a < row.axes.size(); ++a) {
            const measure::Axis& axis = row.axes[a];
            column->shape[a] = std::max(column->shape[a], axis.values.size());
            OwnAxis& own = own_axes_[axis.name];
            if (own.values.empty()) {
                own.axis = {axis.name, axis.unit, axis.meaning, axis.values};
                own.values.assign(layout_.points.size(), nullptr);
            }
            own.values[one.point] = &axis.values;
            own.differs = own.differs || own.axis.values != axis.values;
        }
    }

    void add_axis(const std::string& name, const OwnAxis& own) {
        files::Axis axis = own.axis;
        if (own.differs) {
            std::size_t longest = 0;
            for (const std::vector<double>* values : own.values)
                if (values != nullptr) longest = std::max(longest, values->size());
            axis = {name, "1", text("counts from 0; the values at each point are {}_values", name),
                    std::vector<double>(longest)};
            std::iota(axis.values.begin(), axis.values.end(), 0.0);
            std::vector<double> all(length_of(point_shape_) * longest, nan);
            for (std::size_t p = 0; p < own.values.size(); ++p)
                if (own.values[p] != nullptr)
                    std::ranges::copy(*own.values[p], all.begin() + static_cast<std::ptrdiff_t>(places_[p] * longest));
            std::vector<std::string> axes = key_axes_;
            axes.push_back(name);
            put(name + "_values", own.axis.unit, own.axis.meaning, axes, std::move(all));
        }
        table_.axes.push_back(std::move(axis));
        lengths_[name] = table_.axes.back().values.size();
    }

    void put(const std::string& name, const std::string& unit, const std::string& meaning,
             const std::vector<std::string>& axes, std::vector<double> values) {
        table_.quantities.push_back({name, unit, meaning, axes});
        table_.values.push_back(std::move(values));
    }

    void add(const Column& column) {
        const auto own = mapped(column.axes, [&](const std::string& axis) { return lengths_.at(axis); });
        const std::size_t size = length_of(own), points = length_of(point_shape_);
        std::vector<double> means(points * size, nan), errors = means, runs(points * seeds_ * size, nan),
                                                       run_errors = runs;
        for (std::size_t p = 0; p < layout_.points.size(); ++p) {
            std::vector<const measure::SummaryRow*> rows;  // of the seeds
            for (std::size_t s = 0; s < seeds_; ++s) {
                const measure::SummaryRow* row = column.rows[s * layout_.points.size() + p];
                if (row == nullptr) continue;
                if (rows.empty() || rows.front()->estimates.size() == row->estimates.size()) rows.push_back(row);
                const auto estimate = [&](std::size_t i) -> const measure::Estimate& { return row->estimates[i]; };
                place(shape_of_row(*row), own, (places_[p] * seeds_ + s) * size, estimate, runs, run_errors);
            }
            if (rows.empty()) continue;
            const std::vector<measure::Replicates> over_seeds = means_over(rows, p);
            const auto mean = [&](std::size_t i) -> const measure::Estimate& { return over_seeds[i].mean; };
            place(shape_of_row(*rows.front()), own, places_[p] * size, mean, means, errors);
        }
        std::vector<std::string> axes = key_axes_;
        axes.insert(axes.end(), column.axes.begin(), column.axes.end());
        const std::string error = "standard error of " + column.name;
        put(column.name, column.unit, column.formula, axes, std::move(means));
        put(column.name + "_error", column.unit, error, axes, std::move(errors));
        if (seeds_ < 2) return;
        axes.insert(axes.begin() + static_cast<std::ptrdiff_t>(key_axes_.size()), seed_axis);
        put(column.name + "_of_runs", column.unit, column.formula + ", of each run", axes, std::move(runs));
        put(column.name + "_of_runs_error", column.unit, error + " of each run", axes, std::move(run_errors));
    }

    /// Of each number of a result at a point.
    std::vector<measure::Replicates> means_over(const std::vector<const measure::SummaryRow*>& rows,
                                                std::size_t point) const {
        if (rows.front()->axes.empty()) {
            const auto column = std::ranges::find(means_.names, rows.front()->name);
            return {means_.rows[point].results[static_cast<std::size_t>(column - means_.names.begin())]};
        }
        return mapped(std::views::iota(std::size_t{0}, rows.front()->estimates.size()), [&](std::size_t i) {
            return measure::combine(mapped(rows, [i](const auto* row) { return row->estimates[i]; }));
        });
    }

    const SweepLayout& layout_;
    const SweepTable& means_;
    std::size_t seeds_;
    std::int64_t first_seed_;
    files::ResultTable table_{.group = "/", .axes = {}, .quantities = {}, .values = {}};
    std::vector<std::string> key_axes_;
    std::vector<std::size_t> point_shape_, places_;
    std::vector<Column> columns_;
    std::map<std::string, OwnAxis> own_axes_;
    std::map<std::string, std::size_t> lengths_;
};
}  // namespace

SweepTable sweep_table(const SweepLayout& layout, const std::map<std::string, RunResults>& results) {
    SweepTable table{.keys = layout.keys, .names = {}, .units = {}, .rows = {}};
    std::vector<std::vector<std::vector<measure::Estimate>>> found(layout.points.size());  // [point][observable][seed]
    std::vector<int> seeds(layout.points.size(), 0);
    for (const SweepRun& run : layout.runs) {
        const auto ended = results.find(run.name);
        if (ended == results.end()) continue;
        ++seeds[run.point];
        for (const std::string& warning : ended->second.warnings) table.warnings.push_back(run.name + ": " + warning);
        for (const measure::SummaryRow& row : ended->second.rows) {
            if (!row.axes.empty()) continue;
            // By name: runs may differ in their observables, such as those of beads.
            const auto named = std::ranges::find(table.names, row.name);
            const auto column = static_cast<std::size_t>(named - table.names.begin());
            if (named == table.names.end()) {
                table.names.push_back(row.name);
                table.units.push_back(row.unit);
            }
            if (found[run.point].size() <= column) found[run.point].resize(column + 1);
            found[run.point][column].push_back(row.estimates.front());
        }
    }
    for (std::size_t point = 0; point < layout.points.size(); ++point) {
        SweepRow row{.point = layout.points[point], .seeds = seeds[point], .results = {}};
        if (row.seeds > 0) found[point].resize(table.names.size());
        for (const auto& runs : found[point]) row.results.push_back(over_seeds(runs));
        add_warnings(row, layout.finds_warm_up, table);
        invert_diffusion(table.names, row.results);
        table.rows.push_back(std::move(row));
    }
    return table;
}

std::string table_csv(const SweepTable& table) {
    std::string out;
    for (const std::string& key : table.keys) out += key + ",";
    out += "branch,seeds";
    for (std::size_t i = 0; i < table.names.size(); ++i)
        out += text(",{0} [{1}],{0} error,{0} own error", table.names[i], table.units[i]);
    out += '\n';
    for (const SweepRow& row : table.rows) {
        for (const double value : row.point.values) out += text("{},", value);
        out += text("{},{}", row.point.branch, row.seeds);
        const auto number = [](const std::optional<double>& value) { return value ? text("{}", *value) : ""; };
        for (const measure::Replicates& result : row.results)
            out += text(",{},{},{}", result.mean.mean, number(result.mean.error), number(result.own_error));
        if (row.results.empty()) out.append(3 * table.names.size(), ',');  // no run of the point has ended
        out += '\n';
    }
    return out;
}

void write_sweep_dataset(const std::filesystem::path& file, const io::Scene& scene, const SweepLayout& layout,
                         const std::map<std::string, RunResults>& results, const SweepTable& means) {
    io::Scene shared = scene;
    shared.sweep.workers = 0;
    files::ResultTable table = Dataset(scene, layout, results, means).table();
    constexpr std::size_t max_warnings = 1000;  // an attribute holds at most 64 kB
    const std::size_t kept = std::min(means.warnings.size(), max_warnings);
    table.warnings.assign(means.warnings.begin(), means.warnings.begin() + static_cast<std::ptrdiff_t>(kept));
    if (kept < means.warnings.size())
        table.warnings.push_back(
            text("{} more: drover sweep --collect --json prints them", means.warnings.size() - kept));
    files::write_archive(file, {}, run::shared_provenance(shared, "sweep"),
                         [&](files::Archive& archive) { archive.replace(table); });
}

}  // namespace drover::jobs
