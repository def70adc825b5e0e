// SPDX-License-Identifier: BSD-3-Clause
#include "bag.h"

#include <fmt/core.h>

#include <map>

#include "io/yaml_file.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> filesOf(const std::string& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<std::string> files;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(path, failed)) {
    if (isBagFile(entry.path())) files.push_back(entry.path().string());
  }
  // drive_2 before drive_10
  std::sort(files.begin(), files.end(), [](const std::string& a, const std::string& b) {
    return std::make_pair(a.size(), a) < std::make_pair(b.size(), b);
  });
  if (files.empty()) throw Error(path, "no .mcap, .db3 or .bag in it");
  return files;
}

/// Parts that metadata.yaml lists and that cannot be read: they are missing, or compressed as
/// files.
std::vector<std::string> missingParts(const fs::path& folder) {
  std::vector<std::string> notes;
  try {
    const YamlFile metadata = YamlFile::read((folder / "metadata.yaml").string());
    for (const YAML::Node& part :
         metadata.root()["rosbag2_bagfile_information"]["relative_file_paths"]) {
      const fs::path name = fs::path(metadata.text(part, "a part")).filename();
      const bool is_packed = name.extension() == ".zstd" || name.extension() == ".zst";
      if (fs::exists(folder / (is_packed ? name.stem() : name))) continue;
      notes.push_back(
          is_packed && fs::exists(folder / name)
              ? fmt::format("is read without {}, which is compressed; unpack it: unzstd {}",
                            inQuotes(name.string()), (folder / name).string())
              : fmt::format("is read without {}, which metadata.yaml lists and which is not there",
                            inQuotes(name.string())));
    }
  } catch (const std::exception&) {
    return notes;  // the parts that are there speak for themselves
  }
  return notes;
}

}  // namespace

bool Topic::isStatic() const {
  return content == Content::transforms && topic.size() >= 9 &&
         topic.compare(topic.size() - 9, 9, "tf_static") == 0;
}

bool isBagFile(const std::filesystem::path& path) {
  const std::string ending = endingOf(path.string());
  return ending == ".mcap" || ending == ".db3" || ending == ".bag" ||
         (ending == ".active" && endingOf(path.stem().string()) == ".bag");
}

Bag::Bag(const std::string& path) : path_(path) {
  if (fs::is_directory(path) && !fs::exists(fs::path(path) / "metadata.yaml"))
    notes_.push_back("has no metadata.yaml; its parts are read in the order of their numbers");
  else if (fs::is_directory(path))
    notes_ = missingParts(path);
  std::map<std::pair<std::string, std::string>, Topic> topics;
  for (const std::string& file : filesOf(path)) {
    try {
      files_.push_back(endingOf(file) == ".db3" ? openDatabase(file) : openLog(file));
    } catch (const std::bad_alloc&) {
      if (BudgetOfThread::current()) throw;
      throw Error(file, "needs more memory than there is to list its messages");
    } catch (const Error& problem) {  // of a folder the others are read
      if (file == path) throw;
      notes_.push_back("is read without " + std::string(problem.what()));
      continue;
    }
    for (const Channel& channel : files_.back()->takeChannels())
      add(channel, topics[{channel.topic, channel.type}]);
    for (const std::string& note : files_.back()->notes())
      notes_.push_back((file == path ? "" : fs::path(file).filename().string() + " ") + note);
  }
  for (auto& [name, topic] : topics) topics_.push_back(std::move(topic));
  seen_bytes_.resize(files_.size());
}

/// Messages may lie upon one another in a file that lies; what all of them are is bounded, too.
std::string Bag::bytesOf(const BagFile& file, const MessageAt& message,
                         std::uint64_t most_bytes) const {
  std::string bytes = file.read(message, most_bytes);
  if (isPackedMessage(bytes))
    bytes = unpackedMessage(
        file.file(), file.read(message, most_bytes == kWhole ? kWhole : kPackedHead), most_bytes);
  if (bytes.size() <= kHeadBytes) return bytes;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!seen_.insert({message.file, message.chunk, message.position}).second) return bytes;
  std::uint64_t& total = seen_bytes_.at(message.file);
  total += bytes.size();
  if (total > mostUnpacked(file.file()))
    file.file().fail("its messages have more than {} bytes, expected {} at most of a file of {}",
                     total, mostUnpacked(file.file()), file.file().size());
  return bytes;
}

void Bag::add(const Channel& channel, Topic& topic) const {
  topic.topic = channel.topic;
  topic.type = channel.type;
  topic.serialization = channel.serialization;
  topic.content = contentOf(channel.type);
  topic.count += channel.count;
  topic.first_ns = std::min(topic.first_ns, channel.first_ns);
  topic.last_ns = std::max(topic.last_ns, channel.last_ns);
  for (MessageAt message : channel.messages) {
    message.file = static_cast<std::uint32_t>(files_.size() - 1);
    topic.messages.push_back(message);
  }
}

std::vector<TopicAndMessage> inFileOrder(const std::vector<const Topic*>& topics) {
  std::vector<TopicAndMessage> messages;
  for (const Topic* topic : topics) {
    for (const MessageAt& message : topic->messages) messages.push_back({topic, &message});
  }
  std::sort(messages.begin(), messages.end(),
            [](const auto& a, const auto& b) { return isBefore(*a.message, *b.message); });
  return messages;
}

}  // namespace xview::io
