// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "base/label_match.h"
#include "base/pose.h"
#include "base/user_text.h"
#include "compare/self_similarity.h"
#include "consistency_checks.h"
#include "inputs.h"
#include "io/bag_files.h"
#include "localizer/query_check.h"
#include "localizer/query_in_map.h"
#include "map/contents.h"
#include "outputs.h"
#include "place/edges.h"
#include "place/measure_size.h"
#include "place/odometry_check.h"
#include "place/raw_recording.h"
#include "tool.h"
#include "windows.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {
namespace {

using Json = nlohmann::ordered_json;

/// What some points, pixels or vertices hold: how many of each class, and where.
struct Census {
  std::map<std::uint32_t, std::size_t> counts;
  Eigen::AlignedBox3d bounds;  ///< [m]
  std::size_t measured = 0;    ///< points that are there, or pixels with depth
  std::size_t size = 0;        ///< points or pixels
  std::string camera;          ///< in words; empty if there is none
};

Census censusOf(const LabelledCloud& cloud) {
  Census census;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ++census.counts[cloud.points[i].label];
    census.bounds.extend(cloud.position(i));
  }
  census.size = census.measured = cloud.size();
  return census;
}

Census censusOf(const SemanticGraph& graph) {
  Census census;
  for (const Vertex& vertex : graph.vertices) {
    ++census.counts[vertex.label];
    census.bounds.extend(vertex.position);
  }
  census.size = census.measured = graph.size();
  return census;
}

/// In the frame of the sensor; a camera frame has no bounds.
Census censusOf(const Frame& frame) {
  if (frame.sensor != Sensor::camera) return censusOf(frame.cloud);
  Census census;
  for (const std::uint16_t label : frame.label.pixels) ++census.counts[label];
  for (const float depth : frame.depth.pixels) census.measured += depth > 0;
  census.size = frame.depth.pixels.size();
  census.camera = fmt::format("{} x {} px, fx {:.1f}, fy {:.1f}, cx {:.1f}, cy {:.1f}",
                              frame.camera.width, frame.camera.height, frame.camera.fx,
                              frame.camera.fy, frame.camera.cx, frame.camera.cy);
  return census;
}

/// What is known, as rows for people and as JSON for programs.
class Sheet {
 public:
  explicit Sheet(bool as_json) : as_json_(as_json) {}

  /// The key of the JSON is the name with underscores; `value` stands there unless it is null.
  void row(const std::string& name, const std::string& text, Json value = nullptr) {
    std::string key = name;
    std::replace(key.begin(), key.end(), ' ', '_');
    json_[key] = value.is_null() ? Json(text) : std::move(value);
    line(name, text);
  }
  /// Text only.
  void line(const std::string& name, const std::string& text) {
    text_ += fmt::format("{:<14}{}\n", name, printable(text));
  }
  /// JSON only.
  void hidden(const std::string& key, Json value) { json_[key] = std::move(value); }
  void bounds(const std::string& name, const Eigen::AlignedBox3d& box);
  void classes(const Census& census, const LabelSet& labels, const char* unit);
  void topics(const std::vector<io::BagTopic>& topics);
  std::string text() const {
    if (!as_json_) return text_.substr(0, text_.find_last_not_of('\n') + 1);
    return json_.dump(2, ' ', false, Json::error_handler_t::replace);
  }

 private:
  bool as_json_;
  Json json_;
  std::string text_;
};

void Sheet::bounds(const std::string& name, const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return;
  const Eigen::Vector3d a = box.min(), b = box.max(), size = box.sizes();
  row(name,
      fmt::format(
          "x {:.2f} .. {:.2f}, y {:.2f} .. {:.2f}, z {:.2f} .. {:.2f} m ({:.1f} x {:.1f} x {:.1f})",
          a.x(), b.x(), a.y(), b.y(), a.z(), b.z(), size.x(), size.y(), size.z()),
      {{"min", {a.x(), a.y(), a.z()}}, {"max", {b.x(), b.y(), b.z()}}});
}

