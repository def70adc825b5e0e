// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "answer.h"
#include "consistency_checks.h"
#include "fix.h"
#include "place/depth_plausibility.h"
#include "places.h"
#include "windows.h"
#include "xview/base/error.h"
#include "xview/follower.h"
#include "xview/localizer.h"

namespace xview::python {
namespace {

/// A map that queries are sought in. Copies share everything.
struct Seeker {
  std::shared_ptr<const map::SemanticMap> map;
  std::shared_ptr<const Localizer> localizer;
  Options options;           ///< with the size of the map
  BudgetLimits limits;       ///< of each query
  tools::Answer unanswered;  ///< with what all answers share
};

Fix finished(tools::Answer answer, Sensor sensor, Work& work) {
  answer.heading_rad = headingOf(answer.fix.T_map_sensor.linear(), sensor);
  std::vector<std::string> notes = work.takeNotes();
  return {std::make_shared<const tools::Answer>(std::move(answer)), std::move(notes)};
}

Seeker makeSeeker(const Map& map, double risk, double timeout_s, double max_memory_mb,
                  const py::kwargs& arguments) {
  tools::requireNotEmpty(*map.map, map.path);
  Seeker seeker;
  requireValid(seeker.limits = {timeout_s, max_memory_mb});
  seeker.map = map.map;
  seeker.options = optionsOf(arguments);
  tools::acceptAtRisk("risk", risk, seeker.options.verdict);
  seeker.options.size = sizeText(map.map->size);
  seeker.localizer =
      released([&] { return std::make_shared<const Localizer>(seeker.map, seeker.options); });
  seeker.unanswered = tools::unansweredIn(*map.map, map.path, map.load_ms);
  return seeker;
}

Fix localize(const Seeker& seeker, const Source& source, double last_m) {
  if (!(last_m >= 0)) throw UsageError(fmt::format("last_m = {}, must be >= 0", last_m));
  Work work(seeker.options);
  const Budget budget(seeker.limits);
  tools::QueryInput input;
  const auto read = [&] { input = queryOf(source, seeker.map->labels, last_m, work); };
  if (cutByBudget(read)) input.whole.emplace().poses.emplace_back(Eigen::Isometry3d::Identity());
  tools::logOwnDrive(*seeker.map, input.path, input.poses(), work.job().narrate);
  checkSignals();
  tools::Answer answer =
      tools::answerFor(input, {0, input.size()}, *input.whole, seeker.unanswered);
  answer.fix = released([&] { return seeker.localizer->localize(*input.whole); });
  answer.budget_exhausted = budget.exhausted();
  return finished(std::move(answer), input.whole->sensor, work);
}

std::vector<Fix> judge(const Seeker& seeker, const Source& source, const py::object& T_map_query,
                       double last_m) {
  Work work(seeker.options);
  const std::vector<Eigen::Isometry3d> poses = posesOf(T_map_query, "T_map_query");
  const Budget budget(seeker.limits);
  tools::QueryInput input;
  std::vector<Localization> judged;
  const auto cut = cutByBudget([&] {
    input = queryOf(source, seeker.map->labels, last_m, work);
    judged = released([&] { return seeker.localizer->judge(*input.whole, poses); });
  });
  if (cut) judged.assign(poses.size(), *cut);
  if (!input.whole) input.whole.emplace().poses.emplace_back(Eigen::Isometry3d::Identity());
  const tools::Answer unanswered =
      tools::answerFor(input, {0, input.size()}, *input.whole, seeker.unanswered);
  std::vector<Fix> fixes;
  for (Localization& fix : judged) {
    tools::Answer answer = unanswered;
    answer.fix = std::move(fix);
    answer.budget_exhausted = budget.exhausted();
    fixes.push_back(finished(std::move(answer), input.whole->sensor, work));
  }
  return fixes;
}

py::list check(const Seeker& seeker, const Source& source, const py::object& T_map_query,
               double reach_m, double last_m) {
  Work work(seeker.options);
  const std::vector<Eigen::Isometry3d> poses = posesOf(T_map_query, "T_map_query");
  const Budget budget(seeker.limits);
  std::vector<PoseCheck> checked;
  const auto cut = cutByBudget([&] {
    const tools::QueryInput input = queryOf(source, seeker.map->labels, last_m, work);
    checked = released([&] { return seeker.localizer->check(*input.whole, poses, reach_m); });
  });
  if (cut) throw Error("the query", cut->reason);
  py::list list;
  for (const PoseCheck& place : checked) {
    py::dict item;
    item["T_map_query"] = arrayOf<4, 4>(place.T_map_query.matrix());
    item["score"] = place.evidence.score;
    item["expected"] = place.evidence.expected;
    item["map_coverage"] = place.evidence.map_coverage;
    list.append(item);
  }
  work.takeNotes();
  return list;
}

/// Every window of a recording in order, as `xview localize --window` answers them.
std::vector<Fix> localizeWindows(const Seeker& seeker, const Recording& recording, int window,
                                 int stride, const py::object& on_fix) {
  if (window < 1) throw UsageError(fmt::format("window = {}, must be >= 1", window));
  if (stride < 0) throw UsageError(fmt::format("stride = {}, must be >= 0", stride));
  Work work(seeker.options);
  work.job().limits = seeker.limits;
  const tools::QueryInput input = openRecording(recording, seeker.map->labels, work);
  return released([&] {
    requireKindOfDepth(*input.source);
    tools::logOwnDrive(*seeker.map, input.path, input.poses(), work.job().narrate);
    std::vector<Fix> fixes;
    const auto take = [&](const Query& query, const tools::Window& part) {
      tools::Answer answer = tools::answerFor(input, part, query, seeker.unanswered);
      answer.fix = seeker.localizer->localize(query);
      answer.budget_exhausted = exhaustedBudget();
      const py::gil_scoped_acquire gil;
      fixes.push_back(finished(std::move(answer), query.sensor, work));
      if (!on_fix.is_none()) on_fix(fixes.back());
    };
    tools::forEachWindow(input, tools::windowsOf(input.size(), window, stride), work.job(), take);
    return fixes;
  });
}

/// A robot that is followed, and the answers to it.
class FollowedRobot {
 public:
  FollowedRobot(Seeker seeker, int window)
      : seeker_(std::move(seeker)),
        window_(static_cast<std::size_t>(window)),
        follower_(*seeker_.localizer, {window, window}) {}

