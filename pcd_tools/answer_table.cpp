// SPDX-License-Identifier: BSD-3-Clause
#include "answer_table.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>

#include "base/median.h"
#include "base/user_text.h"
#include "io/bag_files.h"
#include "terminal.h"

namespace xview::tools {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr std::size_t kFrames = 10, kStatus = 13, kSigma = 15, kTime = 8, kYaw = 9, kChance = 8;
constexpr std::size_t kWide = 110;  ///< from here on nothing is left out of the numbers
constexpr std::size_t kEndless = 100000;
constexpr std::size_t kShortestReason = 24, kLongReason = 60;
constexpr std::size_t kLongName = 24;  ///< from here on, on a terminal, reasons need the room

/// How a status looks, in the order of Status.
struct StatusLook {
  const char* mark;
  Ink ink;
};
constexpr StatusLook kLooks[] = {{"✔", Ink::green}, {"?", Ink::amber}, {"✘", Ink::red}};

/// What is unusual about the frame of the query.
std::string frameOf(const Localization& fix) {
  std::string text = fix.scale == 1 ? "" : fmt::format("; scale {:.3f}", fix.scale);
  if (fix.gravity != GravityUse::aligned) text += fmt::format("; {}", toString(fix.gravity));
  return text;
}

/// Zero has no sign.
std::string withDigits(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text[0] == '-' && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

/// " 30-59", of a recording of several frames.
std::string framesOf(const Answer& answer) {
  if (answer.frames < 2) return "";
  return fmt::format(" {}-{}", answer.first_frame, answer.last_frame);
}

/// "rear" of "town/rear/"
std::string lastName(const std::string& path) {
  const std::filesystem::path normal = std::filesystem::path(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).filename().string();
}

bool mayHaveFrames(const std::string& query) {
  return std::filesystem::is_directory(query) || io::isBag(query);
}

std::string timeText(double ms) { return fmt::format("{:.{}f} s", ms / 1e3, ms < 1e4 ? 2 : 1); }

std::string sigmaText(const Matrix6d& covariance) {
  if (covariance.isZero()) return "";
  const double turn = kDegrees * std::sqrt(std::max(0.0, covariance(5, 5)));
  return "±" + lengthText(positionSigma(covariance)) +
         rightAligned(fmt::format("±{:.{}f}°", turn,
                                  turn < 0.095  ? 2
                                  : turn < 9.95 ? 1
                                                : 0),
                      7);
}

}  // namespace

double positionSigma(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance.topLeftCorner<3, 3>(),
                                                            Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues().z()));
}

std::string nameOf(const Answer& answer) { return answer.input + framesOf(answer); }

std::string chanceWrongText(double confidence) {
  constexpr double kDigits = 1e-9;  // 1 - 0.98 is a little more than 2 %
  const double percent = 100 * std::clamp(1 - confidence, 0.0, 1.0) - kDigits;
  if (percent < 0.1) return "<0.1 %";
  if (percent > 99) return ">99 %";
  return percent > 9.9 ? fmt::format("{:.0f} %", std::ceil(percent))
                       : fmt::format("{:.1f} %", std::ceil(10 * percent) / 10);
}

std::string lengthText(double length_m) {
  if (!std::isfinite(length_m)) return "?";
  if (length_m < 0.0095) return fmt::format("{:.0f} mm", 1e3 * length_m);
  if (length_m < 0.995) return fmt::format("{:.0f} cm", 1e2 * length_m);
  return fmt::format("{:.{}f} m", length_m, length_m < 9.95 ? 1 : 0);
}

AnswerTable::AnswerTable(const std::vector<std::string>& queries, double largest_m, bool is_single,
                         std::FILE* screen)
    : screen_(screen),
      width_(terminalWidth(screen).value_or(kEndless)),
      is_wide_(width_ >= kWide),
      is_single_(is_single) {
  coordinate_ = std::max<std::size_t>(9, fmt::format("  -{:.2f}", largest_m).size());
  const std::size_t taken =
      kStatus + 2 * coordinate_ + kYaw + kSigma + kTime + (is_wide_ ? coordinate_ + kChance : 0);
  const std::size_t room = width_ > taken + 8 ? width_ - taken : 8;
  const auto longest = [&] {
    std::size_t columns = 0;
    for (const std::string& query : queries)
      columns =
          std::max(columns, columnsOf(shownPath(query)) + (mayHaveFrames(query) ? kFrames : 0));
    return columns;
  };
  const std::size_t most = std::min(room, std::max(room / 2, kLongName));
  name_ = longest();
  if (name_ > (width_ == kEndless ? most : std::min(most, kLongName))) {
    std::set<std::string> names;
    for (const std::string& query : queries) names.insert(lastName(query));
    is_short_ = names.size() == queries.size();
    name_ = std::min(longest(), most);
  }
}