void Sheet::classes(const Census& census, const LabelSet& labels, const char* unit) {
  std::size_t total = 0;
  for (const auto& [id, count] : census.counts) total += count;
  text_ += fmt::format("{:<14}{}{}{}\n{:>6}  {:<24}{:<10}{:>14}\n", "classes", census.counts.size(),
                       labels.name().empty() ? "" : " of label set ", printable(labels.name()),
                       "id", "name", "role", unit);
  json_["label_set"] = labels.name();
  json_["unit"] = unit;
  json_["classes"] = Json::array();
  for (const auto& [id, count] : census.counts) {
    const char* role = labels.find(id) ? toString(labels.role(id)) : "unknown";
    const double share = static_cast<double>(count) / static_cast<double>(total);
    text_ += fmt::format("{:>6}  {:<23} {:<10}{:>14}{:>7.2f} %\n", id,
                         printable(labels.className(id)), role, count, 100 * share);
    json_["classes"].push_back(
        {{"id", id}, {"name", labels.className(id)}, {"role", role}, {"count", count}});
  }
}

void Sheet::topics(const std::vector<io::BagTopic>& topics) {
  text_ += fmt::format("{:<14}{}\n", "topics", topics.size());
  json_["topics"] = Json::array();
  for (const io::BagTopic& topic : topics) {
    const double hz = topic.messages > 1 && topic.duration_s > 0
                          ? static_cast<double>(topic.messages - 1) / topic.duration_s
                          : 0;
    text_ += fmt::format("{:>8}  {:<32} {:<32}{:>8}  {:>8.2f} Hz{:>10.3f} s\n", topic.taken_as,
                         printable(topic.name), printable(topic.type), topic.messages, hz,
                         topic.duration_s);
    json_["topics"].push_back({{"name", topic.name},
                               {"type", topic.type},
                               {"messages", topic.messages},
                               {"rate_hz", hz},
                               {"duration_s", topic.duration_s},
                               {"taken_as", topic.taken_as}});
  }
}

void printGraph(Sheet& sheet, const SemanticGraph& graph, const LabelSet& labels) {
  const Census census = censusOf(graph);
  const EdgeCount count = countEdges(graph);
  sheet.row("graph",
            fmt::format("{} vertices, {} edges, {} connected parts", graph.size(), count.edges,
                        count.parts),
            {{"vertices", graph.size()}, {"edges", count.edges}, {"parts", count.parts}});
  if (graph.space == GraphSpace::image) sheet.row("graph space", "image");
  sheet.bounds("bounds", census.bounds);
  sheet.classes(census, labels, "vertices");
}

void printMap(Sheet& sheet, const std::string& path) {
  map::SemanticMap map = map::openMap(path);
  const map::Counts counts = map::countsOf(map);
  sheet.row("version",
            fmt::format("schema {}, written by {}", map::kMapSchemaVersion, map.program_version));
  sheet.row("size", sizeText(map.size));
  sheet.row("holds",
            fmt::format("{} key frames, {} points, {} plan samples", map.poses.size(),
                        counts.points, counts.samples),
            {{"key_frames", map.poses.size()},
             {"points", counts.points},
             {"plan_samples", counts.samples}});
  sheet.row("sources", fmt::format("{}", fmt::join(map.sources, ", ")), map.sources);
  Json own = Json::array();
  for (const OwnAcceptance& a : ownAcceptance(map))
    own.push_back({{"length_m", a.window_m},
                   {"windows", a.stretches},
                   {"accepted", a.accepted},
                   {"risks", OwnAcceptance::kRisks}});
  if (!own.empty()) sheet.row("own windows", ownAcceptanceText(map), own);
  if (const auto margins = wrongPlaceMargins(map))
    sheet.row("wrong places", wrongPlacesText(map),
              {{"dense_margin", margins->dense},
               {"likelihood_margin", margins->likelihood},
               {"copies", margins->areOfCopies()}});
  std::vector<std::string> changes;
  for (const map::Revision& revision : map::readRevisions(path)) changes.push_back(revision.note);
  if (!changes.empty()) sheet.row("changes", fmt::format("{}", fmt::join(changes, "; ")), changes);
  map::unpackVertices(map);
  printGraph(sheet, map.graph, map.labels);
}

