// SPDX-License-Identifier: BSD-3-Clause
#include "distribution_cells.h"
#include "xview/pose/refine.h"

namespace xview {

DistributionMap::DistributionMap(const LabelledCloud& map, const LabelSet& labels,
                                 const std::vector<Eigen::Isometry3d>& viewpoints,
                                 const RefineOptions& options)
    : cells_(std::make_unique<DistributionCells>(map, labels, viewpoints, options)) {}

DistributionMap::DistributionMap(LabelledCloud&& map, const LabelSet& labels,
                                 const std::vector<Eigen::Isometry3d>& viewpoints,
                                 const RefineOptions& options)
    : kept_(std::make_unique<const LabelledCloud>(std::move(map))),
      cells_(std::make_unique<DistributionCells>(*kept_, labels, viewpoints, options)) {}

DistributionMap::~DistributionMap() = default;
DistributionMap::DistributionMap(DistributionMap&&) noexcept = default;
std::size_t DistributionMap::size() const { return cells_->size(); }

}  // namespace xview
