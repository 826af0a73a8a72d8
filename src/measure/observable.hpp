// measure/observable.hpp: an observable of fields or of particles as one row, and its axes.
#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::measure {

/// Functions of a moment, of which one is that of an observable.
template <class Moment>
using NumberOf = std::type_identity_t<std::function<double(const Moment&)>>;
template <class Moment>
using ArrayOf = std::type_identity_t<std::function<std::vector<double>(const Moment&)>>;

/// A quantity measured at one moment of a run.  Moment is FieldMoment or ParticleMoment.
template <class Moment>
struct Observable {
    std::string name;
    std::string unit;         ///< UDUNITS text
    std::vector<Axis> axes;   ///< slowest first; none: a single number
    std::string formula;      ///< for people
    ArrayOf<Moment> measure;  ///< size_of(axes) values
    Averaging averaging = Averaging::mean;
    Nature nature = Nature::number;
    bool is_of_grid = false;  ///< tells whether the grid resolves the fields: no mean of the model
};

template <class Moment>
using Observables = std::vector<Observable<Moment>>;

/// Adds, and returns, the row of an observable that is one number.
template <class Moment>
Observable<Moment>& add(Observables<Moment>& rows, std::string name, std::string unit, std::string formula,
                        NumberOf<Moment> function, Averaging averaging = Averaging::mean) {
    const auto measure = [function = std::move(function)](const Moment& moment) {
        return std::vector{function(moment)};
    };
    rows.push_back({std::move(name), std::move(unit), {}, std::move(formula), measure, averaging});
    return rows.back();
}

/// Adds, and returns, the row of an observable that is an array.
template <class Moment>
Observable<Moment>& add(Observables<Moment>& rows, std::string name, std::string unit, std::vector<Axis> axes,
                        std::string formula, ArrayOf<Moment> function) {
    rows.push_back({std::move(name), std::move(unit), std::move(axes), std::move(formula), std::move(function)});
    return rows.back();
}

/// All axes of the rows, each once.  Rows are observables, recorded series or summary rows.
template <class Rows>
std::vector<Axis> axes_of(const Rows& rows) {
    std::vector<Axis> axes;
    for (const auto& row : rows)
        for (const Axis& axis : row.axes)
            if (std::ranges::none_of(axes, [&](const Axis& one) { return one.name == axis.name; }))
                axes.push_back(axis);
    return axes;
}

/// The values of one observable.  Throws an input Error when the function and the axes disagree on their number.
template <class Moment>
std::vector<double> measure_one(const Observable<Moment>& row, const Moment& moment) {
    std::vector<double> values = row.measure(moment);
    require(values.size() == size_of(row.axes), {}, "{}: {} values measured; expected {}", row.name, values.size(),
            size_of(row.axes));
    return values;
}

}  // namespace drover::measure
