// SPDX-License-Identifier: BSD-3-Clause
#include "place/opencv_network.h"

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>

#include "xview/base/error.h"

namespace xview {
namespace {

/// OpenCV prints what it throws as well, and more than one line of it.
class QuietOpenCv {
 public:
  QuietOpenCv() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~QuietOpenCv() { cv::utils::logging::setLogLevel(before_); }
  QuietOpenCv(const QuietOpenCv&) = delete;
  QuietOpenCv& operator=(const QuietOpenCv&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

/// "layer Foo (node name)" if the message has it, else its first line.
std::string causeOf(const cv::Exception& e) {
  static const std::regex node(R"(\[(\w+)(?:@[\w.]+)?\]:\(([^)]*)\))");
  std::smatch match;
  const std::string message = e.what();
  if (std::regex_search(message, match, node))
    return "layer " + match[1].str() + " (" + match[2].str() + ") is none that OpenCV can run";
  return e.err.substr(0, e.err.find('\n'));
}

std::string shapeText(const cv::Mat& blob) {
  std::string text;
  for (int i = 0; i < blob.dims; ++i) text += (i == 0 ? "" : " x ") + std::to_string(blob.size[i]);
  return text;
}

/// The number of the best class of each pixel of 1 x classes x rows x columns.
cv::Mat bestClasses(const cv::Mat& scores, int width, int height) {
  const int classes = scores.size[1];
  cv::Mat best, best_score, resized;
  for (int c = 0; c < classes; ++c) {
    const cv::Mat plane(scores.size[2], scores.size[3], CV_32F,
                        const_cast<float*>(scores.ptr<float>(0, c)));
    cv::resize(plane, resized, cv::Size(width, height), 0, 0, cv::INTER_LINEAR);
    if (c == 0) {
      best = cv::Mat::zeros(height, width, CV_32S);
      best_score = resized.clone();
      continue;
    }
    const cv::Mat better = resized > best_score;
    resized.copyTo(best_score, better);
    best.setTo(c, better);
  }
  return best;
}

/// Class numbers as they stand in 1 x 1 x rows x columns, or with fewer leading dimensions.
cv::Mat statedClasses(const cv::Mat& output, int width, int height) {
  const int rows = output.size[output.dims - 2], columns = output.size[output.dims - 1];
  cv::Mat numbers, resized;
  cv::Mat(rows, columns, output.type(), const_cast<uchar*>(output.ptr()))
      .convertTo(numbers, CV_32S);
  numbers.convertTo(numbers, CV_32F);  // what cv::resize knows; classes are small numbers
  cv::resize(numbers, resized, cv::Size(width, height), 0, 0, cv::INTER_NEAREST);
  resized.convertTo(resized, CV_32S);
  return resized;
}

class OpenCvNetwork final : public Network {
 public:
  OpenCvNetwork(const std::string& model_path, NetworkInput input);
  LabelImage label(const ColorImage& image, int width, int height) override;

 private:
  cv::Mat blobOf(const ColorImage& image) const {
    const cv::Mat pixels(image.height, image.width, CV_8UC3,
                         const_cast<std::uint8_t*>(image.pixels[0].data()));
    const cv::Size size(input_.width > 0 ? input_.width : image.width,
                        input_.height > 0 ? input_.height : image.height);
    cv::Mat resized;
    cv::resize(pixels, resized, size, 0, 0, cv::INTER_LINEAR);
    resized.convertTo(resized, CV_32FC3, 1.0 / 255);
    if (!input_.is_rgb) cv::cvtColor(resized, resized, cv::COLOR_RGB2BGR);
    const cv::Scalar mean(input_.mean[0], input_.mean[1], input_.mean[2]);
    const cv::Scalar deviation(input_.std[0], input_.std[1], input_.std[2]);
    cv::subtract(resized, mean, resized);
    cv::divide(resized, deviation, resized);
    return cv::dnn::blobFromImage(resized);
  }

  std::uint32_t idOf(int number) const {
    if (input_.ids.empty()) return static_cast<std::uint32_t>(std::max(0, number));
    if (number >= 0 && static_cast<std::size_t>(number) < input_.ids.size())
      return input_.ids[static_cast<std::size_t>(number)];
    throw Error(path_, "answers with class " + std::to_string(number) + ", but its configuration " +
                           "has ids for " + std::to_string(input_.ids.size()) + " classes");
  }

  std::string path_;
  NetworkInput input_;
  cv::dnn::Net net_;
};

OpenCvNetwork::OpenCvNetwork(const std::string& model_path, NetworkInput input)
    : path_(model_path), input_(std::move(input)) {
  const QuietOpenCv quiet;
  try {
    net_ = cv::dnn::readNet(model_path);
  } catch (const cv::Exception& e) {
    throw Error(model_path, "is no network that OpenCV can read: " + causeOf(e));
  }
  if (net_.empty()) throw Error(model_path, "has no layers");
}

LabelImage OpenCvNetwork::label(const ColorImage& image, int width, int height) {
  if (image.empty()) throw Error(path_, "was given an image without pixels");
  const QuietOpenCv quiet;
  cv::Mat output;
  try {
    net_.setInput(blobOf(image));
    output = net_.forward();
  } catch (const cv::Exception& e) {
    throw Error(path_, "cannot be run: " + causeOf(e));
  }
  const bool scores = output.dims == 4 && output.size[0] == 1 && output.size[1] > 1;
  const bool stated = output.dims >= 2 && !scores && output.size[output.dims - 2] > 1 &&
                      output.total() == static_cast<std::size_t>(output.size[output.dims - 1]) *
                                            output.size[output.dims - 2];
  if (!(scores && output.type() == CV_32F) && !stated) {
    throw Error(path_, "answers with " + shapeText(output) +
                           ", expected scores of 1 x classes x rows x columns, or one "
                           "channel of class numbers");
  }
  const std::size_t ids = input_.ids.size();
  if (scores && ids > 0 && static_cast<std::size_t>(output.size[1]) != ids) {
    throw Error(path_, "answers with " + shapeText(output) + ", 1 x classes x rows x " +
                           "columns, but its configuration has ids for " + std::to_string(ids) +
                           " classes");
  }
  const cv::Mat best =
      scores ? bestClasses(output, width, height) : statedClasses(output, width, height);
  LabelImage labels(width, height);
  for (int v = 0; v < height; ++v) {
    const int* row = best.ptr<int>(v);
    for (int u = 0; u < width; ++u) labels.at(u, v) = static_cast<std::uint16_t>(idOf(row[u]));
  }
  return labels;
}

}  // namespace
}  // namespace xview

xview::Network* xviewOpenNetwork(const std::string& model_path, const xview::NetworkInput& input) {
  return new xview::OpenCvNetwork(model_path, input);
}
