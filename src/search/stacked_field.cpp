// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "search/raster.h"
#include "search/search.h"

namespace xview::search {
namespace {

/// A query in the fields of all storeys. A pose belongs to the storey in which it puts the sensor
/// (Observation::focus), which is well above a floor and below a ceiling.
class StackedQuery final : public FieldQuery {
 public:
  /// `queries`: the query in each of `fields`, which must outlive it.
  StackedQuery(const std::vector<FieldAbove>& fields,
               std::vector<std::unique_ptr<FieldQuery>> queries)
      : FieldQuery(queries.front()->origin(), queries.front()->focus()),
        fields_(fields),
        queries_(std::move(queries)) {
    centre_ = lowest().centre();
    radius_ = lowest().radius();
    for (std::size_t i = 0; i < queries_.size(); ++i) queries_[i]->setStorey(static_cast<int>(i));
  }

  const FieldQuery& at(const Eigen::Isometry3d& T_map_query) const override {
    const double z = (T_map_query * focus_).z();
    std::size_t storey = 0;
    while (storey + 1 < fields_.size() && fields_[storey + 1].bottom <= z) ++storey;
    return *queries_[storey];
  }
  std::vector<const FieldQuery*> storeys() const override {
    std::vector<const FieldQuery*> all;
    for (const auto& query : queries_) all.push_back(query.get());
    return all;
  }

  std::size_t size() const override { return lowest().size(); }
  std::unique_ptr<FieldQuery> part(const Eigen::Vector2d& centre, double radius_m) const override {
    std::vector<std::unique_ptr<FieldQuery>> parts;
    for (const auto& query : queries_) parts.push_back(query->part(centre, radius_m));
    return std::make_unique<StackedQuery>(fields_, std::move(parts));
  }
  HeightFit fitHeights(const Eigen::Isometry3d& T_map_query, double slope_sigma) const override {
    return at(T_map_query).fitHeights(T_map_query, slope_sigma);
  }
  std::vector<SampleEvidence> evidence(const Eigen::Isometry3d& T_map_query) const override {
    return at(T_map_query).evidence(T_map_query);
  }
  Visibility visibility(const Eigen::Isometry3d& T_map_query) const override {
    return at(T_map_query).visibility(T_map_query);
  }
  std::vector<Point> points() const override { return lowest().points(); }
  RasterLevels rasterLevels() const override { return lowest().rasterLevels(); }
  PlacePose refineLocally(const PlacePose& pose, RefinementLevel how) const override {
    return lowest().refineLocally(pose, how);
  }
  double scoreAt(const PlacePose& pose) const override { return lowest().scoreAt(pose); }
  PlaceHypothesis describeAt(const PlacePose& pose) const override {
    return lowest().describeAt(pose);
  }

 private:
  const FieldQuery& lowest() const { return *queries_.front(); }

  const std::vector<FieldAbove>& fields_;
  std::vector<std::unique_ptr<FieldQuery>> queries_;
};

class StackedField final : public Field {
 public:
  explicit StackedField(std::vector<FieldAbove> fields) : fields_(std::move(fields)) {}
  std::unique_ptr<FieldQuery> prepare(const Observation& query) const override {
    std::vector<std::unique_ptr<FieldQuery>> queries;
    for (const FieldAbove& above : fields_) queries.push_back(above.field->prepare(query));
    return std::make_unique<StackedQuery>(fields_, std::move(queries));
  }
  std::size_t size() const override {
    std::size_t sum = 0;
    for (const FieldAbove& above : fields_) sum += above.field->size();
    return sum;
  }

 private:
  std::vector<FieldAbove> fields_;
};

}  // namespace

std::unique_ptr<const Field> makeStackedField(std::vector<FieldAbove> storeys) {
  return std::make_unique<StackedField>(std::move(storeys));
}

}  // namespace xview::search
