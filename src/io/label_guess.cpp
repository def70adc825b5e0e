// SPDX-License-Identifier: BSD-3-Clause
// Classes of recordings whose files name none.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "layouts.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

/// Number of places in which frames and clouds are sampled; of scans fewer will do, as every one
/// has thousands of labels.
constexpr std::size_t kFramesToLookAt = 32, kScansToLookAt = 8;
/// A set fits if it knows this share of the points; networks and exporters add a few odd ids.
constexpr double kKnownShare = 0.9;

template <class Counts>
double shareOf(const LabelCounts& counts, Counts&& of_id) {
  std::uint64_t all = 0, some = 0;
  for (const auto& [id, points] : counts) {
    all += points;
    if (of_id(id)) some += points;
  }
  return all > 0 ? static_cast<double>(some) / static_cast<double>(all) : 0;
}

double knownShare(const LabelCounts& counts, const LabelSet& labels) {
  return shareOf(counts, [&](std::uint32_t id) { return labels.find(id) != nullptr; });
}

/// Some thousand points of a frame, in the frame of the sensor [m].
std::vector<Point> somePoints(const Frame& frame) {
  constexpr std::size_t kPoints = 20000;
  const auto step = [](std::size_t size) { return std::max<std::size_t>(1, size / kPoints); };
  std::vector<Point> points;
  const std::vector<float>& depths = frame.depth.pixels;
  const std::size_t pixels = std::min(depths.size(), frame.label.pixels.size());
  const auto width = static_cast<std::size_t>(frame.depth.width);
  for (std::size_t i = 0; i < pixels; i += step(pixels)) {
    if (!isDepth(depths[i])) continue;
    const Eigen::Vector3f p =
        frame.camera
            .unproject(static_cast<double>(i % width), static_cast<double>(i / width), depths[i])
            .cast<float>();
    points.emplace_back(p.x(), p.y(), p.z(), frame.label.pixels[i]);
  }
  for (std::size_t i = 0; i < frame.cloud.size(); i += step(frame.cloud.size()))
    points.push_back(frame.cloud.points[i]);
  return points;
}

/// What is seen of a recording in one pass over frames spread over it.
struct Impression {
  LabelCounts counts;
  std::vector<std::vector<Point>> frames;  ///< some points of each
};

Impression lookAt(const RecordingListing& listing, std::size_t max_frames) {
  Impression seen;
  const std::size_t count = listing.frames.size(), samples = std::min(count, max_frames);
  for (std::size_t i = 0; i < samples; ++i) {
    const Frame frame = readListed(listing, listing.frames[i * count / samples]);
    for (const std::uint16_t label : frame.label.pixels) ++seen.counts[label];
    for (const auto& point : frame.cloud.points) ++seen.counts[point.label];
    seen.frames.push_back(somePoints(frame));
  }
  return seen;
}

// ---- does the ground lie as ground does?

/// How the points of a frame lie if a label set names them.
struct Lie {
  double ground_share = 0;       ///< of all points
  Eigen::Vector3d mean, normal;  ///< of the ground
  double thickness_m = 0;  ///< standard deviation of ground points across the plane through them
  double width_m = 0;      ///< the smaller one within that plane
  double one_side = 0;     ///< share of the other points that is on the fuller side of it
};

std::optional<Lie> lieOf(const std::vector<Point>& points, const LabelSet& labels) {
  constexpr std::size_t kFewest = 100;
  std::vector<Eigen::Vector3d> ground, others;
  for (const Point& p : points) {
    (isGround(labels.kind(p.label)) ? ground : others).push_back(p.getVector3fMap().cast<double>());
  }
  if (ground.size() < kFewest || others.size() < kFewest) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : ground) mean += p / static_cast<double>(ground.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : ground)
    covariance += (p - mean) * (p - mean).transpose() / static_cast<double>(ground.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  Lie lie;
  lie.ground_share =
      static_cast<double>(ground.size()) / static_cast<double>(ground.size() + others.size());
  lie.mean = mean;
  lie.normal = axes.eigenvectors().col(0);
  lie.thickness_m = std::sqrt(std::max(0.0, axes.eigenvalues()[0]));
  lie.width_m = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  const auto above = std::count_if(others.begin(), others.end(), [&](const Eigen::Vector3d& p) {
    return (p - mean).dot(axes.eigenvectors().col(0)) > 0;
  });
  const double share = static_cast<double>(above) / static_cast<double>(others.size());
  lie.one_side = std::max(share, 1 - share);
  return lie;
}

/// Whether what a set calls ground is a plane with everything else on one side of it, in most of
/// the frames that show enough of it; nothing if none does. Whatever way is up.
std::optional<bool> groundFits(const Impression& seen, const LabelSet& labels,
                               double min_width_m = 0) {
  constexpr double kThickest = 0.3, kOneSide = 0.8, kGroundShare = 0.05;
  int fits = 0, judged = 0;
  for (const std::vector<Point>& points : seen.frames) {
    const auto lie = lieOf(points, labels);
    if (!lie) continue;
    ++judged;
    fits += lie->ground_share >= kGroundShare && lie->thickness_m <= kThickest * lie->width_m &&
            lie->one_side >= kOneSide && lie->width_m >= min_width_m;
  }
  if (judged == 0) return std::nullopt;
  return 2 * fits > judged;
}

// ---- SemanticKITTI

