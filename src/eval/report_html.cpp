// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "xview/eval/report.h"
#include "xview/eval/statistics.h"

namespace xview {
namespace {

constexpr double kDegrees = 57.29577951308232;

const char* const kHead =
    R"(<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>xview evaluation</title><style>
body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1100px;padding:0 1em;color:#222;background:#fff}
pre{background:#f4f4f4;padding:1em;overflow:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}td,th{padding:.15em .7em;text-align:right;border-bottom:1px solid #ddd}
td:first-child,th:first-child{text-align:left}.accepted{color:#16793a}.ambiguous{color:#a06800}.rejected{color:#b3261e}
figure{display:inline-block;margin:0 1em 1em 0}canvas{width:100%;height:560px;background:#111;border-radius:6px;cursor:grab}
</style></head><body><h1>xview evaluation</h1>
)";

// Points are projected with a turntable camera; nearer ones are drawn last only by luck, which is
// enough for a map.
const char* const kViewer = R"(<script>
(function(){const c=document.getElementById('scene'),g=c.getContext('2d');
let yaw=.6,pitch=.9,zoom=1,dx=0,dy=0,drag=null;
let r=1;for(const p of scene.points)r=Math.max(r,Math.hypot(p[0],p[1]));
for(const q of scene.queries)r=Math.max(r,Math.hypot(q.truth[0],q.truth[1]));
function project(p){const a=p[0]*Math.cos(yaw)-p[1]*Math.sin(yaw),b=p[0]*Math.sin(yaw)+p[1]*Math.cos(yaw),
 s=zoom*Math.min(c.width,c.height)*.48/r;return[c.width/2+dx+a*s,c.height/2+dy-(b*Math.sin(pitch)+p[2]*Math.cos(pitch))*s]}
function draw(){c.width=c.clientWidth;c.height=c.clientHeight;g.clearRect(0,0,c.width,c.height);
 for(const p of scene.points){const s=project(p);g.fillStyle='#'+p[3];g.fillRect(s[0],s[1],2,2)}
 for(const q of scene.queries){const t=project(q.truth);
  if(q.found){const f=project(q.found);g.strokeStyle=q.color;g.beginPath();g.moveTo(t[0],t[1]);g.lineTo(f[0],f[1]);g.stroke();
   g.fillStyle=q.color;g.fillRect(f[0]-3,f[1]-3,6,6)}
  g.strokeStyle='#fff';g.strokeRect(t[0]-4,t[1]-4,8,8)}}
c.onmousedown=e=>drag=[e.clientX,e.clientY,e.shiftKey||e.button>0];
window.addEventListener('mouseup',()=>drag=null);
window.addEventListener('mousemove',e=>{if(!drag)return;const x=e.clientX-drag[0],y=e.clientY-drag[1];
 if(drag[2]){dx+=x;dy+=y}else{yaw+=x*.008;pitch=Math.min(1.57,Math.max(0,pitch+y*.008))}drag[0]=e.clientX;drag[1]=e.clientY;draw()});
c.oncontextmenu=e=>e.preventDefault();
c.onwheel=e=>{e.preventDefault();zoom*=Math.exp(-e.deltaY*.001);draw()};
window.addEventListener('resize',draw);draw()})();
</script>)";

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

struct CurvePoint {
  double x = 0, y = 0;
};

/// A curve with values in [0, 1] over [0, x_max] as an SVG figure.
std::string figure(const std::string& title, const std::string& x_name, double x_max,
                   const std::vector<CurvePoint>& curve) {
  constexpr double kWidth = 460, kHeight = 280, kLeft = 45, kBottom = 40, kTop = 10;
  const auto px = [&](double x) { return kLeft + (kWidth - kLeft - 10) * x / x_max; };
  const auto py = [&](double y) { return kHeight - kBottom - (kHeight - kBottom - kTop) * y; };
  std::string svg =
      fmt::format("<figure><svg width=\"{}\" height=\"{}\" font-size=\"12\">", kWidth, kHeight);
  for (int i = 0; i <= 5; ++i) {
    const double y = 0.2 * i, x = x_max * 0.2 * i;
    svg += fmt::format(
        "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ddd\"/>", px(0),
        px(x_max), py(y), py(y));
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.1f}</text>",
                       px(0) - 6, py(y) + 4, y);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.3g}</text>",
                       px(x), py(0) + 16, x);
  }
  svg += fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text><polyline fill=\"none\" "
      "stroke=\"#1560bd\" stroke-width=\"2\" points=\"",
      px(x_max / 2), kHeight - 6, x_name);
  for (const CurvePoint& p : curve) svg += fmt::format("{:.2f},{:.2f} ", px(p.x), py(p.y));
  return svg + "\"/></svg><figcaption>" + title + "</figcaption></figure>\n";
}

