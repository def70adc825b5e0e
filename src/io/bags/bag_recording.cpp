// SPDX-License-Identifier: BSD-3-Clause
// Recordings of robots: which topics of a bag are read, and where the sensor was at each message.
#include "io/bag_files.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "base/user_text.h"
#include "io/layouts.h"
#include "motion.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

// ---- which topics are read

struct Choice {
  const Topic* measurements = nullptr;
  const Topic* camera = nullptr;    ///< the camera info, if the measurements are images
  const Topic* odometry = nullptr;  ///< or TF
};

/// The one of that name. Throws UsageError if there is none, or one of another kind.
template <class Fits>
const Topic* topicNamed(const Bag& bag, const char* flag, const std::string& name, Fits fits,
                        const char* expected) {
  std::vector<std::string> names;
  bool is_other = false;
  for (const Topic& topic : bag.topics()) {
    if (fits(topic) && (topic.topic == name || topic.topic == "/" + name)) return &topic;
    is_other |= topic.topic == name;
    if (fits(topic)) names.push_back(printable(topic.topic));
  }
  throw UsageError(fmt::format("{} {}: {}{}{}", flag, name,
                               is_other ? "is no topic with " : "no topic with ", expected,
                               names.empty() ? "; there is none" : knownWordsHint(name, names)));
}

/// The topic of the largest value, the first of equals; none if no value is above 0. They are asked
/// for in the order of their first messages, so that no chunk is unpacked twice.
template <class Value>
const Topic* largest(const Bag& bag, Value value) {
  std::vector<const Topic*> topics;
  for (const Topic& topic : bag.topics()) {
    if (!topic.messages.empty()) topics.push_back(&topic);
  }
  std::sort(topics.begin(), topics.end(), [](const Topic* a, const Topic* b) {
    return isBefore(a->messages.front(), b->messages.front());
  });
  const Topic* best = nullptr;
  double most = 0;
  for (const Topic* topic : topics) {
    const double here = value(*topic);
    if (here > most || (best && here == most && topic < best)) best = topic, most = here;
  }
  return best;
}

double pointsOf(const Bag& bag, const Topic& topic) {
  return bag.read(topic, topic.messages.front(), kWhole, [&](Cursor& cursor) {
    readHeader(cursor);
    return static_cast<double>(topic.count) *
           (1 + static_cast<double>(readCloudMessage(cursor, topic.content).points.rows));
  });
}

bool isDepth(const Bag& bag, const Topic& topic) {
  return isImage(topic.content) && !topic.messages.empty() &&
         bag.read(topic, topic.messages.front(), kHeadBytes, [&](Cursor& cursor) {
           readHeader(cursor);
           return isDepthEncoding(readEncoding(cursor, topic.content), topic.content);
         });
}

bool isCameraInfo(const Topic& topic) {
  return topic.content == Content::camera_info && !topic.messages.empty();
}

/// That in the same folder of names, as far as there is one.
const Topic* cameraOf(const Bag& bag, const Topic& images) {
  return largest(bag, [&](const Topic& topic) {
    if (!isCameraInfo(topic)) return 0.0;
    const auto end = std::mismatch(topic.topic.begin(), topic.topic.end(), images.topic.begin(),
                                   images.topic.end());
    return 1.0 + static_cast<double>(end.first - topic.topic.begin());
  });
}

/// Odometry before poses before transforms; of one kind that with the most messages.
double preference(const Topic& topic) {
  if (!isMotion(topic.content) || topic.isStatic()) return 0;
  return 1e15 * (static_cast<int>(Content::transforms) + 1 - static_cast<int>(topic.content)) +
         static_cast<double>(topic.count);
}

Choice chooseTopics(const Bag& bag, const InputOptions& options) {
  Choice choice;
  if (!options.topic.empty()) {
    choice.measurements = topicNamed(
        bag, "--topic", options.topic,
        [&](const Topic& topic) { return isCloud(topic.content) || isDepth(bag, topic); },
        "clouds or depth images");
  } else {
    choice.measurements = largest(
        bag, [&](const Topic& topic) { return isCloud(topic.content) ? pointsOf(bag, topic) : 0; });
    const bool has_camera = std::any_of(bag.topics().begin(), bag.topics().end(), isCameraInfo);
    if (!choice.measurements && has_camera)
      choice.measurements = largest(bag, [&](const Topic& topic) {
        return isDepth(bag, topic) ? static_cast<double>(topic.count) : 0;
      });
  }
  if (choice.measurements && isImage(choice.measurements->content))
    choice.camera = cameraOf(bag, *choice.measurements);
  choice.odometry =
      options.odometry.empty()
          ? largest(bag, preference)
          : topicNamed(
                bag, "--odometry", options.odometry,
                [](const Topic& topic) { return preference(topic) > 0; }, "poses or transforms");
  return choice;
}

