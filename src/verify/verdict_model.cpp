// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "xview/types/error.h"
#include "xview/verify/verdict.h"

namespace xview::verify {

/// Contents of config/verdict.txt, compiled in.
extern const char* const kDefaultVerdictModel;

namespace {

constexpr double kRidge = 1e-4;  ///< of standardised weights, per answer
constexpr int kNewtonSteps = 50;

constexpr std::array<const char*, kTerms> kTermNames = {
    "constant",     "agreement", "lead",         "known",     "excess",
    "settled",      "standing",  "shown",        "missing",   "contradicted",
    "seen_through", "margin",    "margin_there", "log_margin"};

/// Every weight beside its name in files.
template <class Model, class Visit>
void forWeights(Model& model, const Visit& visit) {
  const auto all = [&](const std::string& name, auto& weights,
                       std::initializer_list<Term> of_such_evidence) {
    for (const Term t : of_such_evidence) visit(name + kTermNames[t], weights[t]);
  };
  all("alone.", model.alone, {kConstant, kAgreement, kLead});
  all("registered.", model.registered,
      {kConstant, kKnown, kExcess, kSeenThrough, kMargin, kMarginThere});
  all("shown.", model.shown,
      {kConstant, kKnown, kSettled, kStanding, kShown, kMissing, kContradicted, kSeenThrough,
       kLogMargin});
  all("air.", model.air, {kConstant, kKnown, kExcess, kShown, kContradicted, kMargin});
}

VerdictModel parse(const std::string& text, const std::string& path) {
  std::map<std::string, double> numbers;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name, more;
    double value = 0;
    if (!(words >> name)) continue;
    if (!(words >> value) || words >> more || !std::isfinite(value))
      throw Error(fmt::format("{}:{}", path, number), "expected a name and a number");
    numbers[name] = value;
  }
  VerdictModel model;
  forWeights(model, [&](const std::string& name, double& value) {
    const auto found = numbers.find(name);
    if (found == numbers.end()) throw Error(path, fmt::format("has no line for {}", name));
    value = found->second;
    numbers.erase(found);
  });
  if (!numbers.empty())
    throw Error(path, fmt::format("has a line for {}, which the model does not know",
                                  numbers.begin()->first));
  return model;
}

/// Logistic regression by Fisher scoring, right and wrong answers weighing the same in all. Rows
/// are answers, and their first column is 1. `against`: odds against each that nothing here
/// explains.
Eigen::VectorXd fitLogistic(const Eigen::MatrixXd& rows, const std::vector<bool>& right,
                            const std::vector<double>& against) {
  const auto n = static_cast<double>(right.size());
  const auto rights = static_cast<double>(std::count(right.begin(), right.end(), true));
  if (rights == 0 || rights == n)
    throw Error("verdict", "needs right and wrong answers of each kind to learn from");
  const Eigen::RowVectorXd mean = rows.colwise().mean();
  Eigen::RowVectorXd spread = ((rows.rowwise() - mean).colwise().squaredNorm() / n).cwiseSqrt();
  Eigen::MatrixXd X = rows;
  for (Eigen::Index c = 1; c < X.cols(); ++c) {
    if (!(spread[c] > 1e-9)) spread[c] = 1;
    X.col(c) = (X.col(c).array() - mean[c]) / spread[c];
  }
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(X.cols());
  for (int step = 0; step < kNewtonSteps; ++step) {
    Eigen::VectorXd gradient = kRidge * n * beta;
    Eigen::MatrixXd H = kRidge * n * Eigen::MatrixXd::Identity(X.cols(), X.cols());
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
      // With the odds against, explained + a, p = 1 / (1 + odds) and dp / dx = p^2 explained.
      const double explained = std::exp(-std::clamp<double>(X.row(i).dot(beta), -30, 30));
      const double odds = explained + against[i], p = 1 / (1 + odds);
      const double weight = right[i] ? 0.5 * n / rights : 0.5 * n / (n - rights);
      gradient += weight * explained * (right[i] ? -p : p / odds) * X.row(i).transpose();
      H += weight * std::max(1e-9, std::pow(explained * p, 2) / odds) * X.row(i).transpose() *
           X.row(i);
    }
    const Eigen::VectorXd move = H.ldlt().solve(gradient);
    beta -= move / std::max(1.0, move.norm() / 2);
    if (move.norm() < 1e-10) break;
  }
  for (Eigen::Index c = 1; c < X.cols(); ++c) {
    beta[c] /= spread[c];
    beta[0] -= beta[c] * mean[c];
  }
  return beta;
}

}  // namespace

std::string toText(const VerdictModel& model) {
  std::string text =
      "# log odds of right against wrong; see include/xview/verify/verdict.h; made by xview learn "
      "--verdict\n";
  forWeights(model, [&](const std::string& name, double value) {
    text += fmt::format("{} {:.4g}\n", name, value);
  });
  return text;
}

const VerdictModel& defaultVerdictModel() {
  static const VerdictModel model = parse(kDefaultVerdictModel, "config/verdict.txt");
  return model;
}

VerdictModel readVerdictModel(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) throw Error(path, "cannot be read as a verdict model");
  return parse(text.str(), path);
}

VerdictModel verdictModelOf(const VerdictOptions& options) {
  return options.model.empty() ? defaultVerdictModel() : readVerdictModel(options.model);
}

VerdictModel fitVerdictModel(const std::vector<JudgedStatistics>& answers) {
  const auto fit = [&](const auto& evidence, auto& weights) {
    std::vector<std::array<double, kTerms>> terms;
    std::vector<bool> right;
    std::vector<double> against;
    for (const JudgedStatistics& a : answers) {
      const std::optional<Statistics> known = evidence(a.statistics);
      if (!known) continue;
      terms.push_back(termsOf(*known));
      right.push_back(a.right);
      against.push_back(oddsAgainst(*known));
    }
    if (right.empty() && !answers.empty()) return;  // nothing new is known of such answers
    Eigen::MatrixXd rows(terms.size(), weights.size());
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      for (Eigen::Index t = 0; t < rows.cols(); ++t) rows(i, t) = terms[i][t];
    }
    const Eigen::VectorXd fitted = fitLogistic(rows, right, against);
    std::copy(fitted.begin(), fitted.end(), weights.begin());
  };
  using Known = std::optional<Statistics>;
  VerdictModel model = defaultVerdictModel();
  const auto alone = [](Statistics s) {
    s.dense.of = DenseEvidence::Of::nothing;
    return Known(s);
  };
  fit(alone, model.alone);
  fit(
      [](const Statistics& s) {
        return s.dense.registered() && !s.dense.shown ? Known(s) : std::nullopt;
      },
      model.registered);
  const auto shownFrom = [](bool air) {
    return [air](const Statistics& s) {
      return s.dense.registered() && s.dense.shown && s.dense.aerial == air ? Known(s)
                                                                            : std::nullopt;
    };
  };
  fit(shownFrom(false), model.shown);
  fit(shownFrom(true), model.air);
  return model;
}

}  // namespace xview::verify