/// What lengths are usual there, given or measured.
template <class Measured>
void printSize(Sheet& sheet, const Measured& data, const Options& options) {
  if (const auto given = parseSize(options.size)) return sheet.row("size", sizeText(*given));
  const MeasuredSize found = measureSize(data);
  sheet.row("size", fmt::format("{} ({})", sizeText(found.size), found.reason),
            sizeText(found.size));
}

/// Where queries of it would begin, and why it would be no map.
void printOdometry(Sheet& sheet, const FrameSource& source, const Job& job) {
  if (source.size() < 2 || source.sensor() == Sensor::cloud || !job.options.odometry.check) return;
  std::vector<std::string> texts;
  Json jumps = Json::array();
  for (const OdometryJump& jump : findJumps(source, job.options)) {
    texts.push_back(fmt::format("{} (off by about {:.1f} m)", jump.frame, jump.off_m));
    jumps.push_back({{"frame", jump.frame}, {"off_m", jump.off_m}});
  }
  sheet.row("odometry",
            texts.empty()
                ? "nothing in the scans contradicts it"
                : fmt::format("the scans contradict it at frame {}", fmt::join(texts, ", ")),
            {{"jumps", jumps}});
}

void printRecording(Sheet& sheet, const FrameSource& source, const Job& job) {
  if (source.size() == 0) throw Error(source.name(), "no frames");
  printSize(sheet, std::vector<const FrameSource*>{&source}, job.options);
  std::vector<Census> frames;
  forEachFrame(
      source, job, "info", [](const Frame& frame) { return censusOf(frame); },
      [&](Census census) { frames.push_back(std::move(census)); });
  logStrays(source, job.narrate);
  Census all;
  double length_m = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const auto& [id, count] : frames[i].counts) all.counts[id] += count;
    all.measured += frames[i].measured;
    all.size += frames[i].size;
    all.bounds.extend(source.pose(i).translation());
    if (i > 0) length_m += (source.pose(i).translation() - source.pose(i - 1).translation()).norm();
  }
  const std::size_t last = frames.size() - 1;
  const char* unit = frames[0].camera.empty() ? "points" : "pixels";
  const double duration_s = source.stamp(last) - source.stamp(0);
  sheet.row("frames",
            fmt::format("{}, numbers {} .. {}, {:.3f} s", frames.size(), source.number(0),
                        source.number(last), duration_s),
            {{"count", frames.size()},
             {"first", source.number(0)},
             {"last", source.number(last)},
             {"duration_s", duration_s}});
  if (!frames[0].camera.empty()) sheet.row("camera", frames[0].camera);
  sheet.row("measured", fmt::format("{} of {} {}", all.measured, all.size, unit), all.measured);
  sheet.row("path length", fmt::format("{:.1f} m", length_m), length_m);
  sheet.bounds("positions", all.bounds);
  printOdometry(sheet, source, job);
  sheet.classes(all, source.labels(), unit);
}

/// What localizing a query in a map will meet, as `localize` reads both.
class Meeting {
 public:
  Meeting(const InputFlags& input, const Job& given) : input_(input), job_(given) {
    job_.narrate =
        Narrative({[this](const std::string& note) { notes_.push_back(note); }, nullptr});
    map_ = readWholeMap(job_.operands[1], input_, job_);
    job_ = inMap(std::move(job_), map_);
    query_ = readQuery(job_.operands[0], input_, job_, map_.labels, kLastMetres);
    logOwnDrive(map_, query_.path, query_.poses(), job_.narrate);
  }