std::string curves(const Evaluation& evaluation, const std::vector<ScoredQuery>& queries) {
  std::vector<double> errors;
  for (const ScoredQuery& query : queries) {
    if (!query.negative) errors.push_back(query.positionError());
  }
  std::vector<CurvePoint> success, recall;
  for (int i = 0; i <= 300 && !errors.empty(); ++i)
    success.push_back({0.1 * i, shareWithin(errors, 0.1 * i, errors.size())});
  for (const PrecisionRecall& point : evaluation.curve)
    recall.push_back({point.recall, point.precision});
  return figure("Success rate of the best hypothesis over the distance", "distance [m]", 30,
                success) +
         figure("Precision over recall, threshold on the confidence", "recall", 1, recall);
}

std::string queryTable(const std::vector<ScoredQuery>& queries) {
  std::string html =
      "<table><tr><th>query</th><th>frames</th><th>status</th><th>confidence</th><th>error [m]</th>"
      "<th>error [deg]</th><th>ms</th></tr>\n";
  for (const ScoredQuery& q : queries) {
    const bool measured = q.has_pose && !q.negative;
    html += fmt::format(
        "<tr><td>{}{}</td><td>{}-{}</td><td "
        "class=\"{}\">{}</td><td>{:.4f}</td><td>{}</td><td>{}</td>"
        "<td>{:.1f}</td></tr>\n",
        escaped(q.input), q.negative ? " (from elsewhere)" : "", q.first_frame, q.last_frame,
        toString(q.status), toString(q.status), q.confidence,
        measured ? fmt::format("{:.3f}", q.positionError()) : "-",
        measured ? fmt::format("{:.3f}", kDegrees * q.rotationError()) : "-", q.totalMs());
  }
  return html + "</table>\n";
}

const char* colorOf(Status status) {
  switch (status) {
    case Status::accepted:
      return "#3ddc84";
    case Status::ambiguous:
      return "#ffb300";
    default:
      return "#ff5252";
  }
}

Eigen::Vector3d centreOf(const std::vector<ScoredQuery>& queries,
                         const std::vector<ReportPoint>& map) {
  Eigen::AlignedBox3d box;
  for (const ReportPoint& p : map) box.extend(Eigen::Vector3d(p.x, p.y, p.z));
  for (const ScoredQuery& q : queries) {
    if (!q.negative) box.extend(q.truth.translation());
  }
  return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.center());
}

std::string triple(const Eigen::Vector3d& p) {
  return fmt::format("[{:.2f},{:.2f},{:.2f}]", p.x(), p.y(), p.z());
}

std::string sceneData(const std::vector<ScoredQuery>& queries,
                      const std::vector<ReportPoint>& map) {
  const Eigen::Vector3d centre = centreOf(queries, map);
  std::string data = "<script>const scene={points:[";
  for (const ReportPoint& p : map) {
    data += fmt::format("[{:.2f},{:.2f},{:.2f},'{:06x}'],", p.x - centre.x(), p.y - centre.y(),
                        p.z - centre.z(), p.rgb & 0xFFFFFFu);
  }
  data += "],queries:[";
  for (const ScoredQuery& q : queries) {
    if (q.negative) continue;
    data += fmt::format("{{truth:{},found:{},color:'{}'}},", triple(q.truth.translation() - centre),
                        q.has_pose ? triple(q.estimate.translation() - centre) : "null",
                        colorOf(q.status));
  }
  return data + "]};</script>\n";
}

}  // namespace

std::string reportHtml(const Evaluation& evaluation, const std::vector<ScoredQuery>& queries,
                       const std::vector<ReportPoint>& map) {
  std::string html = kHead;
  html += "<pre>" + escaped(evaluationTable(evaluation)) + "</pre>\n" + curves(evaluation, queries);
  html +=
      "<h2>Map, queries and errors</h2><p>White frames: true positions. Filled squares: found "
      "positions; green accepted, "
      "yellow ambiguous, red rejected. Drag to turn, shift-drag to move, wheel to zoom.</p>"
      "<canvas id=\"scene\"></canvas>\n";
  html += sceneData(queries, map) + kViewer + "\n<h2>Queries</h2>\n" + queryTable(queries) +
          "</body></html>\n";
  return html;
}

}  // namespace xview
