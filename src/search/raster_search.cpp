// SPDX-License-Identifier: BSD-3-Clause
#include "search/raster.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <tuple>

#include "base/parallel.h"
#include "search/raster_parts.h"
#include "search/shared_scan.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"

namespace xview::search {
namespace {

static_assert(kBlock == kTileSide, "output blocks are tiles");

std::size_t workerCount(int threads, std::size_t jobs) {
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  return std::min(threads > 0 ? static_cast<std::size_t>(threads) : cores, jobs);
}

/// Calls work(worker) on several threads; each is to take jobs until there are none left.
template <class Work>
void onWorkers(std::size_t workers, const Work& work) {
  if (workers > 0) parallelFor(workers, static_cast<int>(workers), work);
}

/// What one thread needs while it scans tiles.
struct ScanWorker {
  Window window;
  BestCandidates best;
  std::vector<BlockHit> hits;
  std::vector<const std::uint8_t*> pointers;
  std::vector<std::uint32_t> groups;

  ScanWorker(const LikelihoodRaster& raster, const PreparedSamples& prepared, BestCandidates none)
      : window(raster, prepared, kBlock + 2 * prepared.reach),
        best(std::move(none)),
        hits(kBlock * kBlock) {}
};

/// The exhaustive search of one raster.
class Scan {
 public:
  explicit Scan(const RasterLevels& levels)
      : raster_(levels.first().raster),
        levels_(levels),
        prepared_(raster_, levels.first().samples),
        grid_(yawGrid(yawStep(levels.first()), levels.centre_prior.heading)),
        offsets_(offsetTable(prepared_, grid_, raster_.cellSize())) {}

  const YawGrid& grid() const { return grid_; }

  /// The best keep_cells candidates, best first.
  std::vector<Candidate> run() {
    std::vector<OutputTile> outputs = outputTiles(raster_, prepared_, levels_);
    SharedScan shared(levels_, prepared_, outputs);
    BestCandidates all = bestIn(outputs);
    shared.collect(all);
    return std::move(all).sorted();
  }

  BestCandidates bestIn(const std::vector<OutputTile>& outputs) {
    const std::size_t workers = workerCount(levels_.threads, outputs.size());
    const BestCandidates none(levels_.keep_cells, levels_.coarse ? levels_.least_share : 0);
    std::vector<BestCandidates> best(workers, none);
    std::atomic<std::size_t> next{0};
    onWorkers(workers, [&](std::size_t w) {
      ScanWorker worker(raster_, prepared_, none);
      for (std::size_t i = next++; i < outputs.size(); i = next++) scanTile(outputs[i], worker);
      best[w] = std::move(worker.best);
    });
    BestCandidates all = none;
    for (const BestCandidates& part : best) all.merge(part);
    return all;
  }

 private:
  /// A cell below the K best of one worker is not among the K best of all.
  std::int32_t threshold(const ScanWorker& worker) const {
    return std::max(worker.best.threshold(), shared_threshold_.load(std::memory_order_relaxed));
  }

  void publish(std::int32_t threshold) {
    std::int32_t known = shared_threshold_.load(std::memory_order_relaxed);
    while (known < threshold &&
           !shared_threshold_.compare_exchange_weak(known, threshold, std::memory_order_relaxed)) {
    }
  }

  void scanTile(const OutputTile& output, ScanWorker& worker) {
    if (output.bound < threshold(worker)) return;
    worker.window.load(output.tx * kTileSide - prepared_.reach,
                       output.ty * kTileSide - prepared_.reach);
    for (int yaw = 0; yaw < grid_.count; ++yaw) {
      askBudget(kSearchStage);
      for (const RowRun& rows : output.rows) scanRows(output, yaw, rows, worker);
    }
    publish(worker.best.threshold());
  }

  /// All rows at once if every sample finds content there; else in bands, which leave out more
  /// samples.
  void scanRows(const OutputTile& output, int yaw, const RowRun& rows, ScanWorker& worker) {
    const Selection selection = select(yaw, rows, worker);
    if (selection.bound < threshold(worker)) return;
    if (selection.is_complete || rows.count == kPartSide) {
      scanSelected(output, yaw, rows, selection, worker);
      return;
    }
    for (std::int64_t row = rows.first; row < rows.first + rows.count; row += kPartSide) {
      scanRows(output, yaw, {row, kPartSide}, worker);
    }
  }

  struct Selection {
    std::int64_t bound = 0;       ///< of the scores
    std::int64_t background = 0;  ///< sum over the selected samples
    bool is_complete = true;
  };

