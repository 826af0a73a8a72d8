// measure/field_axes.hpp: the axes and names of the observables of fields.
#pragma once
#include "measure/field_setting.hpp"
#include "measure/observable.hpp"

namespace drover::measure {

Axis shell_axis(const FieldSetting& setting);
Axis sector_axis(const FieldSetting& setting);
Axis separation_axis(const FieldSetting& setting);
Axis term_axis(const FieldSetting& setting);
Axis family_axis(const BoxFamily& family, const FieldSetting& setting);

/// "mean_phi", of a part "mean_p_x", or with the name of the field first.
std::string statistic_name(const MeasuredField& field, const std::string& statistic, std::size_t part);
std::string statistic_name(const MeasuredField& field, const std::string& statistic);
/// Of the number of bodies in the cell.
std::string total_name(const MeasuredField& field);

}  // namespace drover::measure
