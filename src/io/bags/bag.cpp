// SPDX-License-Identifier: BSD-3-Clause
#include "bag.h"

#include <map>
#include <tuple>

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
  std::sort(files.begin(), files.end());
  if (files.empty()) throw Error(path, "no .mcap, .db3 or .bag in it");
  return files;
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
  std::map<std::pair<std::string, std::string>, Topic> topics;
  for (const std::string& file : filesOf(path)) {
    try {
      files_.push_back(endingOf(file) == ".db3" ? openDatabase(file) : openLog(file));
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
  const auto place = [](const MessageAt& m) { return std::tuple(m.file, m.chunk, m.position); };
  std::sort(messages.begin(), messages.end(),
            [&](const auto& a, const auto& b) { return place(*a.message) < place(*b.message); });
  return messages;
}

}  // namespace xview::io
