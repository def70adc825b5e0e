// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <pybind11/stl.h>

#include <cmath>

#include "base/label_match.h"
#include "fix.h"
#include "match/consistency.h"
#include "match/descriptors.h"
#include "match/sample_consensus.h"
#include "place/edges.h"
#include "places.h"
#include "scored_files.h"
#include "xview/base/error.h"
#ifdef XVIEW_WITH_SIM
#include "sim/recordings.h"
#endif

namespace xview::python {
namespace {

/// Of anything that a map is built of; a map gives its own.
Graph graphOf(const Source& source, const py::kwargs& arguments) {
  Work work(optionsOf(arguments));
  auto place = std::make_shared<Place>();
  if (py::isinstance<Graph>(source.what)) return source.what.cast<Graph>();
  if (py::isinstance<Map>(source.what)) {
    // Not within the braces below: g++ 12 destroys what it has not made if an item there throws.
    auto of_map = withEdges(unpacked(source.what.cast<Map&>()));
    return {"", {}, std::move(of_map)};
  }
  const Recording recording = source.recording(nullptr);
  *place = released([&] {
    const std::unique_ptr<FrameSource> frames =
        recording.path.empty() ? ownedSource(recording.source)
                               : tools::openInput(recording.path, recording.input, work.job());
    tools::FrameReport report(*frames, work.job().narrate);
    return makeQuery(*frames, work.job().options,
                     [&](const PreprocessedFrame& frame) { report.add(frame); });
  });
  work.takeNotes();
  if (place->graph.empty()) throw Error(recording.source->name(), "no blobs to make a graph of");
  makeEdges(place->graph);
  return {"", {}, std::move(place)};
}

/// Labels of walks by their letters.
std::vector<std::uint32_t> lettersOf(const SemanticGraph& graph,
                                     const match::LabelAlphabet& alphabet) {
  std::vector<std::uint32_t> labels(256);
  for (const Vertex& vertex : graph.vertices) labels[alphabet(vertex.label)] = vertex.label;
  return labels;
}

py::tuple wordOf(match::WalkKey key, const std::vector<std::uint32_t>& labels) {
  py::list word;
  for (; key != 0; key >>= 8) word.append(labels[key & 0xFF]);
  return py::tuple(word);
}

py::list walksOf(const Graph& graph, std::uint32_t vertex, const py::kwargs& arguments) {
  const Options options = optionsOf(arguments);
  const SemanticGraph& g = graph.place->graph;
  if (vertex >= g.size())
    throw UsageError(fmt::format("vertex {} of a graph of {}", vertex, g.size()));
  const match::LabelAlphabet alphabet(g);
  const auto labels = lettersOf(g, alphabet);
  py::list walks;
  const match::Walks from(g, alphabet, options.walks, static_cast<std::uint64_t>(options.seed));
  for (const match::WalkCount& walk : from.from(vertex))
    walks.append(py::make_tuple(wordOf(walk.key, labels), walk.count));
  return walks;
}

/// Walk descriptors of all vertices of a graph.
struct Described {
  std::shared_ptr<const match::Descriptors> words;
  std::vector<std::uint32_t> labels;  ///< by letter

