// SPDX-License-Identifier: BSD-3-Clause
#include "request_rules.h"

#include <algorithm>
#include <cctype>
#include <regex>

#include "base/user_text.h"

namespace xview::tools {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool isNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// "[::1]" of "[::1]:80"; empty if there is anything else behind it.
std::string withoutPort(const std::string& host) {
  const std::size_t bracket = host.rfind(']');
  const std::size_t colon = host.find(':', bracket == std::string::npos ? 0 : bracket);
  if (colon == std::string::npos) return host;
  return isNumber(host.substr(colon + 1)) ? host.substr(0, colon) : "";
}

/// A page whose name was turned to this machine's address sends that name, and reads what comes.
void requireOwnHost(const httplib::Request& request, const Listening& where) {
  const std::string host = withoutPort(lower(request.get_header_value("Host")));
  const bool is_own = host == "localhost" || host == "127.0.0.1" || host == "[::1]" ||
                      host == where.address || host == request.local_addr;
  if (host.empty() || !is_own || request.get_header_value_count("Host") != 1)
    throw Refusal{421, "the header Host must be localhost or the address that is listened on"};
}

/// A page can send without leave; its browser says whose it is.
void requireOwnOrigin(const httplib::Request& request) {
  const std::size_t count = request.get_header_value_count("Origin");
  if (count == 0) return;
  const std::string own = "http://" + lower(request.get_header_value("Host"));
  if (count > 1 || lower(request.get_header_value("Origin")) != own)
    throw Refusal{403, "the request is of a page of another origin"};
}

void requireKnownCoding(const httplib::Request& request) {
  const std::string type = lower(request.get_header_value("Content-Type"));
  if (type.rfind("multipart/", 0) == 0 && !request.is_multipart_form_data())
    throw Refusal{415, "of multipart bodies multipart/form-data with one file is read"};
  const std::string coding = request.get_header_value("Content-Encoding");
  const bool is_known = coding.empty() || coding == "identity" || coding == "gzip" ||
                        coding == "deflate" || coding == "br";
  if (!is_known)
    throw Refusal{415, "expected Content-Encoding gzip, deflate, br or none, found " + coding};
  const std::string transfer = lower(request.get_header_value("Transfer-Encoding"));
  if (request.get_header_value_count("Transfer-Encoding") > 1 ||
      (!transfer.empty() && transfer != "chunked"))
    throw Refusal{501, "expected Transfer-Encoding chunked or none"};
}

void requireLength(const httplib::Request& request, std::size_t most_body) {
  const std::size_t count = request.get_header_value_count("Content-Length");
  if (count == 0) return;
  if (count > 1 || request.has_header("Transfer-Encoding"))
    throw Refusal{400, "the length of the body is given twice"};
  const std::string text = request.get_header_value("Content-Length");
  if (!isNumber(text)) throw Refusal{400, "Content-Length is no number"};
  const auto length = numberFrom<std::size_t>(text);
  if (!length || *length > most_body) throw Refusal{413, "the body is larger than --max-body"};
}

/// What is asked for and would not be heeded is refused: an answer without it looks like one.
void requireKnownParameters(const httplib::Request& request) {
  const bool is_track = request.path.rfind("/track/", 0) == 0;
  for (const auto& [name, value] : request.params) {
    if (name == "name" || (is_track && name == "pose")) continue;
    throw Refusal{400, "no parameter " + name.substr(0, 60) + "; this route takes " +
                           (is_track ? "name and pose" : "name") +
                           ", and flags of xview serve tell how to look"};
  }
}

}  // namespace

std::string methodsOf(const std::string& path) {
  static const std::regex track(kTrackRoute);
  if (std::regex_match(path, track)) return "POST, DELETE";
  if (path == "/localize") return "POST";
  const bool is_told = path == "/health" || path == "/metrics" || path == "/openapi.json";
  return is_told ? "GET" : "";
}

void requireAnswerable(const httplib::Request& request, const Listening& where,
                       std::size_t most_body) {
  if (where.socket.empty()) {
    requireOwnHost(request, where);
    requireOwnOrigin(request);
  }
  const std::string methods = methodsOf(request.path);
  if (methods.empty()) throw Refusal{404, "no such route; see /openapi.json"};
  const std::string asked = request.method == "HEAD" ? "GET" : request.method;
  if (asked.empty() || methods.find(asked) == std::string::npos)
    throw Refusal{405, "the method of this route is " + methods};
  if (asked != "POST") return;
  requireKnownParameters(request);
  requireKnownCoding(request);
  requireLength(request, most_body);
}

const char* openApi() {
  return R"({"openapi":"3.0.3","info":{"title":"xview serve","version":"1"},"paths":{)"
         R"("/localize":{"post":{"summary":"where is this cloud (PCD, PLY, LAS, KITTI scan), graph or map in the map?","parameters":[{"name":"name","in":"query","description":"file name, whose ending tells the kind","schema":{"type":"string"}}],)"
         R"("requestBody":{"content":{"application/octet-stream":{},"multipart/form-data":{"schema":{"type":"object","properties":{"file":{"type":"string","format":"binary"}}}}}},)"
         R"("responses":{"200":{"description":"the JSON of xview localize --json"},"400":{"description":"not read"},"403":{"description":"of a page of another origin"},"405":{"description":"another method"},"408":{"description":"came too slowly"},"413":{"description":"too large"},"414":{"description":"URI too long"},"415":{"description":"unknown coding"},"421":{"description":"the Host is another one"},"431":{"description":"head too large"},"503":{"description":"busy"},"507":{"description":"no room for the body"}}}},)"
         R"("/track/{id}":{"post":{"summary":"the next frame of a robot","parameters":[{"name":"id","in":"path","required":true,"schema":{"type":"string"}},{"name":"name","in":"query","description":"file name, whose ending tells the kind","schema":{"type":"string"}},{"name":"pose","in":"query","description":"stamp tx ty tz qx qy qz qw of the odometry; or the header X-Pose","schema":{"type":"string"}}],"responses":{"200":{"description":"a line of xview follow"}}},)"
         R"("delete":{"summary":"forget a robot: its next frame is looked for in the whole map","parameters":[{"name":"id","in":"path","required":true,"schema":{"type":"string"}}],"responses":{"200":{"description":"forgotten"},"404":{"description":"no robot of this name is followed"}}}},)"
         R"("/health":{"get":{"responses":{"200":{"description":"status ok, busy or, if a query takes longer than it may, stuck; running, jobs, stuck: how many queries; longest_s: of the one that runs longest"},"503":{"description":"stuck: every query at work takes longer than twice its --timeout, without one the --patience"}}}},)"
         R"("/metrics":{"get":{"responses":{"200":{"description":"Prometheus text"}}}},"/openapi.json":{"get":{"responses":{"200":{"description":"this"}}}}}})"
         "\n";
}

}  // namespace xview::tools
