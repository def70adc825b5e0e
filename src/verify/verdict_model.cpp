// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
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

/// An answer as the regression sees it.
struct Sample {
  std::array<double, kTerms> terms;
  double against = 0;  ///< odds against it that nothing here explains
  bool right = false;
  double weight = 1;

  double logOdds(const std::array<double, kTerms>& weights) const {
    return std::inner_product(terms.begin(), terms.end(), weights.begin(), 0.0);
  }
};

/// Right and wrong answers weigh the same in all.
void setWeights(std::vector<Sample>& samples) {
  const auto n = static_cast<double>(samples.size());
  const auto rights = static_cast<double>(std::count_if(
      samples.begin(), samples.end(), [](const Sample& sample) { return sample.right; }));
  if (rights == 0 || rights == n)
    throw Error("verdict", "needs right and wrong answers of each kind to learn from");
  for (Sample& sample : samples) sample.weight = 0.5 * n / (sample.right ? rights : n - rights);
}

/// By Fisher scoring: the weights of columns that make the samples likeliest, beside the log odds
/// that they have already. The ridge is of the weights as they are given.
Eigen::VectorXd fitLogistic(const Eigen::MatrixXd& columns, const Eigen::VectorXd& before,
                            const std::vector<Sample>& samples, double ridge) {
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(columns.cols());
  for (int step = 0; step < kNewtonSteps; ++step) {
    Eigen::VectorXd gradient = ridge * beta;
    Eigen::MatrixXd H = ridge * Eigen::MatrixXd::Identity(columns.cols(), columns.cols());
    for (Eigen::Index i = 0; i < columns.rows(); ++i) {
      // With the odds against, explained + a, p = 1 / (1 + odds) and dp / dx = p^2 explained.
      const Sample& sample = samples[i];
      const double log_odds = before[i] + columns.row(i).dot(beta);
      const double explained = std::exp(-std::clamp<double>(log_odds, -30, 30));
      const double odds = explained + sample.against, p = 1 / (1 + odds);
      gradient +=
          sample.weight * explained * (sample.right ? -p : p / odds) * columns.row(i).transpose();
      H += sample.weight * std::max(1e-9, std::pow(explained * p, 2) / odds) *
           columns.row(i).transpose() * columns.row(i);
    }
    const Eigen::VectorXd move = H.ldlt().solve(gradient);
    beta -= move / std::max(1.0, move.norm() / 2);
    if (move.norm() < 1e-10) break;
  }
  return beta;
}

/// The weights of all terms.
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
  Eigen::VectorXd beta =
      fitLogistic(columns, Eigen::VectorXd::Zero(columns.rows()), samples, kRidge * n);
  for (Eigen::Index c = 1; c < columns.cols(); ++c) {
    beta[c] /= spread[c];
    beta[kConstant] -= beta[c] * mean[c];
  }
  std::array<double, kTerms> weights{};
  std::copy(beta.begin(), beta.end(), weights.begin());
  return weights;
}

/// What the constant lacks so that answers that are nearly sure are right as often as they say:
/// sums of witnesses err most where all of them agree, and there it is decided.
double shiftOfSure(const std::array<double, kTerms>& weights, const std::vector<Sample>& samples) {
  constexpr double kSure = 0.95, kRidgeOfShift = 1;
  std::vector<Sample> sure;
  std::vector<double> log_odds;
  for (const Sample& sample : samples) {
    const double x = sample.logOdds(weights);
    if (1 / (1 + std::exp(-x) + sample.against) < kSure) continue;
    sure.push_back(sample);
    log_odds.push_back(x);
  }
  const auto n = static_cast<Eigen::Index>(sure.size());
  return fitLogistic(Eigen::MatrixXd::Ones(n, 1),
                     Eigen::Map<const Eigen::VectorXd>(log_odds.data(), n), sure, kRidgeOfShift)[0];
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
    std::vector<Sample> samples;
    for (const JudgedStatistics& a : answers) {
      if (const std::optional<Statistics> known = evidence(a.statistics))
        samples.push_back({termsOf(*known), oddsAgainst(*known), a.right});
    }
    if (samples.empty() && !answers.empty()) return;  // nothing new is known of such answers
    setWeights(samples);
    weights = fitTerms(samples);
    weights[kConstant] += shiftOfSure(weights, samples);
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
