// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "answer.h"

namespace xview::tools {

/// Answers as people read them: one line each, in columns that are made once for all of them and
/// fit into the terminal. On a narrow one a reason takes the place of a pose that is not to be
/// believed; in a file or a pipe nothing is left out.
class AnswerTable {
 public:
  /// The names of the queries and the largest coordinate of the map [m] tell how wide columns are.
  /// `is_single`: there will be one line, so a long reason may go on below it.
  /// `screen`: where the lines go; null for a file.
  AnswerTable(const std::vector<std::string>& queries, double largest_m, bool is_single,
              std::FILE* screen);

  /// The lines of one more answer, with the heading before the first; no line break at the end.
  std::string add(const Answer& answer);
  /// "8 of 9 accepted, median ±2 cm, 0.12 s per query"
  std::string summary() const;

 private:
  std::string heading() const;
  /// The path, or its last name where there is no room for all of it and that is enough to tell
  /// queries apart.
  std::string shownPath(const std::string& path) const;
  std::string numbers(const Answer& answer) const;
  std::string line(const Answer& answer) const;

  std::FILE* screen_;
  std::size_t width_, name_ = 0, coordinate_ = 0;  ///< columns
  bool is_wide_, is_single_, is_short_ = false;
  std::size_t answers_ = 0;
  std::vector<double> sigmas_m_;  ///< of the accepted ones
  double time_ms_ = 0;
};

/// The heading of a table of answers, and the line of one: status, confidence, the pose of the last
/// frame in the map [m], the standard deviation of its position along the worst axis [m], reason.
/// Numbers are empty where there is no pose.
std::string csvHeading();
std::string toCsv(const Answer& answer);

/// The standard deviation of the position along its worst axis [m].
double positionSigma(const Matrix6d& covariance);

/// What was asked: the input, and which of its frames if it has several.
std::string nameOf(const Answer& answer);

/// How likely it is that an answer is wrong, rounded up: "<0.1 %", "1.7 %", "35 %", ">99 %". Rarer
/// than one in a thousand is no claim that was checked against as many answers.
std::string chanceWrongText(double confidence);

/// "8 mm", "2 cm", "1.3 m"
std::string lengthText(double length_m);

}  // namespace xview::tools
