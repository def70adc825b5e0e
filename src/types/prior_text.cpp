// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/prior_text.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "xview/types/error.h"

namespace xview {
namespace {

double parseNumber(const std::string& text) {
  std::size_t used = 0;
  const double number = std::stod(text, &used);
  if (used != text.size() || !std::isfinite(number)) throw std::invalid_argument(text);
  return number;
}

std::vector<double> parseNumbers(const std::string& name, const std::string& text,
                                 std::size_t count, const char* meaning) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) {
    try {
      numbers.push_back(parseNumber(part));
    } catch (const std::logic_error&) {  // what std::stod throws, too
      throw UsageError(name + " = " + text + ", '" + part + "' is not a number");
    }
  }
  if (numbers.size() != count) throw UsageError(name + " = " + text + ", must be " + meaning);
  return numbers;
}

}  // namespace

PlacePrior::Circle parseCircle(const std::string& name, const std::string& text) {
  const auto n = parseNumbers(name, text, 3, "x,y,radius");
  if (!(n[2] > 0)) throw UsageError(name + " = " + text + ", the radius must be positive");
  return {n[0], n[1], n[2]};
}

PlacePrior::Heading parseHeading(const std::string& name, const std::string& text) {
  const auto n = parseNumbers(name, text, 2, "heading,tolerance");
  if (!(n[1] > 0)) throw UsageError(name + " = " + text + ", the tolerance must be positive");
  return {n[0] * M_PI / 180, n[1] * M_PI / 180};
}

std::optional<ScaleRange> parseScale(const std::string& name, const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text == "free") return ScaleRange{0.75, 1.34};
  const auto n = parseNumbers(name, text, 2, "LOW,HIGH or free");
  if (!(n[0] > 0.1 && n[0] <= n[1] && n[1] < 10))
    throw UsageError(name + " = " + text + ", must be 0.1 < LOW <= HIGH < 10");
  return ScaleRange{n[0], n[1]};
}

void requireCircle(const std::string& name, const std::string& text) { parseCircle(name, text); }

void requireHeading(const std::string& name, const std::string& text) { parseHeading(name, text); }

void requireScale(const std::string& name, const std::string& text) { parseScale(name, text); }

}  // namespace xview
