// SPDX-License-Identifier: BSD-3-Clause
#include "object_town.h"

#include <algorithm>
#include <cmath>

#include "xview/types/error.h"
#include "xview/types/random.h"

namespace xview::bench {
namespace {

constexpr double kCell = 25;  // [m] of the object index

/// Proportions of a quarter.
struct Style {
  double lot_width, gap, set_back;     // [m]
  double tree_row, car, fence, hedge;  // chances
};
constexpr Style kStyles[4] = {{17, 1, 9, 0.35, 0.60, 0.05, 0.05},    // centre
                              {12, 4, 11, 0.60, 0.40, 0.35, 0.35},   // houses
                              {14, 9, 13, 0.30, 0.20, 0.40, 0.45},   // suburb
                              {18, 3, 12, 0.95, 0.45, 0.10, 0.15}};  // boulevard

/// Regularities that all streets of a quarter share.
struct Quarter {
  Style style;
  double floors_m;
  double tree_spacing, pole_spacing, curb;  // [m]
  bool poles_on_both_sides;
  bool is_centre;
};

Quarter quarterOf(std::uint64_t seed, std::uint32_t crossing, int n) {
  const std::uint32_t i = crossing / static_cast<std::uint32_t>(n),
                      j = crossing % static_cast<std::uint32_t>(n);
  Random random(seed * 131 + 7, (i / 4) * 1000 + j / 4);
  Quarter quarter;
  const std::uint32_t style = random.below(4);
  quarter.style = kStyles[style];
  quarter.is_centre = style == 0;
  quarter.floors_m = 3;
  quarter.tree_spacing = 8 + 2.0 * random.below(3);
  quarter.pole_spacing = 25 + 5.0 * random.below(3);
  quarter.poles_on_both_sides = random.below(2) == 1;
  quarter.curb = 5.0 + 0.5 * random.below(3);
  return quarter;
}

/// Furnishes one side of one street.
class SideBuilder {
 public:
  SideBuilder(const ObjectTown& town, const Eigen::Vector2d& a, const Eigen::Vector2d& b, int side,
              const Quarter& quarter, Random& random, std::vector<TownObject>& objects)
      : town_(town),
        start_(a),
        length_((b - a).norm()),
        along_((b - a) / length_),
        outward_(side * Eigen::Vector2d(-along_.y(), along_.x())),
        left_(side > 0),
        quarter_(quarter),
        random_(random),
        objects_(objects) {}

  void build() {
    addLots();
    addTreeRow();
    if (left_ || quarter_.poles_on_both_sides) addPoles();
    addParkingBays();
    addSigns();
  }

 private:
  TownObject& put(TownClass label, double s, double offset, double height, double half_length = 0) {
    const Eigen::Vector2d p = start_ + along_ * s + outward_ * offset;
    TownObject object;
    object.x = static_cast<float>(p.x());
    object.y = static_cast<float>(p.y());
    object.z = static_cast<float>(town_.ground(p.x(), p.y()));
    object.half_length = static_cast<float>(half_length);
    object.direction = along_.cast<float>();
    object.outward = outward_.cast<float>();
    object.height = static_cast<float>(height);
    object.face = static_cast<float>(random_.uniform());
    object.label = label;
    objects_.push_back(object);
    return objects_.back();
  }

  void addLots() {
    const Style& style = quarter_.style;
    double s = 9 + random_.uniform(0, 5);
    while (s < length_ - 9) {
      const double width = std::max(6.0, style.lot_width * (1 + 0.18 * random_.normal()));
      if (s + width > length_ - 6) break;
      addLot(s, width);
      s += width + style.gap * (0.6 + 0.8 * random_.uniform());
    }
  }

  void addLot(double s, double width) {
    const Style& style = quarter_.style;
    const double set_back = style.set_back + 0.6 * random_.normal();
    const double height = quarter_.is_centre ? 12 + quarter_.floors_m * random_.below(3) : 7;
    if (random_.uniform() < 0.92)
      put(TownClass::building, s + width / 2, set_back, height, width / 2);
    const double border = random_.uniform();
    if (border < style.fence + style.hedge) {
      put(border < style.fence ? TownClass::fence : TownClass::hedge, s + width / 2,
          quarter_.curb + 2.2 + 0.2 * random_.normal(), 1.2, width * 0.45);
    }
    if (random_.uniform() < 0.25) {
      put(TownClass::tree, s + random_.uniform(0, width), set_back - random_.uniform(1.5, 3), 5);
    }
    const std::uint32_t behind = random_.uniform() < 0.7 ? 1 + random_.below(2) : 0;
    for (std::uint32_t k = 0; k < behind; ++k) {
      put(TownClass::tree, s + random_.uniform(0, width), set_back + random_.uniform(13, 22), 6)
          .place = TownObject::Place::back_yard;
    }
  }

