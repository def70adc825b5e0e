// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "xview/types/frame.h"
#include "xview/types/semantic_place.h"

namespace xview {

// All lengths that stages compare with (cells, voxels, reaches, tolerances) are those of a town. A
// place of another size is brought to lengths of a town before anything looks at it, and the answer
// is brought back: so every length follows, also the precision of points. Sizes are powers of two,
// which changes no digit of a number.

constexpr double kTown = 1, kRoom = 1. / 4, kDesk = 1. / 16;

/// A length of the place over the same one of a town, for options.size; none for auto.
std::optional<double> parseSize(const std::string& text);
/// The word, or the typical spacing of neighbouring things [m]: parseSize() reads it back.
std::string sizeText(double size);
void requireSize(const std::string& name, const std::string& text);

/// Every length times `factor`, about the origin of the frame.
void scaleLengths(double factor, SemanticGraph& graph);
void scaleLengths(double factor, LabelledCloud& cloud);
void scaleLengths(double factor, PlanView& plan);
void scaleLengths(double factor, Place& place);
void scaleLengths(double factor, Frame& frame);
void scaleLengths(double factor, Localization& answer);
void scaleLengths(double factor, Eigen::Isometry3d& T);

/// The same thing in other lengths; a copy is made only if they differ.
template <class Thing>
class Scaled {
 public:
  Scaled(const Thing& given, double factor) : given_(given) {
    if (factor == 1) return;
    changed_ = given;
    scaleLengths(factor, *changed_);
  }
  Scaled(const Scaled&) = delete;
  Scaled& operator=(const Scaled&) = delete;
  const Thing& operator*() const { return changed_ ? *changed_ : given_; }
  const Thing* operator->() const { return &**this; }

 private:
  const Thing& given_;
  std::optional<Thing> changed_;
};

}  // namespace xview