  void print(Sheet& sheet) {
    printInShort(sheet);
    printPlaces(sheet);
    printClasses(sheet);
    printGraphs(sheet);
    printSearch(sheet);
    printUp(sheet);
    for (const std::string& note : notes_) sheet.line("note", note);
    sheet.hidden("notes", notes_);
  }

 private:
  LabelSet ownLabels() const;
  void printInShort(Sheet& sheet) const;
  void printPlaces(Sheet& sheet);
  void printClasses(Sheet& sheet) const;
  void printGraphs(Sheet& sheet) const;
  void printSearch(Sheet& sheet) const;
  void printUp(Sheet& sheet);

  const InputFlags& input_;
  Job job_;
  std::vector<std::string> notes_;
  map::SemanticMap map_;
  QueryInput query_;
};

Eigen::AlignedBox3d boundsOf(const Place& place) {
  Eigen::AlignedBox3d box = censusOf(place.graph).bounds;
  box.extend(censusOf(place.cloud).bounds);
  const BevGrid& bev = place.bev;
  for (const GroundCell& cell : bev.known)
    box.extend(Eigen::Vector3d(bev.origin_x + cell.x * bev.cell_m,
                               bev.origin_y + cell.y * bev.cell_m, bev.origin_z + cell.z));
  return box;
}

/// The classes of the query before they are brought into those of the map.
LabelSet Meeting::ownLabels() const {
  io::InputOptions options = inputIn(input_, map_.labels);
  if (knowsShapesOnly(map_.labels)) options.labels = kShapes;
  if (const auto stored = readStored(query_.path, options, job_)) return stored->labels;
  return withRolesByShape(openInput(query_.path, options, job_), job_.options.lift,
                          job_.options.threads, &map_.labels)
      ->labels();
}

std::string extentText(const Place& place) {
  const Eigen::AlignedBox3d box = boundsOf(place);
  if (box.isEmpty()) return "nothing";
  return fmt::format("{:.3g} x {:.3g} x {:.3g} m", box.sizes().x(), box.sizes().y(),
                     box.sizes().z());
}

/// By the longest of the map's own windows that the query is as long as, else by the shortest.
std::string expectedText(const map::SemanticMap& map, double length_m) {
  const std::vector<OwnAcceptance> all = ownAcceptance(map);
  if (all.empty()) return "the map did not look for windows of itself; make it of a recording";
  std::size_t longest = 0;
  while (longest + 1 < all.size() && all[longest + 1].window_m <= length_m) ++longest;
  const OwnAcceptance& own = all[longest];
  return fmt::format("{} % of the map's own windows of {:.3g} m are accepted by place alone",
                     100 * own.accepted[0] / own.stretches, own.window_m);
}

/// What decides most of it: what has seen both, how much of a place, and how sure it can be.
void Meeting::printInShort(Sheet& sheet) const {
  const auto points = [](const Place& place) {
    const double area_m2 =
        static_cast<double>(place.bev.known.size()) * place.bev.cell_m * place.bev.cell_m;
    const double count = static_cast<double>(place.cloud.size());
    return fmt::format("{:.0f} points, {:.3g} per m2", count, count / std::max(1.0, area_m2));
  };
  const Place& query = *query_.whole;
  sheet.row("query", query_.path);
  sheet.row("map", job_.operands[1]);
  const char* const sensor = query.sensor == Sensor::camera  ? "a camera"
                             : query.sensor == Sensor::lidar ? "a scanner"
                                                             : "a cloud";
  sheet.row("seen by", fmt::format("{}, {}; map: {} key frames, {}", sensor, points(query),
                                   map_.poses.size(), points(map_)));
  sheet.row("extent", extentText(query) + "; map: " + extentText(map_));
  sheet.row("expected", expectedText(map_, pathLengths(query.poses).back()));
}

