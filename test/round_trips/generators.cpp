// SPDX-License-Identifier: BSD-3-Clause
#include "round_trips/generators.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "support/test_data.h"

namespace xview::test {
namespace {

namespace gen = rc::gen;

/// The same at every size of a case; small ones shrink best.
template <class T>
rc::Gen<T> upTo(T largest) {
  return gen::resize(rc::kNominalSize, gen::inRange<T>(0, largest));
}

rc::Gen<std::string> textOf(const std::vector<std::string>& letters) {
  return gen::map(gen::container<std::vector<std::string>>(gen::elementOf(letters)),
                  [](const std::vector<std::string>& parts) {
                    std::string text;
                    for (const std::string& part : parts) text += part;
                    return text;
                  });
}

template <class T>
T pick(const rc::Gen<T>& generator) {
  return *generator;
}

float anyFloat(double largest) { return static_cast<float>(pick(anyNumber(largest))); }

std::uint32_t anyCount() { return *gen::arbitrary<std::uint32_t>(); }

Eigen::Vector3d anyVector(double largest) {
  const double x = *anyNumber(largest), y = *anyNumber(largest), z = *anyNumber(largest);
  return {x, y, z};
}

Vertex pickVertex() {
  Vertex v;
  v.label = anyCount();
  v.instance = anyCount();
  v.position = anyVector(1e6);
  v.extent = anyVector(50).cwiseAbs();
  v.sigma_m = *anyLength(5);
  v.observations = anyCount();
  v.points = anyCount();
  v.first_frame = *gen::arbitrary<std::int32_t>();
  v.last_frame = *gen::arbitrary<std::int32_t>();
  return v;
}

Point pickPoint() {
  Point p(anyFloat(50), anyFloat(50), anyFloat(50), anyCount());
  p.instance = *gen::oneOf(gen::just(0U), gen::arbitrary<std::uint32_t>());
  p.sigma = static_cast<float>(*gen::oneOf(gen::just(0.0), anyLength(1)));
  return p;
}

BevGrid pickPlan() {
  BevGrid bev;
  bev.origin_x = *anyNumber(1e6);
  bev.origin_y = *anyNumber(1e6);
  bev.origin_z = *anyNumber(1e3);
  bev.aerial = *gen::arbitrary<bool>();
  for (std::size_t i = *upTo<std::size_t>(12); i > 0; --i)
    bev.samples[*upTo(kBevChannels)].push_back({anyFloat(60), anyFloat(60), anyFloat(9)});
  for (std::int32_t x = *upTo(12); x > 0; --x)
    bev.known.push_back({-x, x % 3, anyFloat(9), *gen::arbitrary<bool>()});
  std::sort(bev.known.begin(), bev.known.end(), InRowOrder());
  return bev;
}

std::optional<double> pickShare() {
  return *gen::arbitrary<bool>() ? std::optional(*anyNumber(1)) : std::nullopt;
}

}  // namespace

std::string scratch(const std::string& name) {
  static const TemporaryFolder folder = [] {
    if (access("/dev/shm", W_OK) == 0) setenv("TMPDIR", "/dev/shm", 0);
    return TemporaryFolder();
  }();
  return folder / name;
}

rc::Gen<double> anyLength(double largest) {
  constexpr std::int64_t kUnits = std::int64_t{1} << 52;
  return gen::map(upTo(kUnits), [largest](std::int64_t n) {
    return largest * (static_cast<double>(n) / static_cast<double>(kUnits));
  });
}

rc::Gen<double> anyNumber(double largest) {
  return gen::map(gen::pair(anyLength(largest), gen::arbitrary<bool>()),
                  [](const auto& number) { return number.second ? -number.first : number.first; });
}

rc::Gen<std::string> anyName() {
  const auto word = gen::suchThat(textOf({"a", "Z", "7", "_", "\"", "'", ":", "#", "{", ",", "\\",
                                          "%", "=", "<", "ß", "名", "-"}),
                                  [](const std::string& text) { return !text.empty(); });
  return gen::map(gen::pair(word, gen::container<std::vector<std::string>>(word)),
                  [](const auto& words) {
                    std::string name = words.first;
                    for (std::size_t i = 0; i < words.second.size() && i < 3; ++i)
                      name += " " + words.second[i];
                    return name;
                  });
}

rc::Gen<std::string> anyText() {
  return textOf({"a",  " ", "\n", "\r", "\t", "\x1b", "\x7f", "\"",
                 "\\", "'", ":",  "# ", "- ", "ß",    "名",   "\xF0\x9F\x9A\x97",
                 "<",  "&", "%",  "{",  "}",  "null", "~",    "1"});
}

rc::Gen<Eigen::Isometry3d> anyPose() {
  return gen::exec([] {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = anyVector(1000);
    const Eigen::Vector3d turn = anyVector(M_PI);
    if (turn.norm() > 0)
      T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    return T;
  });
}

rc::Gen<LabelSet> anyLabels(std::uint32_t largest_id) {
  return gen::exec([largest_id] {
    LabelSet labels(*anyName());
    for (int i = *upTo(5); i >= 0; --i) {
      ClassInfo info;
      info.id = *gen::oneOf(
          upTo<std::uint32_t>(40),
          gen::map(upTo<std::uint32_t>(largest_id), [=](auto n) { return largest_id - n; }));
      info.name = *anyName();
      for (std::uint8_t& channel : info.color) channel = *gen::arbitrary<std::uint8_t>();
      info.role = static_cast<Role>(*upTo(static_cast<int>(Role::ignored) + 1));
      info.kind = static_cast<Kind>(*upTo(static_cast<int>(Kind::none) + 1));
      labels.add(info);
    }
    return labels;
  });
}

rc::Gen<SemanticGraph> anyGraph() {
  return gen::exec([] {
    SemanticGraph graph;
    for (int i = *upTo(8); i >= 0; --i) graph.vertices.push_back(pickVertex());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    const auto end = static_cast<std::uint32_t>(graph.size());
    for (int i = *upTo(12); i > 0; --i) edges.emplace_back(*upTo(end), *upTo(end));
    graph.setEdges(edges);
    graph.space = *gen::element(GraphSpace::cloud, GraphSpace::image);
    return graph;
  });
}

rc::Gen<LabelledCloud> anyCloud(bool far) {
  return gen::exec([far] {
    LabelledCloud cloud;
    if (far) cloud.origin = anyVector(1e6);
    for (int i = *upTo(20); i >= 0; --i) cloud.points.push_back(pickPoint());
    return cloud;
  });
}

rc::Gen<map::SemanticMap> anyMap() {
  return gen::exec([] {
    map::SemanticMap map;
    map.labels = *anyLabels();
    map.graph = *anyGraph();
    map.bev = pickPlan();
    map.cloud = *anyCloud(true);
    map.options_yaml = *anyText();
    for (int i = *upTo(3); i >= 0; --i) map.sources.push_back(*anyText());
    for (int i = *upTo(5); i >= 0; --i)
      map.addKeyframe(*anyPose(), *gen::arbitrary<std::int64_t>(), *anyNumber(2e9),
                      *upTo(static_cast<std::uint32_t>(map.sources.size())));
    for (int i = *upTo(3); i > 0; --i) map.wrong_places.push_back({pickShare(), pickShare(), pickShare(), pickShare()});
    for (int i = *upTo(3); i > 0; --i)
      map.own_stretches.push_back({*anyLength(100), *anyLength(1)});
    return map;
  });
}

}  // namespace xview::test
