// SPDX-License-Identifier: BSD-3-Clause
#include "map/sample_map.h"

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "base/random.h"

namespace xview::test {
namespace {

ClassInfo classInfo(std::uint32_t id, const char* name, Role role, Kind kind, bool guessed) {
  ClassInfo info;
  info.id = id;
  info.name = name;
  info.color = {static_cast<std::uint8_t>(10 * id), 255, 7};
  info.role = role;
  info.kind = kind;
  info.guessed = guessed;
  return info;
}

LabelSet sampleLabels() {
  LabelSet labels("street classes");
  labels.add(classInfo(0, "void", Role::ignored, Kind::none, true));
  labels.add(classInfo(3, "pole", Role::object, Kind::pole, false));
  labels.add(classInfo(7, "Straße 'eins'", Role::surface, Kind::road, false));
  labels.add(classInfo(4000000000u, "car", Role::dynamic, Kind::vehicle, true));
  return labels;
}

SemanticGraph sampleGraph(Random& random) {
  SemanticGraph graph;
  for (std::uint32_t i = 0; i < 200; ++i) {
    Vertex v;
    v.label = i % 2 ? 3 : 4000000000u;
    v.instance = i % 5 ? 0 : 4294967295u - i;
    v.position = {random.normal() * 1e6, random.uniform(-1, 1) / 3, random.normal()};
    v.extent = {random.uniform(), random.uniform(), random.uniform()};
    v.sigma_m = random.uniform();
    v.observations = random.below(1000);
    v.points = random.below(100000);
    v.first_frame = -static_cast<std::int64_t>(i);
    v.last_frame = std::int64_t{1} << 40;
    graph.vertices.push_back(v);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (int i = 0; i < 600; ++i)
    edges.emplace_back(random.below(199), random.below(199));  // 199 stays alone
  graph.setEdges(edges);
  return graph;
}

BevGrid sampleBev(Random& random) {
  BevGrid bev;
  bev.origin_x = 1.0 / 3;
  bev.origin_y = -4649776.225;
  bev.origin_z = 500.5;
  for (std::int32_t y = -70; y < 70; ++y) {
    for (std::int32_t x = -80; x < 30; ++x) {
      if (random.below(3) > 0) {
        bev.known.push_back({x, y, static_cast<float>(random.normal()), random.below(2) == 0});
      }
    }
  }
  for (auto& samples : bev.samples) {
    for (int i = 0; i < 100; ++i) {
      samples.push_back({static_cast<float>(random.uniform(-60, 40)),
                         static_cast<float>(random.uniform(-60, 60)),
                         static_cast<float>(random.normal())});
    }
  }
  return bev;
}

LabelledCloud sampleCloud(Random& random) {
  LabelledCloud cloud;
  cloud.origin = {500000.125, 4649776.225, 1.0 / 3};
  for (int i = 0; i < 3000; ++i) {
    Point p;
    p.x = static_cast<float>(random.uniform(-100, 100));
    p.y = static_cast<float>(random.uniform(-100, 100));
    p.z = static_cast<float>(random.uniform(-70, 10));
    p.label = random.below(3) == 0 ? 4000000000u : 7;
    p.instance = random.below(4) == 0 ? random.below(4000000000u) : 0;
    cloud.points.push_back(p);
  }
  return cloud;
}

void addSampleKeyframe(std::int64_t number, Random& random, map::SemanticMap& map) {
  const double stamp_s = 1.6e9 + random.uniform();
  map.addKeyframe(
      poseFromYaw({random.normal(), random.normal(), random.normal()}, random.uniform(-3, 3)),
      number, stamp_s, static_cast<std::uint32_t>(number % 2));
}

std::vector<float> keyOf(const BevSample& s) { return {s.x, s.y, s.z}; }

}  // namespace

map::SemanticMap sampleMap(std::uint64_t seed) {
  Random random(seed);
  map::SemanticMap map;
  map.labels = sampleLabels();
  map.graph = sampleGraph(random);
  map.bev = sampleBev(random);
  map.cloud = sampleCloud(random);
  for (std::int64_t i = 0; i < 20; ++i) addSampleKeyframe(i, random, map);
  map.sources = {"town/forward", "with 'quotes'; and spaces"};
  map.options_yaml = "edges:\n  radius_m: 25\n";
  map.wrong_places = {
      {0.1, 1. / 3, 7.25, 1e-3}, {1e-7, {}, {}, 12.}, {{}, 1, -3., {}}, {{}, {}, {}, {}}};
  map.own_stretches = {{15, 0.25}, {30.5, 0.999999}, {1e-3, 1}};
  return map;
}

BevGrid streetBev(double length_m, std::uint64_t seed) {
  Random random(seed);
  BevGrid bev;
  const auto columns = static_cast<std::int32_t>(length_m / bev.cell_m),
             rows = static_cast<std::int32_t>(80 / bev.cell_m);
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < columns; ++x) {
      const auto z = static_cast<float>(2 * std::sin(x * 0.005) + 0.02 * random.normal());
      bev.known.push_back({x, y, z, random.below(5) > 0});
      const double across_m = std::abs(y - rows / 2) * bev.cell_m;
      const BevChannel ground = across_m < 5   ? BevChannel::road
                                : across_m < 8 ? BevChannel::sidewalk
                                               : BevChannel::terrain;
      const auto at = [&](double spread) {
        return BevSample{
            static_cast<float>((x + 0.5 + spread * random.uniform(-0.5, 0.5)) * bev.cell_m),
            static_cast<float>((y + 0.5 + spread * random.uniform(-0.5, 0.5)) * bev.cell_m), z};
      };
      bev[ground].push_back(at(0));
      if (random.below(40) == 0) bev[BevChannel::lane_marking].push_back(at(0));
      if (across_m == 5) bev[BevChannel::border_road_sidewalk].push_back(at(0));
      if (across_m == 8) bev[BevChannel::border_sidewalk_terrain].push_back(at(0));
      if (across_m == 15 && random.below(4) > 0) {
        for (const BevChannel c : {BevChannel::building, BevChannel::wall_foot,
                                   BevChannel::obstacle_low, BevChannel::obstacle_high}) {
          bev[c].push_back(at(1));
        }
      }
      for (const BevChannel c : {BevChannel::fence, BevChannel::low_vegetation, BevChannel::canopy,
                                 BevChannel::vehicle_surface, BevChannel::other_surface,
                                 BevChannel::obstacle_low, BevChannel::obstacle_high}) {
        if (random.below(25) == 0) bev[c].push_back(at(1));
      }
      for (std::size_t c = static_cast<std::size_t>(BevChannel::pole); c < kBevChannels; ++c) {
        if (random.below(4000) == 0) bev.samples[c].push_back(at(1));
      }
    }
  }
  return bev;
}