void Meeting::printPlaces(Sheet& sheet) {
  sheet.bounds("query bounds", boundsOf(*query_.whole));
  sheet.bounds("map bounds", boundsOf(map_));
  const double length_m = pathLengths(query_.whole->poses).back();
  sheet.row("query length",
            fmt::format("{:.1f} m, {} of {} frames", length_m, query_.size() - query_.used_from,
                        query_.size()),
            length_m);
  sheet.row("size", sizeText(map_.size));
  const MeasuredSize alone = query_.source
                                 ? measureSize(std::vector<const FrameSource*>{query_.source.get()})
                                 : measureSize(query_.whole->graph);
  sheet.row("query alone", fmt::format("{} ({})", sizeText(alone.size), alone.reason),
            sizeText(alone.size));
  if (alone.size != map_.size)
    notes_.push_back(fmt::format(
        "{} looks like a {} and is read with the lengths of a {}, as the map has them; are the "
        "lengths of both metres?",
        query_.path, sizeText(alone.size), sizeText(map_.size)));
}

void Meeting::printClasses(Sheet& sheet) const {
  const LabelSet own = ownLabels();
  const auto nameOf = [](const LabelSet& labels) {
    return knowsShapesOnly(labels) ? std::string("from shapes")
           : labels.isGeneric()    ? std::string("ids without names")
           : labels.name().empty() ? std::string("of its own")
                                   : "'" + labels.name() + "'";
  };
  sheet.row("query classes", nameOf(own), own.name());
  sheet.row("map classes", nameOf(map_.labels), map_.labels.name());
  const io::InputOptions options = input_.parsed();
  const LabelMatch match(own, map_.labels, options.class_names);
  Json partners = Json::array();
  for (const auto& [id, partner] : match.partners()) {
    const std::string name = own.className(id), there = map_.labels.className(partner.id);
    sheet.line("", fmt::format("{:<24}{:<24}by {}", name, there, toString(partner.by)));
    partners.push_back({{"query", name}, {"map", there}, {"by", toString(partner.by)}});
  }
  sheet.hidden("partners", partners);
  const auto listAlone = [&](const char* row, const LabelMatch& of) {
    std::vector<std::string> names;
    for (const std::uint32_t id : of.alone()) names.push_back(of.from().className(id));
    sheet.row(row, names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")), names);
  };
  listAlone("only in query", match);
  listAlone("only in map", LabelMatch(map_.labels, own, options.class_names));
}

void Meeting::printGraphs(Sheet& sheet) const {
  const char *query = toString(query_.whole->graph.space), *map = toString(map_.graph.space);
  sheet.row("graph space", fmt::format("{} (query), {} (map)", query, map),
            {{"query", query}, {"map", map}});
}

void Meeting::printSearch(Sheet& sheet) const {
  const std::string windows = ownAcceptanceText(map_);
  if (!windows.empty()) sheet.row("own windows", windows);
  const QueryInMap in_map(*query_.whole, map_.labels, map_.size, input_.parsed().class_names);
  const auto problem = whyUnfindable(*in_map, *Scaled<map::SemanticMap>(map_, 1 / map_.size));
  sheet.row("findable", problem ? "no: " + *problem : "worth a search", !problem);
  sheet.hidden("reason", problem.value_or(""));
}

/// The last of all, as the map is used up.
void Meeting::printUp(Sheet& sheet) {
  const Gravity query = query_.whole->gravity;
  const Gravity map = makeQuery(std::move(map_), job_.options).gravity;
  const auto json = [](const Gravity& up) {
    return Json{{"known", up.known}, {"reason", up.reason}};
  };
  sheet.row("up", fmt::format("query: {}; map: {}", query.reason, map.reason),
            {{"query", json(query)}, {"map", json(map)}});
}

class InfoCommand final : public Command {
 public:
  Description describe() const override {
    return {"info",
            "FILE|DIR [MAP]",
            "what is it: kind, classes and counts, bounds, poses, versions",
            "Reads everything, so that what info accepts the other commands accept as well; only a "
            "cloud without classes is described, too. With a MAP: what localizing it there will "
            "meet: classes and their partners, bounds, lengths, which way is up, and all notes.",
            "xview info town/forward",
            1,
            2};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    flags.add("--json", json_, "print one JSON object");
    flags.addOutput("-o,--out", out_, "write it to this file");
  }

  ExitCode run(const Job& job) override {
    Sheet sheet(json_);
    if (job.operands.size() == 2)
      Meeting(input_, job).print(sheet);
    else
      printOne(sheet, job.operands[0], job);
    Results results(out_);
    results.print(sheet.text(), job.narrate);
    results.finish();
    return kDone;
  }

 private:
  void printOne(Sheet& sheet, const std::string& path, const Job& job) const {
    io::InputOptions input = input_.parsed();
    const io::InputKind kind = chooseKind(path, input, job);
    sheet.row("path", path);
    sheet.row("kind", toString(kind));
    if (kind == io::InputKind::map) {
      printMap(sheet, path);
    } else if (kind == io::InputKind::graph) {
      const Place file = readLabelledGraph(path, input, job);
      printSize(sheet, file.graph, job.options);
      printGraph(sheet, file.graph, file.labels);
    } else if (kind == io::InputKind::cloud) {
      printCloud(sheet, path, input, job);
    } else {
      if (kind == io::InputKind::bag) sheet.topics(io::bagTopics(path, input));
      printFrames(sheet, path, kind, input, job);
    }
  }

  /// Of a bag that cannot be read as it is, the topics are worth knowing.
  static void printFrames(Sheet& sheet, const std::string& path, io::InputKind kind,
                          const io::InputOptions& input, const Job& job) {
    try {
      printRecording(sheet, *openPlaceInput(path, input, job), job);
    } catch (const Error& problem) {
      if (kind != io::InputKind::bag) throw;
      job.narrate.note(problem.what());
    }
  }

  /// A single PCD, PLY or LAS; one without labels is described as well, as what it lacks is worth
  /// knowing.
  void printCloud(Sheet& sheet, const std::string& path, const io::InputOptions& options,
                  const Job& job) const {
    const io::CloudFields fields{options.label_field, options.instance_field};
    const io::CloudHeader header = io::readCloudHeader(path, fields);
    const auto or_none = [](const std::string& field) {
      return field.empty() ? "no such field" : field;
    };
    sheet.row("format", header.format);
    sheet.row("points", std::to_string(header.points), header.points);
    sheet.row("fields", fmt::format("{}", fmt::join(header.fields, " ")), header.fields);
    if (!header.georeference.empty()) sheet.row("georeference", header.georeference);
    sheet.row("label", or_none(header.label_field));
    sheet.row("instance", or_none(header.instance_field));
    const bool may_be_raw = header.label_field.empty() || header.format.rfind("LAS", 0) == 0;
    const auto raw = may_be_raw ? io::openRecording(path, options) : nullptr;
    if (raw && raw->labels().empty()) {
      for (const std::string& note : raw->notes()) job.narrate.note(path + ": " + note);
      printSize(sheet, std::vector<const FrameSource*>{raw.get()}, job.options);
      sheet.bounds("bounds", censusOf(raw->read(0)).bounds);
      return logStrays(*raw, job.narrate);
    }
    const auto source = openInput(path, options, job);
    printSize(sheet, std::vector<const FrameSource*>{source.get()}, job.options);
    const Census census = censusOf(source->read(0));
    logStrays(*source, job.narrate);
    sheet.row("finite", fmt::format("{} points", census.measured), census.measured);
    sheet.bounds("bounds", census.bounds);
    sheet.classes(census, source->labels(), "points");
  }

  InputFlags input_;
  std::string out_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> makeInfo() { return std::make_unique<InfoCommand>(); }

}  // namespace xview::tools