/// The raw ids of SemanticKITTI leave gaps and go up to 259; no other usual data set has several of
/// those above 30 and none in the gaps. Its scans are of streets: little is unlabelled, and the
/// ground reaches far.
bool areRawSemanticKitti(const Impression& seen, const LabelSet& raw) {
  constexpr std::uint32_t kAboveOthers = 30;
  constexpr std::ptrdiff_t kSeveral = 5;
  constexpr double kUnlabelledShare = 0.3, kStreetWidth_m = 1.5;
  const LabelCounts& counts = seen.counts;
  const auto above = std::count_if(counts.begin(), counts.end(), [&](const auto& entry) {
    return entry.first > kAboveOthers && raw.find(entry.first);
  });
  const auto is_ignored = [&](std::uint32_t id) { return raw.role(id) == Role::ignored; };
  return above >= kSeveral && knownShare(counts, raw) >= 0.999 &&
         shareOf(counts, is_ignored) <= kUnlabelledShare &&
         groundFits(seen, raw, kStreetWidth_m).value_or(false);
}

/// What the ids of a SemanticKITTI folder are; nothing if they are others.
std::optional<std::string> semanticKittiSet(const LabelCounts& counts) {
  const bool training_ids = std::all_of(counts.begin(), counts.end(), [](const auto& entry) {
    return entry.first <= 19 || entry.first == 255;
  });
  if (!training_ids) {
    const bool raw = knownShare(counts, shippedLabelSet("semantic_kitti")) >= kKnownShare;
    return raw ? std::optional<std::string>("semantic_kitti") : std::nullopt;
  }
  if (counts.count(19) > 0) return "semantic_kitti_train_1";
  if (counts.count(255) > 0) return "semantic_kitti_train_0";
  // Road, sidewalk, building and vegetation in either counting.
  const auto points_of = [&](std::initializer_list<std::uint32_t> ids) {
    return shareOf(counts, [&](std::uint32_t id) {
      return std::find(ids.begin(), ids.end(), id) != ids.end();
    });
  };
  return points_of({9, 11, 13, 15}) >= points_of({8, 10, 12, 14}) ? "semantic_kitti_train_1"
                                                                  : "semantic_kitti_train_0";
}

// ---- NYU Depth, as of ScanNet

/// Ids up to 40, many of them, whose floor is that of a room and whose walls rise from it.
bool areNyu40(const Impression& seen, const LabelSet& nyu) {
  constexpr std::uint32_t kWall = 1, kLast = 40;
  constexpr std::size_t kFewestIds = 6;
  constexpr double kWidestRoom_m = 6, kRise_m = 0.4;
  if (seen.counts.size() < kFewestIds || seen.counts.rbegin()->first > kLast ||
      seen.counts.rbegin()->first <= kLast / 2 || !groundFits(seen, nyu).value_or(false))
    return false;
  return std::all_of(seen.frames.begin(), seen.frames.end(), [&](const auto& points) {
    const auto lie = lieOf(points, nyu);
    if (!lie) return true;
    double walls = 0, squares = 0;
    for (const Point& p : points) {
      if (p.label != kWall) continue;
      walls += 1;
      squares += std::pow((p.getVector3fMap().cast<double>() - lie->mean).dot(lie->normal), 2);
    }
    return lie->width_m < kWidestRoom_m && walls > 0 && squares > kRise_m * kRise_m * walls;
  });
}

void takeShipped(RecordingListing& listing, const std::string& set) {
  listing.labels = shippedLabelSet(set);
  listing.notes.push_back("its files name no classes; by their ids they are those of " + set +
                          "; --labels names others");
}

/// True if the ids are among those of the offered set, and what it calls ground lies as ground
/// does. A set without names says nothing of the ground, nor does one of things.
bool offeredFits(const Impression& seen, const InputOptions& options) {
  if (!options.map_labels || knownShare(seen.counts, *options.map_labels) < kKnownShare)
    return false;
  const auto& classes = options.map_labels->classes();
  const bool has_ground = std::any_of(classes.begin(), classes.end(), [&](const auto& entry) {
    return isGround(options.map_labels->kind(entry.first));
  });
  return options.map_labels->isGeneric() || !has_ground ||
         groundFits(seen, *options.map_labels).value_or(false);
}

void takeOffered(RecordingListing& listing, const InputOptions& options) {
  listing.labels = *options.map_labels;
  listing.notes.push_back("names no classes; its ids are taken as those of the map" +
                          std::string(listing.labels.isGeneric() ? ", which names none either"
                                                                 : "; --labels names others"));
}

void guessLabels(RecordingListing& listing, const Impression& seen, const InputOptions& options) {
  if (offeredFits(seen, options)) return takeOffered(listing, options);
  if (areRawSemanticKitti(seen, shippedLabelSet("semantic_kitti")))
    return takeShipped(listing, "semantic_kitti");
  if (areNyu40(seen, shippedLabelSet("nyu40"))) return takeShipped(listing, "nyu40");
  std::vector<std::uint32_t> ids;
  for (const auto& [id, points] : seen.counts) ids.push_back(id);
  listing.labels = genericLabelSet(ids);
}

}  // namespace

LabelCounts countLabels(const RecordingListing& listing, std::size_t max_frames) {
  return lookAt(listing, max_frames).counts;
}

void nameClasses(RecordingListing& listing, const InputOptions& options, const std::string& folder,
                 const std::optional<LabelSet>& own) {
  if (const auto named = namedLabels(options, folder, own))
    listing.labels = *named;
  else
    guessLabels(listing, lookAt(listing, kFramesToLookAt), options);
}

void guessSemanticKittiLabels(RecordingListing& listing, const InputOptions& options) {
  const Impression seen = lookAt(listing, kScansToLookAt);
  const bool of_another_set =
      options.map_labels && options.map_labels->name().rfind("semantic_kitti", 0) != 0;
  const auto set = semanticKittiSet(seen.counts);
  if (!set || (of_another_set && offeredFits(seen, options)))
    guessLabels(listing, seen, options);
  else
    takeShipped(listing, *set);
}

}  // namespace xview::io