  /// Leaves out samples that find nothing but background in these rows; arranges the others in
  /// groups that a byte can hold.
  Selection select(int yaw, const RowRun& rows, ScanWorker& worker) const {
    Selection selection;
    worker.pointers.clear();
    worker.groups.clear();
    const CellOffset* offset = offsets_.data() + static_cast<std::size_t>(yaw) * prepared_.size();
    int in_group = 256;
    for (std::size_t k = 0; k < prepared_.size(); ++k) {
      const std::uint32_t slot = prepared_.slot[k];
      const std::int64_t x = prepared_.reach + offset[k].x,
                         y = prepared_.reach + offset[k].y + rows.first;
      if (!worker.window.isDense(slot) &&
          !worker.window.mayDiffer(slot, x, y, kBlock, rows.count)) {
        selection.is_complete = false;
        continue;
      }
      const int highest = worker.window.highest(slot);
      in_group += highest;
      if (in_group > 255) {
        worker.groups.push_back(static_cast<std::uint32_t>(worker.pointers.size()));
        in_group = highest;
      }
      worker.pointers.push_back(worker.window.cell(slot, x, y));
      selection.bound += highest - prepared_.background[slot];
      selection.background += prepared_.background[slot];
    }
    worker.groups.push_back(static_cast<std::uint32_t>(worker.pointers.size()));
    return selection;
  }

  void scanSelected(const OutputTile& output, int yaw, const RowRun& rows,
                    const Selection& selection, ScanWorker& worker) {
    const BlockScan block{worker.pointers.data(),
                          worker.groups.data(),
                          worker.groups.size() - 1,
                          worker.window.side(),
                          static_cast<int>(rows.count),
                          static_cast<std::uint32_t>(threshold(worker) + selection.background)};
    const std::size_t count = scanBlock(block, worker.hits.data());
    for (std::size_t i = 0; i < count; ++i) {
      const BlockHit& hit = worker.hits[i];
      const Candidate candidate{static_cast<std::int32_t>(hit.sum - selection.background), yaw,
                                output.tx * kTileSide + hit.column,
                                output.ty * kTileSide + rows.first + hit.row};
      if (isAllowed(candidate)) worker.best.offer(candidate);
    }
  }

  bool isAllowed(const Candidate& c) const {
    const auto& near = levels_.centre_prior.near;
    if (!near) return true;
    const double cell = raster_.cellSize();
    const double x = (static_cast<double>(c.x) + 0.5) * cell,
                 y = (static_cast<double>(c.y) + 0.5) * cell;
    return std::hypot(x - near->x, y - near->y) <=
           near->radius + 0.71 * cell;  // the cell may touch the circle
  }

  const LikelihoodRaster& raster_;
  const RasterLevels& levels_;
  PreparedSamples prepared_;
  YawGrid grid_;
  std::vector<CellOffset> offsets_;
  std::atomic<std::int32_t> shared_threshold_{1};
};

/// Coarse cells of a side of the squares whose candidates are refined together.
constexpr int kGroupBits = 4, kGroupSide = 1 << kGroupBits;

/// Looks at the fine cells and headings behind each coarse candidate.
class Refinement {
 public:
  Refinement(const RasterLevel& fine, int cell_ratio, const YawGrid& coarse_grid)
      : ratio_(cell_ratio),
        prepared_(fine.raster, fine.samples),
        fine_(fine),
        yaws_per_coarse_(yawsPerCoarse(fine, coarse_grid)),
        grid_(fineGrid(coarse_grid)),
        offsets_(offsetTable(prepared_, grid_, fine.raster.cellSize())) {}

  const YawGrid& grid() const { return grid_; }