// ---- frames

/// Frames with poses; without any odometry all of them, of which only one can be read at a time.
void listFramesOf(const Bag& bag, const Motion& motion, const Choice& choice,
                  const InputOptions& options, RecordingListing& listing) {
  const auto& measured = motion.measured();
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto pose = motion.at(measured[i].stamp_s);
    if (!pose) continue;
    listing.frames.push_back(
        {static_cast<std::int64_t>(i), measured[i].stamp_s, *pose, bag.path(), "", ""});
  }
  const std::size_t left_out = measured.size() - listing.frames.size();
  if (listing.frames.empty())
    throw Error(bag.path(),
                fmt::format("no pose of {} within {} s around any of the {} messages of {}, {:.3f} "
                            "to {:.3f} s; the poses are of {}; another --odometry may do",
                            printable(choice.odometry->topic), kLongestGap_s, measured.size(),
                            printable(choice.measurements->topic), measured.front().stamp_s,
                            measured.back().stamp_s, motion.span()));
  if (left_out > 0)
    listing.notes.push_back(fmt::format(
        "{} of {} messages of {} are left out: no poses around "
        "them, or {} s and more apart",
        left_out, measured.size(), printable(choice.measurements->topic), kLongestGap_s));
  if (motion.isKnown()) return;
  const std::size_t end = std::min(options.frames.end.value_or(measured.size()), measured.size());
  if (options.frames.begin + options.frames.step < end)
    throw Error(bag.path(),
                fmt::format("{} frames, but no odometry (nav_msgs/Odometry, geometry_msgs/"
                            "PoseStamped or TF) with a pose of each; choose one frame: --frames "
                            "{}:{}",
                            measured.size(), options.frames.begin, options.frames.begin + 1));
}

/// Points that were brought to the frame of the odometry, as the sensor saw them.
void takeBack(const Eigen::Isometry3d& T_odom_sensor, LabelledCloud& cloud) {
  const Eigen::Isometry3d T_sensor_odom = T_odom_sensor.inverse();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.points[i].getVector3fMap() = (T_sensor_odom * cloud.position(i)).cast<float>();
  cloud.origin.setZero();
}

/// What its first cloud has.
bool hasLabels(const Bag& bag, const Topic& clouds, const CloudFields& fields) {
  return bag.read(clouds, clouds.messages.front(), kWhole, [&](Cursor& cursor) {
    readHeader(cursor);
    const CloudMessage cloud = readCloudMessage(cursor, clouds.content);
    return findIdColumns(cloud.points, fields, cursor.file()).label.has_value();
  });
}

Camera readCameraOf(const Bag& bag, const Choice& choice) {
  if (!choice.camera)
    throw Error(bag.path(), "no camera info (sensor_msgs/CameraInfo) for the images of " +
                                printable(choice.measurements->topic));
  return bag.read(*choice.camera, choice.camera->messages.front(), kWhole, [](Cursor& cursor) {
    readHeader(cursor);
    return readCameraInfo(cursor);
  });
}

}  // namespace

bool isBag(const std::string& path) {
  std::error_code failed;
  if (!fs::is_directory(path, failed)) return isBagFile(path);
  const bool is_whole = fs::exists(fs::path(path) / "metadata.yaml");
  std::set<std::string> names;  // of parts, without their numbers
  for (const auto& entry : fs::directory_iterator(path, failed)) {
    if (!isBagFile(entry.path())) continue;
    const std::string stem = entry.path().stem().string();
    const std::size_t end = stem.find_last_not_of("0123456789") + 1;  // of the name, with its "_"
    constexpr std::size_t kDigits = 4;                                // more are a date
    const bool is_part =
        end > 1 && end < stem.size() && stem.size() <= end + kDigits && stem[end - 1] == '_';
    if (!is_whole && !is_part) return false;
    names.insert(stem.substr(0, end));
  }
  return is_whole ? !names.empty() : names.size() == 1;
}