  void addTreeRow() {
    if (random_.uniform() >= quarter_.style.tree_row) return;
    for (double s = 8 + random_.uniform(0, quarter_.tree_spacing); s < length_ - 7;
         s += quarter_.tree_spacing) {
      if (random_.uniform() < 0.12) continue;
      put(TownClass::tree, s + 0.35 * random_.normal(),
          quarter_.curb + 1.3 + 0.25 * random_.normal(), 5);
    }
  }

  void addPoles() {
    const double first = 6 + (left_ ? 0 : quarter_.pole_spacing / 2) + random_.uniform(0, 6);
    for (double s = first; s < length_ - 5; s += quarter_.pole_spacing) {
      put(TownClass::pole, s + 0.3 * random_.normal(), quarter_.curb + 0.6 + 0.1 * random_.normal(),
          4);
    }
  }

  void addParkingBays() {
    for (double s = 12; s < length_ - 12; s += 6) {
      if (random_.uniform() >= quarter_.style.car + 0.25) continue;
      TownObject& bay = put(TownClass::car, s + 0.4 * random_.normal(),
                            quarter_.curb - 1.1 + 0.15 * random_.normal(), 0.8);
      bay.place = TownObject::Place::parking_bay;
      bay.occupancy = static_cast<float>(quarter_.style.car / (quarter_.style.car + 0.25));
    }
  }

  void addSigns() {
    if (random_.uniform() < 0.75) {
      const double from_crossing = 8 + random_.uniform(0, 4);
      put(TownClass::sign, left_ ? from_crossing : length_ - from_crossing, quarter_.curb + 0.5,
          2.3);
    }
    if (random_.uniform() < 0.35) {
      put(TownClass::sign, random_.uniform(15, std::max(16.0, length_ - 15)), quarter_.curb + 0.5,
          2.3);
    }
  }

  const ObjectTown& town_;
  Eigen::Vector2d start_;
  double length_;
  Eigen::Vector2d along_, outward_;
  bool left_;
  const Quarter& quarter_;
  Random& random_;
  std::vector<TownObject>& objects_;
};

}  // namespace

LabelSet objectTownLabels() {
  LabelSet labels("object_town");
  const auto add = [&](TownClass id, const char* name, Role role, Kind kind) {
    ClassInfo info;
    info.id = static_cast<std::uint32_t>(id);
    info.name = name;
    info.color = distinctColor(info.id);
    info.role = role;
    info.kind = kind;
    labels.add(info);
  };
  add(TownClass::street, "street", Role::surface, Kind::road);
  add(TownClass::building, "building", Role::surface, Kind::building);
  add(TownClass::tree, "tree", Role::object, Kind::vegetation);
  add(TownClass::pole, "pole", Role::object, Kind::pole);
  add(TownClass::car, "car", Role::dynamic, Kind::vehicle);
  add(TownClass::fence, "fence", Role::surface, Kind::fence);
  add(TownClass::sign, "sign", Role::object, Kind::sign);
  add(TownClass::hedge, "hedge", Role::surface, Kind::vegetation);
  return labels;
}

ObjectTown::ObjectTown(int streets_per_side, std::uint64_t seed) : seed_(seed) {
  if (streets_per_side < 2 || streets_per_side > 1000) {
    throw UsageError("object town: streets per side = " + std::to_string(streets_per_side) +
                     ", must be in [2, 1000]");
  }
  makeCrossings(streets_per_side);
  makeStreets(streets_per_side);
  indexObjects();
}

void ObjectTown::makeCrossings(int n) {
  Random random(seed_, 1);
  const auto axis = [&](double smallest, std::uint32_t steps) {
    std::vector<double> positions{0};
    for (int i = 1; i < n; ++i) {
      positions.push_back(positions.back() + smallest + 10.0 * random.below(steps) +
                          random.uniform(-3, 3));
    }
    return positions;
  };
  const std::vector<double> x = axis(80, 6), y = axis(60, 5);
  const double phase_x = random.uniform(0, 6), phase_y = random.uniform(0, 6);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double px = x[i] + 3 * random.normal(), py = y[j] + 3 * random.normal();
      crossings_.emplace_back(px + 70 * std::sin(py / 523 + phase_x),
                              py + 55 * std::sin(px / 677 + phase_y));
    }
  }
}