  std::optional<Fix> add(const py::object& points, const py::object& T_odom_sensor,
                         const py::object& stamp, const py::object& labels,
                         const py::object& classes) {
    const double stamp_s = stampOf(stamp);
    if (!py::isinstance<py::array>(points))
      throw UsageError("points: expected an array (N, 3), the scan of one moment");
    const Source source{points, labels, T_odom_sensor, py::none(), classes};
    const Recording recording = source.recording(&seeker_.map->labels);
    Work work(seeker_.options);
    const LabelSet known = labels.is_none() ? LabelSet() : recording.source->labels();
    FollowAnswer follow = released([&] {
      return follower_.withinBudget(seeker_.limits, [&] {
        Frame frame = recording.source->read(0);
        frame.number = static_cast<std::int64_t>(added_);
        frame.stamp_s = stamp_s;
        return follower_.add(std::move(frame), known);
      });
    });
    ++added_;
    const bool says_something = follow.window || !follow.budget_exhausted.empty() ||
                                (added_ % window_ == 0 && !follow.found());
    if (!says_something) return std::nullopt;
    return answered(std::move(follow), stamp_s, work);
  }

 private:
  /// What the window says, with the pose and the doubts of all that was seen before.
  Fix answered(FollowAnswer follow, double stamp_s, Work& work) const {
    tools::Answer answer = seeker_.unanswered;
    answer.input = "tracker";
    answer.budget_exhausted = std::move(follow.budget_exhausted);
    answer.frames = added_;
    answer.used_from = added_ - std::min(window_, added_);
    answer.last_index = added_ - 1;
    answer.first_frame = static_cast<std::int64_t>(answer.used_from);
    answer.last_frame = static_cast<std::int64_t>(answer.last_index);
    answer.last_stamp_s = stamp_s;
    if (follow.window) answer.fix = std::move(*follow.window);
    answer.track = TrackAnswer{{},
                               follow.was_expected,
                               follow.state == FollowAnswer::State::lost,
                               follow.expected_within_m,
                               follow.jump_m};
    if (follow.found()) {
      answer.fix.status = Status::accepted;
      answer.fix.reason_code = ReasonCode::accepted;
      answer.fix.T_map_sensor = follow.T_map_sensor;
      answer.fix.T_map_query = follow.T_map_odom;
      // Held: by itself the window may have found nothing.
      if (answer.fix.hypotheses.empty()) answer.fix.hypotheses.resize(1);
      answer.fix.hypotheses[0].T_map_query = follow.T_map_odom;
      answer.fix.covariance = follow.covariance;
      answer.fix.confidence = follow.confidence;
      answer.fix.reason = follow.reason;
    } else if (answer.fix.accepted() || answer.fix.reason.empty()) {
      answer.fix.status = Status::rejected;
      answer.fix.reason_code =
          answer.budget_exhausted.empty() ? ReasonCode::contradicted : ReasonCode::budget_exhausted;
      answer.fix.reason = follow.reason;
    }
    return finished(std::move(answer), Sensor::lidar, work);
  }