bool isSame(const LabelSet& a, const LabelSet& b) {
  return a.name() == b.name() && a.classes().size() == b.classes().size() &&
         std::equal(a.classes().begin(), a.classes().end(), b.classes().begin(),
                    [](const auto& i, const auto& j) {
                      const ClassInfo &p = i.second, &q = j.second;
                      return i.first == j.first && p.id == q.id && p.name == q.name &&
                             p.color == q.color && p.role == q.role && p.kind == q.kind &&
                             p.guessed == q.guessed;
                    });
}

bool isSame(const SemanticGraph& a, const SemanticGraph& b) {
  return a.neighbours == b.neighbours && a.size() == b.size() &&
         std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(),
                    [](const Vertex& p, const Vertex& q) {
                      return p.label == q.label && p.instance == q.instance &&
                             p.position == q.position && p.extent == q.extent &&
                             p.sigma_m == q.sigma_m && p.observations == q.observations &&
                             p.points == q.points && p.first_frame == q.first_frame &&
                             p.last_frame == q.last_frame;
                    });
}

bool isSame(const BevGrid& a, const BevGrid& b) {
  if (a.cell_m != b.cell_m || a.origin_x != b.origin_x || a.origin_y != b.origin_y ||
      a.origin_z != b.origin_z)
    return false;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (!std::equal(a.samples[c].begin(), a.samples[c].end(), b.samples[c].begin(),
                    b.samples[c].end(),
                    [](const BevSample& p, const BevSample& q) { return keyOf(p) == keyOf(q); })) {
      return false;
    }
  }
  return std::equal(a.known.begin(), a.known.end(), b.known.begin(), b.known.end(),
                    [](const GroundCell& p, const GroundCell& q) {
                      return p.x == q.x && p.y == q.y && p.z == q.z && p.measured == q.measured;
                    });
}

bool isSame(const LabelledCloud& a, const LabelledCloud& b) {
  return a.origin == b.origin && std::equal(a.points.begin(), a.points.end(), b.points.begin(),
                                            b.points.end(), [](const Point& p, const Point& q) {
                                              return p.x == q.x && p.y == q.y && p.z == q.z &&
                                                     p.label == q.label && p.instance == q.instance;
                                            });
}

bool isSame(const map::SemanticMap& a, const map::SemanticMap& b) {
  return isSame(a.labels, b.labels) && isSame(a.graph, b.graph) && isSame(a.bev, b.bev) &&
         isSame(a.cloud, b.cloud) && a.sources == b.sources && a.options_yaml == b.options_yaml &&
         a.frames == b.frames && a.stamps_s == b.stamps_s && a.source_of_pose == b.source_of_pose &&
         std::equal(a.poses.begin(), a.poses.end(), b.poses.begin(), b.poses.end(),
                    [](const Eigen::Isometry3d& p, const Eigen::Isometry3d& q) {
                      return p.matrix() == q.matrix();
                    });
}

}  // namespace xview::test
