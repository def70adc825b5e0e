// SPDX-License-Identifier: BSD-3-Clause
#include "xview/options.h"

#include <string_view>

#include "base/option_field.h"
#include "base/option_visits.h"

namespace xview {
namespace {

bool endsWith(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && name.substr(name.size() - ending.size()) == ending;
}

/// Multiplies lengths, which their names tell, that are, or are not, as long as by default.
void scale(double factor, bool defaults, Options& options) {
  Options untouched;
  const std::vector<OptionField> mine = fieldsOf(options), theirs = fieldsOf(untouched);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    double* const* value = std::get_if<double*>(&mine[i].value);
    if (!value || (**value == *std::get<double*>(theirs[i].value)) != defaults) continue;
    if (endsWith(mine[i].key, "_per_m"))
      **value /= factor;
    else if (endsWith(mine[i].key, "_m"))
      **value *= factor;
  }
}

}  // namespace

Options atSize(Options options, double size) {
  options.size = sizeText(size);
  if (size != kTownScale) scale(size, true, options);
  return options;
}

Options inCanonicalLengths(Options options, double size) {
  options.size = sizeText(kTownScale);
  if (size == kTownScale) return options;
  scale(1 / size, false, options);
  if (!options.prior.near.empty()) {
    const PlacePrior::Circle c = parseCircle("prior.near", options.prior.near);
    options.prior.near =
        numberText(c.x / size) + "," + numberText(c.y / size) + "," + numberText(c.radius / size);
  }
  return options;
}

}  // namespace xview
