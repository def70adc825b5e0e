// SPDX-License-Identifier: BSD-3-Clause
#include "xview/options.h"

#include <string_view>
#include <type_traits>

namespace xview {
namespace {

bool endsWith(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && name.substr(name.size() - ending.size()) == ending;
}

/// Gathers the options that are lengths, which their names tell, and those that are per length.
class LengthCollector {
 public:
  struct Lengths {
    std::vector<double*> metres, per_metre;
  };
  explicit LengthCollector(Lengths& found) : found_(found) {}

  template <class Value, class Rule>
  void operator()(const char* name, Value& value, const Rule&, const char*) {
    if constexpr (std::is_same_v<Value, double>) {
      if (endsWith(name, "_per_m"))
        found_.per_metre.push_back(&value);
      else if (endsWith(name, "_m"))
        found_.metres.push_back(&value);
    }
  }
  template <class Value>
  void operator()(const char*, Value&, const char*) {}
  template <class Group>
  void group(const char*, Group& options) {
    visit(options, *this);
  }

 private:
  Lengths& found_;
};

LengthCollector::Lengths lengthsOf(Options& options) {
  LengthCollector::Lengths lengths;
  visit(options, LengthCollector(lengths));
  return lengths;
}

/// Multiplies lengths that are, or are not, as long as by default.
void scale(double factor, bool defaults, Options& options) {
  Options untouched;
  const LengthCollector::Lengths mine = lengthsOf(options), theirs = lengthsOf(untouched);
  for (std::size_t i = 0; i < mine.metres.size(); ++i) {
    if ((*mine.metres[i] == *theirs.metres[i]) == defaults) *mine.metres[i] *= factor;
  }
  for (std::size_t i = 0; i < mine.per_metre.size(); ++i) {
    if ((*mine.per_metre[i] == *theirs.per_metre[i]) == defaults) *mine.per_metre[i] /= factor;
  }
}

}  // namespace

Options atSize(Options options, double size) {
  options.size = sizeText(size);
  if (size != kTown) scale(size, true, options);
  return options;
}

Options inTownLengths(Options options, double size) {
  options.size = sizeText(kTown);
  if (size == kTown) return options;
  scale(1 / size, false, options);
  if (!options.prior.near.empty()) {
    const PlacePrior::Circle c = parseCircle("prior.near", options.prior.near);
    options.prior.near =
        numberText(c.x / size) + "," + numberText(c.y / size) + "," + numberText(c.radius / size);
  }
  return options;
}

}  // namespace xview