void ObjectTown::makeStreets(int n) {
  Random random(seed_, 2);
  streets_at_.resize(crossings_.size());
  const auto connect = [&](std::uint32_t a, std::uint32_t b) {
    if (random.uniform() < 0.13) return;
    if (random.uniform() < 0.5) std::swap(a, b);
    const auto street = static_cast<std::uint32_t>(streets_.size());
    streets_at_[a].push_back(street);
    streets_at_[b].push_back(street);
    streets_.push_back({a, b});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const auto here = static_cast<std::uint32_t>(i * n + j);
      if (i + 1 < n) connect(here, here + static_cast<std::uint32_t>(n));
      if (j + 1 < n) connect(here, here + 1);
    }
  }
  if (streets_.empty()) {  // all of a tiny grid missing: one street stays
    streets_.push_back({0, 1});
    streets_at_[0].push_back(0);
    streets_at_[1].push_back(0);
  }
  for (std::size_t e = 0; e < streets_.size(); ++e) {
    Random street_random(seed_ * 7919 + 5, e);
    const Quarter quarter = quarterOf(seed_, streets_[e].from, n);
    for (const int side : {-1, 1}) {
      SideBuilder(*this, crossings_[streets_[e].from], crossings_[streets_[e].to], side, quarter,
                  street_random, objects_)
          .build();
    }
  }
}

double ObjectTown::ground(double x, double y) const {
  return 12 * std::sin(x / 611 + 1) + 9 * std::cos(y / 433) + 5 * std::sin((x + y) / 257);
}

double ObjectTown::streetLength() const {
  double length = 0;
  for (const Street& street : streets_)
    length += (crossings_[street.to] - crossings_[street.from]).norm();
  return length;
}

void ObjectTown::indexObjects() {
  double max_x = 0, max_y = 0;
  for (const TownObject& o : objects_) {
    min_x_ = std::min<double>(min_x_, o.x);
    min_y_ = std::min<double>(min_y_, o.y);
    max_x = std::max<double>(max_x, o.x);
    max_y = std::max<double>(max_y, o.y);
  }
  cells_x_ = static_cast<std::size_t>((max_x - min_x_) / kCell) + 1;
  cells_y_ = static_cast<std::size_t>((max_y - min_y_) / kCell) + 1;
  const auto cellOf = [&](const TownObject& o) {
    return static_cast<std::size_t>((o.y - min_y_) / kCell) * cells_x_ +
           static_cast<std::size_t>((o.x - min_x_) / kCell);
  };
  cell_start_.assign(cells_x_ * cells_y_ + 1, 0);
  for (const TownObject& o : objects_) ++cell_start_[cellOf(o) + 1];
  for (std::size_t i = 1; i < cell_start_.size(); ++i) cell_start_[i] += cell_start_[i - 1];
  cell_object_.resize(objects_.size());
  std::vector<std::uint32_t> next(cell_start_.begin(), cell_start_.end() - 1);
  for (std::uint32_t i = 0; i < objects_.size(); ++i) cell_object_[next[cellOf(objects_[i])]++] = i;
}

void ObjectTown::objectsNear(double x, double y, double radius,
                             std::vector<std::uint32_t>& found) const {
  found.clear();
  const auto cell = [](double v, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(v / kCell, 0.0, static_cast<double>(count - 1)));
  };
  const std::size_t x0 = cell(x - radius - min_x_, cells_x_),
                    x1 = cell(x + radius - min_x_, cells_x_);
  const std::size_t y0 = cell(y - radius - min_y_, cells_y_),
                    y1 = cell(y + radius - min_y_, cells_y_);
  for (std::size_t row = y0; row <= y1; ++row) {
    const std::uint32_t begin = cell_start_[row * cells_x_ + x0],
                        end = cell_start_[row * cells_x_ + x1 + 1];
    found.insert(found.end(), cell_object_.begin() + begin, cell_object_.begin() + end);
  }
  std::sort(found.begin(), found.end());
}

}  // namespace xview::bench