  /// One fine candidate of positive score per coarse one at most, best first.
  std::vector<Candidate> run(std::vector<Candidate> candidates, int threads) const {
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::make_tuple(a.y >> kGroupBits, a.x >> kGroupBits, a) <
             std::make_tuple(b.y >> kGroupBits, b.x >> kGroupBits, b);
    });
    std::vector<std::size_t> first_of_group;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (i == 0 || !areInOneGroup(candidates[i - 1], candidates[i])) first_of_group.push_back(i);
    }
    first_of_group.push_back(candidates.size());
    const std::size_t count = first_of_group.size() - 1;
    std::atomic<std::size_t> next{0};
    onWorkers(workerCount(threads, count), [&](std::size_t) {
      Window near(fine_.raster, prepared_, kGroupSide * ratio_ + 2 * prepared_.reach);
      for (std::size_t g = next++; g < count; g = next++) {
        askBudget(kSearchStage);
        refineGroup(candidates, first_of_group[g], first_of_group[g + 1], near);
      }
    });
    const auto isPointless = [](const Candidate& c) { return c.score <= 0; };
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), isPointless),
                     candidates.end());
    std::sort(candidates.begin(), candidates.end());
    return candidates;
  }

 private:
  static int yawsPerCoarse(const RasterLevel& fine, const YawGrid& coarse_grid) {
    return std::max(1, static_cast<int>(std::ceil(coarse_grid.step / yawStep(fine) - 1e-9)));
  }

  YawGrid fineGrid(const YawGrid& coarse) const {
    const double step = coarse.step / yaws_per_coarse_;
    return {coarse.first + (0.5 - 0.5 * yaws_per_coarse_) * step, step,
            coarse.count * yaws_per_coarse_};
  }

  static bool areInOneGroup(const Candidate& a, const Candidate& b) {
    return a.x >> kGroupBits == b.x >> kGroupBits && a.y >> kGroupBits == b.y >> kGroupBits;
  }

  void load(std::int64_t x, std::int64_t y, Window& near) const {
    std::unique_lock<std::mutex> lock;
    if (fine_.write_first) lock = fine_.write_first(x, y, near.side());
    near.load(x, y);
  }

  /// Replaces coarse candidates of one group by their best fine ones.
  void refineGroup(std::vector<Candidate>& candidates, std::size_t begin, std::size_t end,
                   Window& near) const {
    const std::int64_t x0 = (candidates[begin].x >> kGroupBits) * kGroupSide * ratio_;
    const std::int64_t y0 = (candidates[begin].y >> kGroupBits) * kGroupSide * ratio_;
    load(x0 - prepared_.reach, y0 - prepared_.reach, near);
    std::vector<std::int32_t> sums(static_cast<std::size_t>(ratio_ * ratio_));
    for (std::size_t i = begin; i < end; ++i) {
      const std::int64_t x = candidates[i].x * ratio_, y = candidates[i].y * ratio_;
      Candidate best{-1, 0, 0, 0};
      for (int t = 0; t < yaws_per_coarse_; ++t) {
        const int yaw = candidates[i].yaw * yaws_per_coarse_ + t;
        sumCells(near, x - x0 + prepared_.reach, y - y0 + prepared_.reach, yaw, sums);
        for (std::size_t k = 0; k < sums.size(); ++k) {
          const auto cell = static_cast<std::int64_t>(k);
          best = std::min(best, Candidate{sums[k], yaw, x + cell % ratio_, y + cell / ratio_});
        }
      }
      candidates[i] = best;
    }
  }

  /// Of a square of cells, relative to the first one of the window, row by row.
  void sumCells(const Window& near, std::int64_t x, std::int64_t y, int yaw,
                std::vector<std::int32_t>& sums) const {
    std::fill(sums.begin(), sums.end(), static_cast<std::int32_t>(-prepared_.background_sum));
    const CellOffset* offset = offsets_.data() + static_cast<std::size_t>(yaw) * prepared_.size();
    for (std::size_t k = 0; k < prepared_.size(); ++k) {
      const std::uint8_t* cell = near.cell(prepared_.slot[k], x + offset[k].x, y + offset[k].y);
      for (std::int32_t* sum = sums.data(); sum < sums.data() + sums.size(); cell += near.side()) {
        for (int column = 0; column < ratio_; ++column) *sum++ += cell[column];
      }
    }
  }

  int ratio_;
  PreparedSamples prepared_;
  const RasterLevel& fine_;
  int yaws_per_coarse_;
  YawGrid grid_;
  std::vector<CellOffset> offsets_;
};

/// `candidates`: best first. See RasterLevels.
void keepRivals(const RasterLevels& levels, std::vector<Candidate>& candidates) {
  if (candidates.empty()) return;
  const double best = candidates.front().score;
  const auto isBelow = [&](double share) {
    return [least = share * best](const Candidate& c) { return c.score < least; };
  };
  const auto weak = std::find_if(candidates.begin(), candidates.end(), isBelow(levels.clear_share));
  const auto most = candidates.begin() +
                    static_cast<std::ptrdiff_t>(std::min(levels.few_cells, candidates.size()));
  const auto end = std::max(weak, most);
  candidates.erase(std::find_if(candidates.begin(), end, isBelow(levels.least_share)),
                   candidates.end());
}

int cellRatio(double coarse_m, double fine_m) {
  const double ratio = coarse_m / fine_m;
  if (std::abs(ratio - std::round(ratio)) > 1e-6 || ratio < 0.5) {
    throw UsageError("raster search: coarse cells of " + std::to_string(coarse_m) +
                     " m are no multiple of fine cells of " + std::to_string(fine_m) + " m");
  }
  return static_cast<int>(std::lround(ratio));
}

}  // namespace

std::vector<Candidate> scanTiles(const RasterLevels& levels,
                                 const std::vector<OutputTile>& outputs) {
  if (levels.first().samples.empty()) return {};
  check(levels.first());
  return Scan(levels).bestIn(outputs).sorted();
}

std::vector<PlacePose> searchRaster(const RasterLevels& levels) {
  const RasterLevel& fine = levels.fine;
  check(levels.first());
  check(fine);
  const double cell_m = fine.raster.cellSize();
  const int ratio = cellRatio(levels.first().raster.cellSize(), cell_m);
  if (levels.first().samples.empty() || fine.samples.empty()) return {};
  Scan scan(levels);
  if (!levels.coarse) return distinctPoses(scan.run(), scan.grid(), cell_m, levels.keep_poses);
  std::vector<Candidate> candidates = scan.run();
  keepRivals(levels, candidates);
  const Refinement refinement(fine, ratio, scan.grid());
  return distinctPoses(refinement.run(std::move(candidates), levels.threads), refinement.grid(),
                       cell_m, levels.keep_poses);
}

}  // namespace xview::search
