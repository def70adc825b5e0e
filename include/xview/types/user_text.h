// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "xview/types/localization.h"

namespace xview {

/// The word with the smallest edit distance, for "did you mean"; the first one if several are
/// equally near, empty if none differs in about a quarter of its letters or less: what is farther
/// was hardly meant.
std::string nearestWord(const std::string& word, const std::vector<std::string>& words);

/// The end of a message about an unknown word: "; the nearest known one is X", else the known ones
/// if they are few, else nothing.
std::string knownWordsHint(const std::string& word, const std::vector<std::string>& words);

/// The fewest digits that read back as the same number.
std::string numberText(double value);

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