  Seeker seeker_;
  std::size_t window_, added_ = 0;
  Follower follower_;
};

py::list hypothesesOf(const Localization& fix) {
  py::list list;
  for (const Hypothesis& hypothesis : fix.hypotheses) {
    py::dict item;
    item["T_map_query"] = arrayOf<4, 4>(tools::inLengthsOfQuery(hypothesis.T_map_query, fix.scale));
    item["score"] = hypothesis.score;
    item["inliers"] = hypothesis.inliers;
    item["proposer"] = toString(hypothesis.proposer);
    list.append(item);
  }
  return list;
}

/// None where there is no hypothesis: nobody shall take an identity for a pose.
template <class Make>
py::object ifFound(const Fix& fix, Make&& make) {
  if (fix.answer->fix.hypotheses.empty()) return py::none();
  return make(fix.answer->fix);
}

Fix fixFrom(const std::string& line, std::vector<std::string> notes) {
  tools::Answer answer = tools::answerIn(line, "a Fix");
  if (!answer.error.empty()) throw Error("a Fix", "the query could not be read: " + answer.error);
  return {std::make_shared<const tools::Answer>(std::move(answer)), std::move(notes), line};
}

/// What a notebook shows: status, reason, and the pose if there is one.
std::string htmlOf(const Fix& fix) {
  const Localization& answer = fix.answer->fix;
  const char* const color = answer.accepted()                    ? "#168a3e"
                            : answer.status == Status::ambiguous ? "#b97000"
                                                                 : "#c82828";
  const auto escape = py::module_::import("html").attr("escape");
  std::string html = fmt::format("<b style=\"color:{}\">{}</b> {}", color, toString(answer.status),
                                 escape(tools::oneLine(answer.reason)).cast<std::string>());
  if (answer.hypotheses.empty()) return html;
  const Eigen::Vector3d p = answer.T_map_sensor.translation();
  html += fmt::format("<br>x {:.2f}, y {:.2f}, z {:.2f} m", p.x(), p.y(), p.z());
  html += fmt::format(", heading {:.1f}°", fix.answer->heading_rad * 180 / M_PI);
  if (answer.accepted() && !answer.covariance.isZero())
    html += fmt::format(", ±{:.2f} m", std::sqrt(answer.covariance.diagonal().head<3>().sum()));
  return html;
}

void bindFix(py::module_& module) {
  py::class_<Fix>(
      module, "Fix",
      "The answer to one query: a pose with a covariance, or a refusal with its reason. "
      "True if it is accepted. The pose is that of the best hypothesis, also if it was "
      "not accepted; without any hypothesis it is None.")
      .def("__bool__", [](const Fix& f) { return f.answer->fix.accepted(); })
      .def("__repr__",
           [](const Fix& f) {
             return fmt::format("<xview.Fix {}: {}>", toString(f.answer->fix.status),
                                tools::oneLine(f.answer->fix.reason));
           })
      .def("_repr_html_", &htmlOf)
      .def_property_readonly(
          "accepted", [](const Fix& f) { return f.answer->fix.accepted(); },
          "The pose is wrong with at most the chance that the localizer was asked for.")
      .def_property_readonly(
          "status", [](const Fix& f) { return toString(f.answer->fix.status); },
          "'accepted', 'ambiguous' (several places fit equally well) or 'rejected'.")
      .def_property_readonly(
          "reason", [](const Fix& f) { return tools::oneLine(f.answer->fix.reason); },
          "One sentence with the deciding numbers; what would move a terminal's cursor is escaped.")
      .def_property_readonly(
          "reason_code", [](const Fix& f) { return toString(f.answer->fix.reason_code); },
          "The reason for programs: 'accepted', 'ambiguous', 'out_of_map', 'too_short', "
          "'contradicted', 'not_converged', 'outside_prior', 'odometry_jump', 'budget_exhausted' "
          "or "
          "'not_comparable'.")
      .def_property_readonly(
          "budget_exhausted",
          [](const Fix& f) -> std::optional<std::string> {
            if (f.answer->budget_exhausted.empty()) return std::nullopt;
            return f.answer->budget_exhausted;
          },
          "'time' or 'memory' if that of the query ended before it was answered, else None.")
      .def_property_readonly(
          "confidence", [](const Fix& f) { return f.answer->fix.confidence; },
          "Share of right ones among answers with the same evidence, in [0, 1], if every other "
          "query "
          "is out of the map.")
      .def_property_readonly(
          "p_wrong", [](const Fix& f) { return 1 - f.answer->fix.confidence; },
          "1 - confidence: the chance that the pose is wrong.")
      .def_property_readonly(
          "T_map_query",
          [](const Fix& f) {
            return ifFound(f, [](const Localization& fix) -> py::object {
              return arrayOf<4, 4>(tools::inLengthsOfQuery(fix.T_map_query, fix.scale));
            });
          },
          "float64 (4, 4): p_map = T @ p_query, where the query frame is that of its odometry, or "
          "of its points [m].")
      .def_property_readonly(
          "T_map_sensor",
          [](const Fix& f) {
            return ifFound(f, [](const Localization& fix) -> py::object {
              return arrayOf<4, 4>(fix.T_map_sensor.matrix());
            });
          },
          "float64 (4, 4): the pose of the last frame in the map [m].")
      .def_property_readonly(
          "covariance",
          [](const Fix& f) {
            return ifFound(f, [](const Localization& fix) -> py::object {
              return arrayOf<6, 6>(fix.covariance);
            });
          },
          "float64 (6, 6) of T_map_sensor: x y z [m], rotation vector [rad], in the map frame.")
      .def_property_readonly(
          "hypotheses", [](const Fix& f) { return hypothesesOf(f.answer->fix); },
          "Distinct places, best first: dicts of T_map_query (4, 4), score [nats], inliers, "
          "proposer.")
      .def_property_readonly(
          "witnesses",
          [](const Fix& f) {
            const Witnesses& w = f.answer->fix.witnesses;
            py::dict witnesses;
            witnesses["place"] = w.place;
            witnesses["correspondences"] = w.correspondences;
            witnesses["dense"] = w.dense;
            return witnesses;
          },
          "What each witness says, as log odds of right against wrong.")
      .def_property_readonly(
          "scale", [](const Fix& f) { return f.answer->fix.scale; },
          "Length in the map over length in the query; 1 unless option scale was set.")
      .def_property_readonly(
          "inliers", [](const Fix& f) { return f.answer->fix.inliers; },
          "Query vertices with a partner of their class at the pose.")
      .def_property_readonly(
          "vertices", [](const Fix& f) { return f.answer->fix.vertices; },
          "Vertices of the query graph.")
      .def_property_readonly(
          "putative", [](const Fix& f) { return pairsOf(f.answer->fix.putative); },
          "Correspondences that were tried, uint32 (K, 2): vertex of the query, vertex of the map.")
      .def_property_readonly(
          "kept", [](const Fix& f) { return pairsOf(f.answer->fix.kept); },
          "Correspondences that the pose keeps, uint32 (K, 2).")
      .def_property_readonly(
          "trajectory", [](const Fix& f) { return arrayOf(f.answer->fix.trajectory); },
          "T_map_sensor of every frame of the query, float64 (N, 4, 4) [m]; N = 0 if its odometry "
          "was not bent to the map.")
      .def_property_readonly(
          "timing_ms",
          [](const Fix& f) {
            py::dict timing;
            for (const auto& [stage, ms] : f.answer->fix.timing_ms) timing[py::str(stage)] = ms;
            return timing;
          },
          "Milliseconds per stage.")
      .def_property_readonly(
          "notes", [](const Fix& f) { return f.notes; },
          "What was guessed or left out. The logger 'xview' has it, too, at level INFO.")
      .def(
          "to_json", [](const Fix& f) { return f.toJson(); },
          "The line that `xview localize --json` prints.")
      .def(
          "to_dict",
          [](const Fix& f) { return py::module_::import("json").attr("loads")(f.toJson()); },
          "The same as a dict.")
      .def_static(
          "from_json", [](const std::string& line) { return fixFrom(line, {}); }, py::arg("line"),
          "A Fix from a line of `xview localize --json` or of to_json(), which it gives back. It "
          "has no correspondences and no trajectory. Raises Error. A Fix can be pickled: it is "
          "this line, and its notes.")
      .def(py::pickle([](const Fix& f) { return py::make_tuple(f.toJson(), f.notes); },
                      [](const py::tuple& state) {
                        return fixFrom(state[0].cast<std::string>(),
                                       state[1].cast<std::vector<std::string>>());
                      }));
}

}  // namespace

void bindLocalize(py::module_& module) {
  bindFix(module);
  py::class_<Seeker>(module, "Localizer",
                     "Finds queries in one map. The search index is made once; localize() may be "
                     "called from several threads.")
      .def(py::init(&makeSeeker), py::arg("map"), py::arg("risk") = 0.01, py::kw_only(),
           py::arg("timeout") = 0.0, py::arg("max_memory") = 0.0,
           "risk: accepted is what is wrong with at most this chance, if every other query is out "
           "of the map, in [1e-9, 0.5]. timeout [s], max_memory [MB]: a query that takes more is "
           "rejected, and its budget_exhausted says which; 0 = no bound. Memory is bounded for the "
           "whole process, beyond what it has when the query begins. Options are those of `xview "
           "localize --help-all`, such as "
           "threads=1, method='walks', prior__near='10,20,50'. Raises UsageError.")
      .def(
          "localize",
          [](const Seeker& seeker, const py::object& query, const py::object& labels,
             const py::object& poses, const py::object& stamps, const py::object& classes,
             double last_m) {
            return localize(seeker, {query, labels, poses, stamps, classes}, last_m);
          },
          py::arg("query"), py::arg("labels") = py::none(), py::arg("poses") = py::none(),
          py::arg("stamps") = py::none(), py::arg("classes") = py::none(), py::kw_only(),
          py::arg("last_m") = tools::kLastMetres,
          "Where is the query in the map? It is an array of points (N, 3), float32 or float64 [m], "
          "z up, a list of them, or what read() returns. labels: class ids (N,) that mean what "
          "`classes` says, else what they mean in the map; without labels classes come from "
          "shapes. "
          "poses: T_odom_sensor (4, 4) per cloud [m], whose points are then in the frame of the "
          "sensor. A longer recording is found by its last `last_m` metres. A query that is not "
          "found is a Fix with a reason; raises Error where it cannot be read, UsageError where "
          "the arguments make no sense.")
      .def("localize_windows", &localizeWindows, py::arg("recording"), py::arg("window"),
           py::arg("stride") = 0, py::kw_only(), py::arg("on_fix") = py::none(),
           "A Fix for every window of `window` frames, `stride` frames apart (0: as long as the "
           "window). on_fix(fix) is called with each as it comes; what it raises ends the call.")
      .def(
          "check",
          [](const Seeker& seeker, const py::object& query, const py::object& T_map_query,
             const py::object& labels, const py::object& poses, const py::object& stamps,
             const py::object& classes, double reach_m, double last_m) {
            return check(seeker, {query, labels, poses, stamps, classes}, T_map_query, reach_m,
                         last_m);
          },
          py::arg("query"), py::arg("T_map_query"), py::arg("labels") = py::none(),
          py::arg("poses") = py::none(), py::arg("stamps") = py::none(),
          py::arg("classes") = py::none(), py::kw_only(), py::arg("reach_m") = 0.0,
          py::arg("last_m") = tools::kLastMetres,
          "What speaks for poses (K, 4, 4), or one (4, 4), of a query that were found otherwise, "
          "without a search: "
          "a dict for each with T_map_query (4, 4), the best pose at most reach_m away [m]; score, "
          "and what a true pose scores on average, expected [nats]; and map_coverage, the share of "
          "the query where the map knows anything. Raises as localize(), and UsageError with "
          "method='walks'.")
      .def(
          "judge",
          [](const Seeker& seeker, const py::object& query, const py::object& T_map_query,
             const py::object& labels, const py::object& poses, const py::object& stamps,
             const py::object& classes, double last_m) {
            return judge(seeker, {query, labels, poses, stamps, classes}, T_map_query, last_m);
          },
          py::arg("query"), py::arg("T_map_query"), py::arg("labels") = py::none(),
          py::arg("poses") = py::none(), py::arg("stamps") = py::none(),
          py::arg("classes") = py::none(), py::kw_only(), py::arg("last_m") = tools::kLastMetres,
          "A Fix for each of some poses (K, 4, 4), or of one (4, 4), of a query that were found "
          "otherwise: the answer "
          "of localize() if that finds the same pose, else the verdict on the best pose around, "
          "beside the places that the search finds. One that is more than two metres off, in "
          "rooms half a metre, is not accepted. Raises as check().")
      .def_property_readonly(
          "classes", [](const Seeker& s) { return namesOf(s.map->labels); },
          "Class ids and names of the map.");
  py::class_<FollowedRobot>(
      module, "Tracker",
      "Follows a robot, as `xview follow` does: scans speak together until it is found; then the "
      "odometry says where it is expected, and doubts add up. A jump of the odometry, a scan that "
      "does not fit, or 20 m without an accepted window lose it.")
      .def(py::init([](const Seeker& localizer, int window) {
             if (window < 1) throw UsageError(fmt::format("window = {}, must be >= 1", window));
             return std::make_unique<FollowedRobot>(localizer, window);
           }),
           py::arg("localizer"), py::arg("window") = 1, "window: number of frames of one query.")
      .def("add", &FollowedRobot::add, py::arg("points"), py::arg("T_odom_sensor"),
           py::arg("stamp") = 0.0, py::arg("labels") = py::none(), py::arg("classes") = py::none(),
           "Adds a scan as it comes: points (N, 3) in the frame of the sensor [m], its odometry "
           "pose "
           "(4, 4) and its time [s]. Returns a Fix after every `window` scans, else None.");
}

}  // namespace xview::python