  const std::vector<match::WalkCount>& at(std::size_t vertex) const {
    if (vertex >= words->size())
      throw py::index_error(fmt::format("vertex {} of {}", vertex, words->size()));
    return (*words)[vertex];
  }
};

Described describe(const Graph& graph, const py::object& in, const py::kwargs& arguments) {
  const Options options = optionsOf(arguments);
  const SemanticGraph& own = graph.place->graph;
  if (!in.is_none() && !py::isinstance<Graph>(in)) throw UsageError("alphabet_of is no Graph");
  const SemanticGraph& other = in.is_none() ? own : in.cast<const Graph&>().place->graph;
  const match::LabelAlphabet alphabet(other);
  Described result;
  result.labels = lettersOf(other, alphabet);
  result.words = released([&] {
    return std::make_shared<const match::Descriptors>(match::describe(
        own, alphabet, options.walks, static_cast<std::uint64_t>(options.seed), options.threads));
  });
  return result;
}

/// The graph of the query in the classes of the map.
SemanticGraph inClassesOf(const Graph& map, const Graph& query) {
  const LabelMatch match(query.place->labels, map.place->labels);
  Place place;
  place.labels = query.place->labels;
  place.graph = query.place->graph;
  return match.changesNothing() ? place.graph : translated(std::move(place), match).graph;
}

py::tuple matchGraphs(const Graph& query, const Graph& map, const py::kwargs& arguments) {
  const Options options = optionsOf(arguments);
  const auto matches = released([&] {
    const SemanticGraph& in = map.place->graph;
    const match::LabelAlphabet alphabet(in);
    const auto seed = static_cast<std::uint64_t>(options.seed);
    const auto describe = [&](const SemanticGraph& graph) {
      return match::describe(graph, alphabet, options.walks, seed, options.threads);
    };
    return match::DescriptorIndex(describe(in))
        .bestMatches(describe(inClassesOf(map, query)), options.match, options.threads);
  });
  py::array_t<float> similarity(static_cast<py::ssize_t>(matches.size()));
  for (std::size_t i = 0; i < matches.size(); ++i)
    similarity.mutable_at(static_cast<py::ssize_t>(i)) = matches[i].similarity;
  return py::make_tuple(pairsOf(matches), similarity);
}

std::vector<Eigen::Vector3d> positionsOf(const Graph& graph) {
  std::vector<Eigen::Vector3d> positions;
  for (const Vertex& vertex : graph.place->graph.vertices) positions.push_back(vertex.position);
  return positions;
}

/// What agrees in pairs, and the pose that most of it supports.
py::tuple consensusOf(
    const Graph& query, const Graph& map,
    const py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>& pairs,
    const py::kwargs& arguments) {
  if (pairs.ndim() != 2 || pairs.shape(1) != 2)
    throw UsageError("pairs: expected the shape (K, 2)");
  const Options options = optionsOf(arguments);
  std::vector<Correspondence> matches;
  for (py::ssize_t i = 0; i < pairs.shape(0); ++i) {
    const Correspondence match{pairs.at(i, 0), pairs.at(i, 1), 1};
    if (match.query >= query.place->graph.size() || match.map >= map.place->graph.size())
      throw UsageError(fmt::format("pairs[{}] names a vertex that does not exist", i));
    matches.push_back(match);
  }
  const match::Consensus consensus = released([&] {
    const auto from = positionsOf(query), to = positionsOf(map);
    return match::rejectBySampleConsensus(
        from, to,
        match::consistentCorrespondences(from, to, matches, options.consensus.inlier_m,
                                         options.gravity != "free"),
        options.consensus);
  });
  if (!consensus.found) return py::make_tuple(py::none(), pairsOf(std::vector<Correspondence>()));
  return py::make_tuple(arrayOf<4, 4>(consensus.T_map_query.matrix()), pairsOf(consensus.inliers));
}

#ifdef XVIEW_WITH_SIM
py::dict simulate(const py::kwargs& arguments) {
  SimulationOptions options;
  const std::vector<OptionField> fields = fieldsOf(options);
  forEachOption(arguments, [&](const std::string& key, const std::string& text) {
    for (const OptionField& field : fields) {
      if (field.key == key) return assign(field, text);
    }
    throw UsageError("unknown option " + key + "; `xview simulate --help-all` lists them");
  });
  auto sessions = released([&] { return makeSessions(options); });
  py::dict recordings;
  for (auto& session : sessions) {
    Recording recording;
    for (std::size_t i = 0; i < session->size(); ++i) recording.truth.push_back(session->truth(i));
    const std::string name = session->name();
    recording.source = std::move(session);
    recordings[py::str(name)] = std::move(recording);
  }
  return recordings;
}
#else
py::dict simulate(const py::kwargs&) {
  throw UsageError(
      "this build has no simulator: Embree was not found; install libembree-dev and build again");
}
#endif

bool isPath(const py::object& given) {
  return py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__");
}

/// Answers from a file, those of localize(), or poses that somebody else found.
std::vector<tools::Answer> answersOf(const py::object& given) {
  if (isPath(given)) return tools::readAnswers(pathText(given));
  std::vector<tools::Answer> answers;
  for (const py::handle item : given) {
    if (py::isinstance<Fix>(item)) {
      answers.push_back(*item.cast<const Fix&>().answer);
      continue;
    }
    if (!py::isinstance<py::array>(item))
      throw UsageError("expected a list of Fix or of poses (4, 4), or a file");
    tools::Answer answer;
    answer.first_frame = answer.last_frame = static_cast<std::int64_t>(answers.size());
    answer.fix = tools::acceptedPose(poseOf(item, fmt::format("fixes[{}]", answers.size())));
    answers.push_back(std::move(answer));
  }
  return answers;
}

ScoredQuery scored(const tools::Answer& answer) {
  return {answer.input, answer.first_frame, answer.last_frame, answer.fix, false, {}};
}

std::vector<ScoredQuery> scoredQueries(const py::object& fixes, const py::object& truth) {
  std::vector<ScoredQuery> queries;
  if (isPath(truth)) {
    Work work({});
    if (isPath(fixes))
      queries = tools::scoredFile(pathText(fixes), pathText(truth), work.job().narrate);
    work.takeNotes();
    if (isPath(fixes)) return queries;
    const tools::Truth poses{pathText(truth)};
    for (const tools::Answer& answer : answersOf(fixes)) {
      queries.push_back(scored(answer));
      queries.back().truth = poses.poseFor(answer);
    }
    return queries;
  }
  const std::vector<Eigen::Isometry3d> poses = posesOf(truth, "truth");
  for (const tools::Answer& answer : answersOf(fixes)) queries.push_back(scored(answer));
  if (poses.size() != queries.size())
    throw UsageError(fmt::format("truth has {} poses, expected {}: one per answer", poses.size(),
                                 queries.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) queries[i].truth = poses[i];
  return queries;
}

template <class Values, class Get>
py::array_t<double> column(const Values& values, Get&& get) {
  py::array_t<double> array(static_cast<py::ssize_t>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
    array.mutable_at(static_cast<py::ssize_t>(i)) = get(values[i]);
  return array;
}

py::object evaluateFixes(const py::object& fixes, const py::object& truth, double within_m,
                         const py::object& negatives) {
  if (!(within_m > 0)) throw UsageError(fmt::format("within_m = {}, must be > 0", within_m));
  std::vector<ScoredQuery> queries = scoredQueries(fixes, truth);
  for (const tools::Answer& answer : answersOf(negatives)) {
    queries.push_back(scored(answer));
    queries.back().negative = true;
  }
  const Evaluation evaluation = evaluate(queries, within_m);
  py::object result = py::module_::import("json").attr("loads")(evaluationJson(evaluation));
  const auto& curve = evaluation.curve;
  py::dict pr;
  pr["threshold"] = column(curve, [](const PrecisionRecall& p) { return p.threshold; });
  pr["precision"] = column(curve, [](const PrecisionRecall& p) { return p.precision; });
  pr["recall"] = column(curve, [](const PrecisionRecall& p) { return p.recall; });
  result["pr"] = pr;
  py::dict per_query;
  const auto ofTruth = [](double (ScoredQuery::*error)() const) {
    return [error](const ScoredQuery& q) { return q.negative ? std::nan("") : (q.*error)(); };
  };
  per_query["error_m"] = column(queries, ofTruth(&ScoredQuery::positionError));
  per_query["error_deg"] = column(queries, ofTruth(&ScoredQuery::rotationError));
  per_query["confidence"] = column(queries, [](const auto& q) { return q.fix.confidence; });
  per_query["accepted"] =
      column(queries, [](const auto& q) { return q.fix.accepted(); }).attr("astype")("bool");
  result["per_query"] = per_query;
  return result;
}

}  // namespace

void bindResearch(py::module_& module) {
  module.def(
      "graph",
      [](const py::object& source, const py::object& labels, const py::object& poses,
         const py::object& stamps, const py::object& classes, const py::kwargs& options) {
        return graphOf({source, labels, poses, stamps, classes}, options);
      },
      py::arg("source"), py::arg("labels") = py::none(), py::arg("poses") = py::none(),
      py::arg("stamps") = py::none(), py::arg("classes") = py::none(),
      "The semantic graph of what Map.build() takes: blobs of one class, merged over frames, with "
      "edges between neighbours (paper, section III-A and B). Options are those of `xview graph`.");
  module.def("walks", &walksOf, py::arg("graph"), py::arg("vertex"),
             "The random walks from one vertex as [(class ids, count)]: options "
             "walks__num_walks (n of the paper), walks__walk_length (m), seed (section III-C).");
  py::class_<Described>(module, "Descriptors", "The walks of every vertex of a graph.")
      .def("__len__", [](const Described& d) { return d.words->size(); })
      .def(
          "__getitem__",
          [](const Described& d, std::size_t vertex) {
            py::dict words;
            for (const match::WalkCount& walk : d.at(vertex))
              words[wordOf(walk.key, d.labels)] = static_cast<int>(walk.count);
            return words;
          },
          py::arg("vertex"), "Walks of a vertex: {class ids: count}.")
      .def(
          "similarity",
          [](const Described& d, std::size_t vertex, const Described& other, std::size_t of_other) {
            return match::similarity(d.at(vertex), other.at(of_other));
          },
          py::arg("vertex"), py::arg("other"), py::arg("of_other"),
          "Share of identical walks of two vertices, in [0, 1]. Both descriptors must be made with "
          "one alphabet.");
  module.def("descriptors", &describe, py::arg("graph"), py::arg("alphabet_of") = py::none(),
             "Walk descriptors of all vertices, in the alphabet of classes of `alphabet_of`, a "
             "Graph; else of the graph itself.");
  module.def("match", &matchGraphs, py::arg("query"), py::arg("map"),
             "The match__candidates most similar map vertices of every query vertex (section "
             "III-D): pairs uint32 (K, 2) of query and map vertex, and similarities float32 (K,). "
             "Classes meet by name.");
  module.def("consensus", &consensusOf, py::arg("query"), py::arg("map"), py::arg("pairs"),
             "The pose that most pairs support (section III-E): T_map_query float64 (4, 4) [m] and "
             "the pairs that keep it, uint32 (K, 2); None instead of the pose if fewer than "
             "consensus__min_inliers do.");
  module.def("evaluate", &evaluateFixes, py::arg("fixes"), py::arg("truth"),
             py::arg("within_m") = 5.0, py::arg("negatives") = py::tuple(),
             "Errors, success and precision-recall of answers, as the dict of summary.json of "
             "`xview evaluate`, with arrays: 'pr' (threshold, precision, recall) and 'per_query' "
             "(error_m, error_deg, confidence, accepted; negatives last, whose errors are NaN; "
             "infinite without a pose). fixes: a list of Fix or of T_map_sensor (4, 4) [m], which "
             "count as accepted, or a .jsonl, TUM or KITTI file; truth: T_map_sensor (N, 4, 4) per "
             "answer [m], or a TUM or KITTI file; negatives: a list of Fix, or a .jsonl file. An "
             "answer within `within_m` is correct.");
  module.def(
      "simulate", &simulate,
      "Recordings of a seeded world by the name of their session, with their truth: "
      "forward, rear, aerial, and those that sessions__NAME=True asks for. Options are those "
      "of `xview simulate --help-all`.");
}

}  // namespace xview::python