std::string AnswerTable::shownPath(const std::string& path) const {
  return printable(is_short_ ? lastName(path) : path);
}

std::string AnswerTable::heading() const {
  std::string text = padded("  status", kStatus) + padded("query", name_);
  text += rightAligned("x m", coordinate_) + rightAligned("y m", coordinate_);
  if (is_wide_) text += rightAligned("z m", coordinate_);
  text += rightAligned("heading", kYaw) + rightAligned("sigma", kSigma);
  if (is_wide_) text += rightAligned("wrong", kChance);
  text += rightAligned("time", kTime);
  if (width_ >= columnsOf(text) + 2 + kShortestReason) text += "  reason";
  return inked(text, Ink::dim, screen_) + "\n";
}

std::string AnswerTable::numbers(const Answer& answer) const {
  const Localization& fix = answer.fix;
  const bool is_placed = !fix.hypotheses.empty();
  const Eigen::Vector3d p = fix.T_map_sensor.translation();
  const auto cell = [&](const std::string& text, std::size_t columns) {
    return rightAligned(is_placed ? text : "-", columns);
  };
  std::string text;
  for (const int axis : {0, 1, 2}) {
    if (axis < 2 || is_wide_) text += cell(withDigits(p(axis), 2), coordinate_);
  }
  text += cell(withDigits(kDegrees * answer.heading_rad, 1) + "°", kYaw) +
          cell(sigmaText(fix.covariance), kSigma);
  if (is_wide_) text += cell(chanceWrongText(fix.confidence), kChance);
  return text + rightAligned(timeText(totalMs(fix.timing_ms)), kTime);
}

std::string AnswerTable::line(const Answer& answer) const {
  const Localization& fix = answer.fix;
  const StatusLook& look = kLooks[static_cast<int>(fix.status)];
  const std::string status = padded(fmt::format("{} {}", look.mark, toString(fix.status)), kStatus),
                    name = withoutBeginning(shownPath(answer.input) + framesOf(answer), name_);
  std::string text = inked(status, look.ink, screen_) + padded(name, name_);
  std::size_t column = kStatus + std::max(name_, columnsOf(name));
  if (fix.accepted() || width_ >= kWide + kLongReason) {
    const std::string values = numbers(answer);
    text += inked(values, fix.accepted() ? Ink::plain : Ink::dim, screen_);
    column += columnsOf(values);
  }
  const std::string reason = printable(fix.reason + frameOf(fix));
  const std::size_t room = width_ > column + 2 ? width_ - column - 2 : 0;
  if (room < kShortestReason) return text;
  if (is_single_ && !fix.accepted()) return text + "  " + wrapped(reason, room, column + 2);
  return text + "  " + withoutEnd(reason, room);
}

std::string AnswerTable::add(const Answer& answer) {
  if (answer.fix.accepted()) sigmas_m_.push_back(positionSigma(answer.fix.covariance));
  time_ms_ += totalMs(answer.fix.timing_ms);
  return (answers_++ == 0 ? heading() : "") + line(answer);
}

std::string AnswerTable::summary() const {
  std::string text = fmt::format("{} of {} accepted", sigmas_m_.size(), answers_);
  if (!sigmas_m_.empty()) text += ", median ±" + lengthText(medianOf(sigmas_m_));
  if (answers_ > 0)
    text += ", " + timeText(time_ms_ / static_cast<double>(answers_)) + " per query";
  if (answers_ > 0 && !is_wide_)
    text += fmt::format("; z and wrong: in {} columns or with --json", kWide);
  return text;
}

std::string csvHeading() {
  return "query,map,first_frame,last_frame,status,confidence,x,y,z,qx,qy,qz,qw,sigma_m,reason";
}

std::string toCsv(const Answer& answer) {
  const Localization& fix = answer.fix;
  const bool is_read = answer.error.empty();
  std::string text = fmt::format("{},{},", csvQuoted(answer.input), csvQuoted(answer.map));
  text += is_read ? fmt::format("{},{},{},{},", answer.first_frame, answer.last_frame,
                                toString(fix.status), fix.confidence)
                  : std::string(",,error,,");
  if (is_read && !fix.hypotheses.empty()) {
    const Eigen::Vector3d p = fix.T_map_sensor.translation();
    const Eigen::Quaterniond q(fix.T_map_sensor.linear());
    text += fmt::format("{},{},{},{},{},{},{},{},", p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w(),
                        positionSigma(fix.covariance));
  } else {
    text += ",,,,,,,,";
  }
  return text + csvQuoted(is_read ? fix.reason : answer.error);
}

}  // namespace xview::tools
