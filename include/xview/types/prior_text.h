// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "xview/types/place.h"

namespace xview {

/// Priors as users write them. `name` is what they wrote it behind, a flag or a key: a UsageError
/// names it.
PlacePrior::Circle parseCircle(const std::string& name, const std::string& text);  ///< x,y,radius
PlacePrior::Heading parseHeading(const std::string& name,
                                 const std::string& text);  ///< heading,tolerance [deg]

/// `LOW,HIGH`, or `free` for 0.75,1.34; nothing if the text is empty: the scale is right.
std::optional<ScaleRange> parseScale(const std::string& name, const std::string& text);

/// The same as rules of options: they throw what the parsers throw.
void requireCircle(const std::string& name, const std::string& text);
void requireHeading(const std::string& name, const std::string& text);
void requireScale(const std::string& name, const std::string& text);

}  // namespace xview
