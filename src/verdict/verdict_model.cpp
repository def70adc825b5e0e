// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "verdict/verdict.h"
#include "xview/base/error.h"

namespace xview::verdict {

/// Contents of config/verdict.txt, compiled in.
extern const char* const kDefaultVerdictModel;

namespace {

constexpr double kRidge = 1e-3;  ///< of standardised weights, per answer
constexpr int kNewtonSteps = 50;

/// Which way a witness may count: more of it makes an answer likelier (+1), or less likely (-1).
constexpr int signOf(Term term) { return term == kWrongPlaceAboveNull ? -1 : 1; }

/// Every weight beside its name in files.
template <class Model, class Visit>
void forWeights(Model& model, const Visit& visit) {
  for (std::size_t t = 0; t < kTerms; ++t)
    visit(std::string("registered.") + toString(static_cast<Term>(t)), model.registered.of[t]);
  for (const Term t : {kConstant, kMargin})
    visit(std::string("bare.") + toString(t), model.bare[t]);
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

/// An answer as the regression sees it.
struct Sample {
  std::array<double, kTerms> terms;
  bool right = false;
  std::size_t group = 0;
  double weight = 1;

  double logOdds(const std::array<double, kTerms>& weights) const {
    return std::inner_product(terms.begin(), terms.end(), weights.begin(), 0.0);
  }
};

/// Right and wrong answers weigh the same in all. False if there are none of either.
bool setWeights(std::vector<Sample>& samples) {
  const auto n = static_cast<double>(samples.size());
  const auto rights = static_cast<double>(std::count_if(
      samples.begin(), samples.end(), [](const Sample& sample) { return sample.right; }));
  if (rights == 0 || rights == n) return false;
  for (Sample& sample : samples) sample.weight = 0.5 * n / (sample.right ? rights : n - rights);
  return true;
}

/// By Fisher scoring: the weights of columns that make the samples likeliest, with a ridge.
Eigen::VectorXd fitLogistic(const Eigen::MatrixXd& columns, const std::vector<Sample>& samples,
                            double ridge) {
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(columns.cols());
  for (int step = 0; step < kNewtonSteps; ++step) {
    Eigen::VectorXd gradient = ridge * beta;
    gradient[0] = 0;  // the constant is free
    Eigen::MatrixXd H = ridge * Eigen::MatrixXd::Identity(columns.cols(), columns.cols());
    for (Eigen::Index i = 0; i < columns.rows(); ++i) {
      const Sample& sample = samples[i];
      const double p = 1 / (1 + std::exp(-columns.row(i).dot(beta)));
      gradient += sample.weight * (p - (sample.right ? 1 : 0)) * columns.row(i).transpose();
      H +=
          sample.weight * std::max(1e-9, p * (1 - p)) * columns.row(i).transpose() * columns.row(i);
    }
    const Eigen::VectorXd move = H.ldlt().solve(gradient);
    beta -= move / std::max(1.0, move.norm() / 2);
    if (move.norm() < 1e-10) break;
  }
  return beta;
}

/// The weights of all terms. A term that would count the wrong way is left out.
std::array<double, kTerms> fitTerms(const std::vector<Sample>& samples) {
  const auto n = static_cast<double>(samples.size());
  Eigen::MatrixXd columns(samples.size(), kTerms);
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    for (std::size_t t = 0; t < kTerms; ++t)
      columns(i, static_cast<Eigen::Index>(t)) = samples[i].terms[t];
  }
  const Eigen::RowVectorXd mean = columns.colwise().mean();
  Eigen::RowVectorXd spread = ((columns.rowwise() - mean).colwise().squaredNorm() / n).cwiseSqrt();
  for (Eigen::Index c = 1; c < columns.cols(); ++c) {
    if (!(spread[c] > 1e-9)) spread[c] = 1;
    columns.col(c) = (columns.col(c).array() - mean[c]) / spread[c];
  }
  Eigen::VectorXd beta;
  for (bool again = true; again;) {
    again = false;
    beta = fitLogistic(columns, samples, kRidge * n);
    for (Eigen::Index c = 1; c < columns.cols(); ++c) {
      if (!(beta[c] * signOf(static_cast<Term>(c)) < -1e-9)) continue;
      columns.col(c).setZero();
      again = true;
    }
  }
  for (Eigen::Index c = 1; c < columns.cols(); ++c) {
    beta[c] /= spread[c];
    beta[kConstant] -= beta[c] * mean[c];
  }
  std::array<double, kTerms> weights{};
  std::copy(beta.begin(), beta.end(), weights.begin());
  return weights;
}

/// Log odds of each sample by weights that the other groups set; by those of all where the others
/// have no right or no wrong ones.
std::vector<double> leftOutLogOdds(const std::vector<Sample>& samples,
                                   const std::array<double, kTerms>& of_all) {
  std::set<std::size_t> groups;
  for (const Sample& sample : samples) groups.insert(sample.group);
  std::vector<double> log_odds(samples.size());
  for (const std::size_t group : groups) {
    std::vector<Sample> others;
    std::copy_if(samples.begin(), samples.end(), std::back_inserter(others),
                 [&](const Sample& sample) { return sample.group != group; });
    const bool can_learn = setWeights(others);
    const std::array<double, kTerms> weights = can_learn ? fitTerms(others) : of_all;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (samples[i].group == group) log_odds[i] = samples[i].logOdds(weights);
    }
  }
  return log_odds;
}

/// The share of wrong samples among those that are at least as sure as the wrong sample of each
/// rank k, in log odds, fitted by a line over the log odds z of that sample; ranks from a few on to
/// a few per cent of all, weighted by k.
struct TailFit {
  double offset = 0, slope = 1;
};
TailFit fitTail(const std::vector<double>& z, const std::vector<Sample>& samples) {
  constexpr std::size_t kFirst = 3;
  constexpr double kMostShare = 0.03, kLeastSlope = 0.2, kMostSlope = 1.2;
  std::vector<double> right, wrong;
  for (std::size_t i = 0; i < z.size(); ++i) (samples[i].right ? right : wrong).push_back(z[i]);
  std::sort(right.begin(), right.end());
  std::sort(wrong.rbegin(), wrong.rend());
  const auto last =
      std::max<std::size_t>(kFirst + 2, static_cast<std::size_t>(kMostShare * wrong.size()));
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity() * 1e-9;
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (std::size_t k = kFirst; k <= std::min(last, wrong.size()); ++k) {
    const double at = wrong[k - 1];
    const auto above =
        static_cast<double>(right.end() - std::lower_bound(right.begin(), right.end(), at));
    if (above == 0) continue;
    const double log_odds =
        std::log(above / right.size()) - std::log(static_cast<double>(k) / wrong.size());
    const Eigen::Vector2d row(1, at);
    A += static_cast<double>(k) * row * row.transpose();
    b += static_cast<double>(k) * log_odds * row;
  }
  if (!(A(0, 0) > 1)) return {};
  const double slope = std::clamp(A.ldlt().solve(b)[1], kLeastSlope, kMostSlope);
  return {(b[0] - slope * A(0, 1)) / A(0, 0), slope};
}

/// Reserves in log odds, so large that at a risk of 0.01 none of 699 wrong answers about recordings
/// is accepted, and 2 of 1385 about bare graphs.
constexpr double kHeldBack = 1.7, kHeldBackBare = 1.2;

/// Weights whose log odds say what share of those answers is wrong that are at least as sure, of
/// groups that did not set them, less a reserve for makes of world and sensor that no group shows.
EvidenceWeights calibrated(const std::array<double, kTerms>& weights,
                           const std::vector<Sample>& samples, double held_back) {
  const TailFit tail = fitTail(leftOutLogOdds(samples, weights), samples);
  EvidenceWeights result{weights};
  for (double& weight : result.of) weight *= tail.slope;
  result[kConstant] += tail.offset - held_back;
  return result;
}

}  // namespace

const char* toString(Term term) {
  constexpr std::array<const char*, kTerms> kNames = {
      "constant",     "margin",     "inlier_ratio",          "overlap",
      "map_coverage", "free_space", "wrong_place_above_null"};
  return kNames[term];
}

std::string toText(const VerdictModel& model) {
  std::string text =
      "# log odds of right against wrong; see src/verdict/verdict.h; made by xview learn "
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
  VerdictModel model = defaultVerdictModel();
  for (const bool registered : {false, true}) {
    std::vector<Sample> samples;
    for (const JudgedStatistics& a : answers) {
      if (a.statistics.dense.registered() == registered)
        samples.push_back({termsOf(a.statistics), a.right, a.group});
    }
    if (samples.empty() && !answers.empty()) continue;  // nothing new is known of such answers
    if (!setWeights(samples))
      throw Error("verdict", "needs right and wrong answers of each kind to learn from");
    (registered ? model.registered : model.bare) =
        calibrated(fitTerms(samples), samples, registered ? kHeldBack : kHeldBackBare);
  }
  return model;
}

}  // namespace xview::verdict