std::vector<BagTopic> bagTopics(const std::string& path, const InputOptions& options) {
  const Bag bag(path);
  const Choice choice = chooseTopics(bag, options);
  std::vector<BagTopic> topics;
  for (const Topic& topic : bag.topics()) {
    BagTopic known{topic.topic, topic.type, topic.count, 0, ""};
    if (topic.count > 0)
      known.duration_s =
          1e-9 * (static_cast<double>(topic.last_ns) - static_cast<double>(topic.first_ns));
    if (&topic == choice.measurements) known.taken_as = choice.camera ? "depth" : "clouds";
    if (&topic == choice.camera) known.taken_as = "camera";
    if (&topic == choice.odometry) known.taken_as = "poses";
    topics.push_back(known);
  }
  return topics;
}

std::optional<Eigen::Isometry3d> mountingIn(const std::string& path, const InputOptions& options) {
  const Bag bag(path);
  const Choice choice = chooseTopics(bag, options);
  if (!choice.measurements || !choice.odometry) return std::nullopt;
  return Motion(bag, *choice.measurements, choice.odometry, false).onBase();
}

RecordingListing listBag(const std::string& path, const InputOptions& options) {
  const auto bag = std::make_shared<const Bag>(path);
  const Choice choice = chooseTopics(*bag, options);
  RecordingListing listing;
  listing.notes = bag->notes();
  if (!choice.measurements)
    throw Error(path, fmt::format("none of its {} topics has clouds or depth images with a camera "
                                  "info that can be read{}",
                                  bag->topics().size(),
                                  listing.notes.empty() ? "" : "; it " + listing.notes.front()));
  std::optional<Motion> by_stamps, by_recorder;
  by_stamps.emplace(*bag, *choice.measurements, choice.odometry, false);
  if (!by_stamps->meets()) by_recorder.emplace(*bag, *choice.measurements, choice.odometry, true);
  const bool other_clock = by_recorder && by_recorder->meets();
  const Motion& motion = other_clock ? *by_recorder : *by_stamps;
  if (other_clock)
    listing.notes.push_back(fmt::format(
        "the stamps of {} ({:.3f} to {:.3f} s) are of another clock than those of {} ({}): all are "
        "taken at the time of the recorder",
        printable(choice.measurements->topic), by_stamps->measured().front().stamp_s,
        by_stamps->measured().back().stamp_s, printable(choice.odometry->topic),
        by_stamps->span()));
  listing.notes.insert(listing.notes.end(), motion.notes().begin(), motion.notes().end());
  listFramesOf(*bag, motion, choice, options, listing);
  std::vector<MessageAt> messages;
  for (const Measured& one : motion.measured()) messages.push_back(*one.message);
  const Topic* topic = choice.measurements;
  if (isImage(topic->content)) {
    listing.read = [bag, topic, messages, camera = readCameraOf(*bag, choice)](
                       const ListedFrame& listed, Frame& frame) {
      frame.camera = camera;
      bag->read(*topic, messages.at(listed.number), kWhole, [&](Cursor& cursor) {
        readHeader(cursor);
        frame.depth = readDepthMessage(cursor, topic->content, camera);
      });
    };
    return listing;
  }
  listing.sensor = Sensor::lidar;
  const CloudFields fields{options.label_field, options.instance_field};
  listing.read = [bag, topic, messages, fields, is_registered = motion.isRegistered()](
                     const ListedFrame& listed, Frame& frame) {
    bag->read(*topic, messages.at(listed.number), kWhole, [&](Cursor& cursor) {
      readHeader(cursor);
      const CloudMessage cloud = readCloudMessage(cursor, topic->content);
      frame.cloud = readStoredCloud(cursor.file(), cloud.points, cloud.rows, fields);
    });
    if (is_registered) takeBack(listed.T_odom_sensor, frame.cloud);
  };
  if (hasLabels(*bag, *topic, fields))
    nameClasses(listing, options, fs::absolute(path).parent_path().string());
  return listing;
}

}  // namespace xview::io
