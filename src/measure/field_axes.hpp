// measure/field_axes.hpp: the axes of the observables of fields, and their correlations.
#pragma once
#include "drover/measure/field_setting.hpp"
#include "drover/measure/observable.hpp"

namespace drover::measure {

Axis shell_axis(const FieldSetting& setting);
Axis sector_axis(const FieldSetting& setting);
Axis separation_axis(const FieldSetting& setting);
Axis term_axis(const FieldSetting& setting);
Axis family_axis(const BoxFamily& family, const FieldSetting& setting);

/// <a(r0) a(r0 + r)> by the distance r, from |a_q|^2 of each stored mode: averaged over r0 and the directions of r.
std::vector<double> radial_correlation(const FieldSetting& setting, const std::vector<double>& powers);

}  // namespace drover::measure
