// measure/field_axes.hpp: the axes of the observables of fields.
#pragma once
#include "drover/measure/field_setting.hpp"
#include "drover/measure/observable.hpp"

namespace drover::measure {

Axis shell_axis(const FieldSetting& setting);
Axis sector_axis(const FieldSetting& setting);
Axis separation_axis(const FieldSetting& setting);
Axis term_axis(const FieldSetting& setting);
Axis family_axis(const BoxFamily& family, const FieldSetting& setting);

}  // namespace drover::measure
